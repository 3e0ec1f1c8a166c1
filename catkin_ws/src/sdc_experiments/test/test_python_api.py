"""Pages of docs: their examples run, and their figures and tables are those of the code."""

import contextlib
import inspect
import io
import json
import re
from pathlib import Path

import pytest

from sdc_experiments.closed_loop import drive, drive_result
from sdc_sim.report.console_progress import closing_line

pytestmark = pytest.mark.slow(3)

PAGE = (Path(__file__).resolve().parents[4] / "docs" / "python_api.md").read_text("utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize(
    ("number", "printed"),
    [
        (0, r"completed 0\.0\d+\n\(\d+, 11\) \S+ 100\.0\n"),
        (1, r"0\.\d+\ncompleted\n"),
        (2, r"\d+\.\d+ 5\d\.\d+ \[101\]\n"),
    ],
)
def test_example_runs(number, printed):
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(EXAMPLES[number], f"docs/python_api.md, example {number}", "exec"), {})
    assert re.fullmatch(printed, output.getvalue()), output.getvalue()


def test_every_example_is_tested_and_every_argument_is_described():
    assert len(EXAMPLES) == 3
    for name in inspect.signature(drive_result).parameters:
        assert re.search(rf"^\| .*`{name}`.* \|", PAGE, re.MULTILINE), name


ROOT = Path(__file__).resolve().parents[4]
FIGURES = json.loads((ROOT / "docs" / "drive.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ["README.md", "docs/drive.md"])
def test_page_shows_the_stored_figures(name):
    """The closing line is that of a drive in real time, the rows of the table are in lockstep."""
    page = (ROOT / name).read_text(encoding="utf-8")
    assert f"    {closing_line(FIGURES['real_time'])}; see report/report.json" in page
    for command, figures in FIGURES["lockstep"].items() if "least possible" in page else ():
        errors = f"{figures['cross_track_rms_m']:.3f} m | {figures['cross_track_max_m']:.3f} m"
        assert f"| `{command}` | {errors} | {figures['time_ratio']:.3f} |" in page


@pytest.mark.slow(2)
def test_stored_figures_are_those_of_the_code():
    """A drive without ROS equals that of the nodes in lockstep."""
    stored = FIGURES["lockstep"]["./drive"]
    measured = drive()
    for name, value in stored.items():
        if name != "real_time_factor":
            is_float = isinstance(value, float)
            assert measured[name] == (pytest.approx(value, rel=1e-3) if is_float else value)
    assert stored["driving_score"] == 100.0
