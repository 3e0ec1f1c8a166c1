"""The documentation site: it has every page, no broken link, and the classes' descriptions."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

pytestmark = [pytest.mark.nightly, pytest.mark.slow(30)]


@pytest.mark.skipif(not (ROOT / ".site" / "packages").exists(), reason="run docker/prepare site")
def test_site_has_no_broken_link(tmp_path):
    command = [ROOT / "docker" / "site", "--site-dir", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert "The motion model" in (tmp_path / "docs/labs/localization/index.html").read_text()
    assert "sdc_package.car.Car.step" in (tmp_path / "docs/api/index.html").read_text()
