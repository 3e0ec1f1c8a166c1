"""From the steps and drives of a student to a mark, and the files of marks for other programs."""

import csv
import json

import pytest

from sdc_common.validation import DocumentError
from sdc_workshop.grading.grading import Grade
from sdc_workshop.grading.rubric import load_rubric, mark
from sdc_workshop.grading.summary import ranked, write_lms, write_pages
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
        ("phases: [0, 0, 1, 1]", {"steps": [one for one in STEPS if one.phase == 3]}, 100.0),
        ("weights: {phases: 3, drive: 1, unknown_drive: 0}", {"drive": 0.0}, 75.0),
        ("weights: {my_car: 1}", {"championship": "80.0"}, 90.0),
        ("weights: {my_car: 1}", {}, 50.0),
        ("points: 20\nlate: {days: {ada: 3}, free_days: 1}", {}, 16.0),
        ("late: {days: {ada: 200}}", {}, 0.0),
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
        ("points: 9\nweight: {}", "line 2: unknown key 'weight'; did you mean 'weights'?"),
        ("weights: {phases: -1}", "'phases' must be a number that is not negative, got -1"),
        ("weights: {drive: yes}", "'drive' must be a number that is not negative, got 'yes'"),
        ("weights: 3", "'weights' must be a mapping with lines of 'key: value', got 3"),
        ("phases: [1, 1]", "'phases' must be four numbers"),
        ("weights: {phases: 0, drive: 0, unknown_drive: 0}", "must have a number above 0"),
        ("late: {days: {adda: 2}}", "line 1: 'adda' is no name in the table"),
        ("a: [", "is not valid YAML"),
    ],
)
def test_wrong_rubric_is_one_line_with_the_place(tmp_path, text, message):
    (tmp_path / "rubric.yaml").write_text(text)
    with pytest.raises(DocumentError) as caught:
        load_rubric(tmp_path / "rubric.yaml", ["ada"])
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_marks_for_moodle_canvas_and_gradescope(tmp_path):
    answer = dict.fromkeys(("expected", "seen", "hint", "file", "line"), "")
    answers = {"hello": {**answer, "status": "passed"}, "camera-3": {**answer, "status": "wrong"}}
    answers["camera-3"]["seen"] = 'a "name" & <more>'
    grades = []
    for name, file in (
        ("Ada L", "Ada L_12_assignsubmission_file_"),
        ("bert", "bert_34_56_ws.zip"),
        ("carl", "carl"),
    ):
        (tmp_path / name).mkdir()
        report = {"status": "completed", "driving_score": 80.0}
        grades.append(Grade(name, tmp_path / file, answers, report, unknown=report))
    rubric = load_rubric()
    rows = ranked(grades, rubric)
    write_lms(tmp_path, rows, rubric)
    write_pages(tmp_path, rows, [])
    ada, _, carl = csv.DictReader((tmp_path / "moodle.csv").open(encoding="utf-8"))
    assert (ada["Identifier"], ada["Full name"]) == ("Participant 12", "Ada L")
    assert (ada["Grade"], ada["Last modified (grade)"]) == ("40.88", "-")
    assert (carl["Username"], carl["Maximum Grade"], carl["Identifier"]) == ("carl", "100.00", "")
    with (tmp_path / "canvas.csv").open(encoding="utf-8") as file:
        header, points, _, bert, carl = csv.reader(file)
    assert header[:5] == ["Student", "ID", "SIS User ID", "SIS Login ID", "Section"]
    assert "Points Possible" in points[0] and points[5] == "100"
    assert (bert[0], bert[1], bert[5], carl[3]) == ("bert", "34", "40.88", "carl")
    results = json.loads((tmp_path / "carl" / "results.json").read_text())
    assert results["score"] == 40.88
    tests = {test["name"].split(":")[0]: test for test in results["tests"]}
    assert (tests["hello"]["status"], tests["camera-1"]["status"]) == ("passed", "failed")
    assert tests["camera-3"]["output"].startswith('seen: a "name" & <more>\nhint: rospy.Subscriber')
