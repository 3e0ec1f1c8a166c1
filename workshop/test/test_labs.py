"""Follow the page of each lab word for word, in an empty home, with real terminals."""

import pytest
from finished_workspace import differences, solved
from guide_blocks import read
from guide_student import Student

from sdc_workshop import check
from sdc_workshop.grading.grading import Conditions, grade
from sdc_workshop.grading.handed_in import copy_workspace
from sdc_workshop.steps import LABS, chosen, load_steps
from sdc_workshop.workspace import PROJECT, lab_of, make, package_files

pytestmark = pytest.mark.slow(60)

LIMIT_S = 1200


@pytest.mark.nightly
@pytest.mark.parametrize("lab", LABS)
def test_page_of_a_lab_leads_to_a_car_that_drives(tmp_path, lab):
    page = PROJECT / "docs" / "labs" / f"{lab}.md"
    with Student(tmp_path, page=page) as student:
        for block in read(page.read_text(encoding="utf-8")):
            student.follow(block)
    assert differences(student.workspace, lab) == [], "these files differ from the solution"
    assert [step.id for step in load_steps(lab) if step.id not in student.steps_seen] == [], (
        "the page lacks these steps"
    )


@pytest.mark.parametrize("lab", LABS)
def test_check_without_a_step_means_the_lab_of_the_workspace(tmp_path, lab):
    make(tmp_path / "ws", lab)
    assert chosen([], lab_of(tmp_path / "ws")) == load_steps(lab)
    assert chosen([lab]) == load_steps(lab)
    assert not set(load_steps(lab)) & set(chosen([]))


def test_missing_package_of_a_lab_is_one_line(tmp_path, monkeypatch, capsys):
    def without_osqp(*_):
        raise ImportError("osqp is not installed; run docker/prepare mpc")

    make(tmp_path / "ws", "mpc")
    monkeypatch.setenv("PWD", str(tmp_path / "ws"))
    monkeypatch.setattr(check, "check", without_osqp)
    assert check.main([]) == 2
    assert capsys.readouterr().err == "check: osqp is not installed; run docker/prepare mpc\n"


@pytest.mark.parametrize("lab", LABS)
def test_grading_a_lab_takes_the_finished_car(tmp_path, lab):
    source, copy = tmp_path / "ws", tmp_path / "copy"
    make(source, lab)
    (source / "src" / "sdc_package" / "scripts" / "camera.py").write_text("broken")
    name = package_files(lab)[0]
    (source / "src" / name).write_text("mine")
    copy_workspace(source, copy, lab)
    assert differences(copy) == []
    assert (copy / "src" / name).read_text() == "mine"


@pytest.mark.nightly
@pytest.mark.parametrize("lab", ("localization", "perception"))  # the others have no drive
@pytest.mark.usefixtures("sandboxed")
def test_graded_car_of_a_lab_drives_a_road_of_the_seed_too(tmp_path, lab):
    steps = (f"{lab}-drive",)
    conditions = Conditions(LIMIT_S, 20000, steps=steps, lab=lab, seed=7)
    found = grade("ada", solved(tmp_path / "ws"), tmp_path / "grade", conditions)
    assert [found.report["status"], found.unknown["status"]] == ["completed", "completed"]
    assert found.report["duration_s"] != found.unknown["duration_s"]
    assert found.contained == []
