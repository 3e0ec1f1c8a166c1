"""The rubric: from the steps and drives of a student to a mark."""

import pytest

from sdc_workshop.grading.grading import Grade
from sdc_workshop.grading.rubric import RubricError, load_rubric, mark
from sdc_workshop.steps import load_steps

STEPS = [step for step in load_steps() if step.id != "drive"]


def graded(tmp_path, steps=STEPS, drive=100.0, unknown=100.0, **more):
    answers = {step.id: {"status": "passed" if step in steps else "wrong"} for step in STEPS}
    reports = {"report": {"driving_score": drive}, "unknown": {"driving_score": unknown}}
    return Grade("ada", tmp_path, answers, **reports, **more)


@pytest.mark.parametrize(
    "text, change, points",
    [
        ("", {}, 100.0),
        ("", {"steps": [], "unknown": 40.0}, 35.0),
        ("", {"solved": [step.id for step in STEPS]}, 62.5),
        ("solution_cap: 0", {"solved": [step.id for step in STEPS]}, 50.0),
        ("phases: {1: 0, 2: 0}", {"steps": [one for one in STEPS if one.phase == 3]}, 100.0),
        ("weights: {phases: 3, drive: 1, unknown_drive: 0}", {"drive": 0.0}, 75.0),
        ("points: 20\nlate: {days: {ada: 3}, free_days: 1}", {}, 16.0),
    ],
)
def test_mark_follows_the_rubric(tmp_path, text, change, points):
    (tmp_path / "rubric.yaml").write_text(text)
    rubric = load_rubric(tmp_path / "rubric.yaml", ["ada"])
    assert mark(graded(tmp_path, **change), rubric).points == pytest.approx(points)


def test_lab_is_marked_by_its_own_steps_and_both_drives(tmp_path):
    answers = {step.id: {"status": "passed"} for step in load_steps("localization")}
    found = Grade("ada", tmp_path, answers, {"driving_score": 70.0}, lab="localization")
    assert mark(found, load_rubric()).points == pytest.approx(67.5)
    found.unknown = {"driving_score": 90.0}
    assert mark(found, load_rubric()).points == pytest.approx(90.0)


@pytest.mark.parametrize(
    "text, message",
    [
        ("weight: {}", "weight: unknown; write one of points, weights"),
        ("weights: {phases: -1}", "weights: phases: must not be negative, got -1"),
        ("weights: {drive: yes}", "weights: drive: must be a number, got True"),
        ("weights: 3", "weights: must be keys with values, got 3"),
        ("weights: {phases: 0, drive: 0, unknown_drive: 0}", "one must be positive"),
        ("late: {days: {adda: 2}}", "late.days: 'adda' is no name in the table"),
        ("a: [", "expected the node content"),
    ],
)
def test_wrong_rubric_is_one_line_with_the_place(tmp_path, text, message):
    (tmp_path / "rubric.yaml").write_text(text)
    with pytest.raises(RubricError) as caught:
        load_rubric(tmp_path / "rubric.yaml", ["ada"])
    assert message in str(caught.value) and "\n" not in str(caught.value)
