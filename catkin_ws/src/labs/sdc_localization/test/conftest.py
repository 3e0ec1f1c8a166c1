from pathlib import Path

import pytest
import yaml

from sdc_localization.localizer import LocalizerSettings


@pytest.fixture
def settings():
    path = Path(__file__).resolve().parents[1] / "config" / "localizer.yaml"
    return LocalizerSettings.read(yaml.safe_load(path.read_text(encoding="utf-8")).__getitem__)
