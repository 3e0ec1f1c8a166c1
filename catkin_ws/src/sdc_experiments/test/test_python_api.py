"""The examples of docs/python_api.md run, and its tables are those of the code."""

import contextlib
import inspect
import io
import re
from pathlib import Path

import pytest

from sdc_experiments.closed_loop import drive_result

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
