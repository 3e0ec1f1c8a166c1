"""README.md and docs/drive.md show the figures that were measured, and the code still has them."""

import json
from pathlib import Path

import pytest

from sdc_experiments.closed_loop import drive
from sdc_experiments.drive_figures import PAGES, STORED, with_figures

ROOT = Path(__file__).resolve().parents[4]
FIGURES = json.loads((ROOT / STORED).read_text(encoding="utf-8"))
COMMAND = "run python3 -m sdc_experiments.drive_figures"


@pytest.mark.parametrize("name", PAGES)
def test_page_shows_the_stored_figures(name):
    page = (ROOT / name).read_text(encoding="utf-8")
    assert page == with_figures(page, FIGURES), COMMAND
    assert page.count("    referee: completed: ") == 1


@pytest.mark.slow(2)
def test_stored_figures_are_those_of_the_code():
    """A drive without ROS equals that of the nodes in lockstep."""
    stored = FIGURES["lockstep"]["./drive"]
    measured = drive()
    for name, value in stored.items():
        if name != "real_time_factor":
            assert measured[name] == (
                pytest.approx(value, rel=1e-3) if isinstance(value, float) else value
            ), COMMAND
    assert stored["driving_score"] == 100.0
