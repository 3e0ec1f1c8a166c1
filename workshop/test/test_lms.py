"""The files for Moodle, Canvas and Gradescope have the columns and keys that these read."""

import csv
import json

from sdc_workshop.grading.grading import Grade
from sdc_workshop.grading.rubric import load_rubric
from sdc_workshop.grading.summary import ranked, write_lms, write_pages


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
