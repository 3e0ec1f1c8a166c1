import pytest

from sdc_common.configuration import node_config
from sdc_localization.localizer import LocalizerSettings


@pytest.fixture
def settings():
    return LocalizerSettings.read(node_config("sdc_localization", "localizer").__getitem__)
