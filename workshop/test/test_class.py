"""./workshop/class: the page with the progress of a class, under pseudonyms."""

import json
import re

import pytest

from sdc_workshop import progress
from sdc_workshop.classroom import main, minutes
from sdc_workshop.exam.answer import PASSED, WRONG, Answer
from sdc_workshop.steps import load_steps

STEPS = [step.id for step in load_steps()]


def workspace(folder, right):
    package = folder / "sdc_ws/src/sdc_package"
    package.mkdir(parents=True)
    kept = {step_id: PASSED for step_id in STEPS[:right]}
    times = {step_id: {"first": 60 * n, "passed": 60 * n} for n, step_id in enumerate(kept)}
    (package / progress.NAME).write_text(json.dumps({**kept, "times": times}))


@pytest.fixture
def page(tmp_path):
    """Return a function that writes the page of a class of two and returns it as rows of texts."""
    for name, right in (("ada", 3), ("ben", 5)):
        workspace(tmp_path / "home" / name, right)

    def write(*options):
        path = tmp_path / "class.html"
        assert main([str(tmp_path / "home"), "--once", "--output", str(path), *options]) == 0
        rows = re.findall(r"<tr[^>]*>(.*?)</tr>", path.read_text(), re.DOTALL)
        return [re.sub(r"<[^>]*>|\s+", " ", row).split() for row in rows]

    return write


def test_page_shows_who_is_where_and_how_long_steps_take(page):
    rows = [" ".join(row) for row in page("--names")]
    first, second = rows[1:3]
    assert first.startswith(f"ada 3 of {len(STEPS)} {STEPS[3]} "), first
    assert second.startswith(f"ben 5 of {len(STEPS)} {STEPS[5]} "), second
    step = next(row for row in rows[3:] if row.startswith(STEPS[4]))
    assert step.endswith(" 1 of 2 1.0"), step


def test_pseudonyms_stay_when_a_student_joins(page, tmp_path):
    def numbers(rows):
        return {row[2]: row[1] for row in rows if row[:1] == ["student"] and row[1].isdigit()}

    before = numbers(page())
    workspace(tmp_path / "home" / "aaron", 9)
    after = numbers(page())
    assert set(before.values()) == {"1", "2"} and before.items() < after.items()
    assert not re.search("aaron|ada|ben", (tmp_path / "class.html").read_text())


def test_damaged_file_of_a_student_is_left_out_and_named(page, tmp_path, capsys):
    path = tmp_path / "home/ben/sdc_ws/src/sdc_package" / progress.NAME
    path.write_text(json.dumps({"times": {"camera-1": "now"}}))
    assert [row[0] for row in page("--names")].count("ada") == 1
    assert f"ben: {progress.NAME} is left out" in capsys.readouterr().err


def test_time_of_a_step_counts_from_the_step_before(tmp_path, monkeypatch):
    (tmp_path / "src/sdc_package").mkdir(parents=True)
    for now_s, step_id, status in (
        (60, STEPS[0], WRONG),
        (180, STEPS[0], PASSED),
        (480, STEPS[1], PASSED),
        (900, STEPS[0], WRONG),
        (960, STEPS[0], PASSED),
    ):
        monkeypatch.setattr(progress.time, "time", lambda now_s=now_s: now_s)
        progress.keep(tmp_path, {step_id: Answer(status)})
    assert minutes(progress.times(tmp_path)) == {STEPS[0]: 2.0, STEPS[1]: 5.0}
