"""Templates and steps match the solution; solving all steps of a workspace restores it."""

import os

import pytest
from finished_workspace import differences, is_given

from sdc_testing.program import run
from sdc_workshop import check
from sdc_workshop.regions import regions
from sdc_workshop.steps import LABS, WORKSHOP, all_steps, find_step, load_steps
from sdc_workshop.workspace import (
    PROJECT,
    WorkspaceError,
    find,
    is_older,
    lab_of,
    make,
    package_files,
    solution,
    solution_body,
    solve,
    solved_steps,
    template_of,
    update,
    write,
)

WANTED = {
    "camera": ["1", "2", "3", "4", "5"],
    "mission_planner": list("12345678"),
    "local_planner": list("12345678"),
    "controller": [f"1.{i}" for i in range(1, 6)] + [f"2.{i}" for i in range(1, 10)],
}


FILES = [name for lab in ("", *LABS) for name in package_files(lab) if template_of(name)]


@pytest.mark.slow(2)
def test_each_region_has_one_step_and_each_step_its_region():
    steps = all_steps()
    assert len({step.id for step in steps}) == len(steps)
    covered = [(step.file, step.todo) for step in steps if step.todo]
    there = [(name, number) for name in FILES for number in regions(solution(name).read_text())]
    assert sorted(covered) == sorted(there)
    for node, numbers in WANTED.items():
        for number in numbers:
            step = find_step(f"{node}-{number}")
            assert step.todo == number
            assert regions(solution(step.file).read_text())[number].title


@pytest.mark.parametrize("lab", (WORKSHOP, *LABS))
def test_new_workspace_is_unsolved_and_becomes_the_solution(tmp_path, lab):
    make(tmp_path / "ws", lab)
    assert lab_of(tmp_path / "ws") == lab
    unsolved = set(differences(tmp_path / "ws", lab))
    steps = [step for step in load_steps(lab) if step.file and not is_given(step)]
    assert unsolved == {step.file for step in steps}
    for step in load_steps(lab):
        solve(tmp_path / "ws", step)
    assert differences(tmp_path / "ws", lab) == differences(tmp_path / "ws") == []
    assert os.access(tmp_path / "ws" / "src" / "sdc_package" / "scripts" / "camera.py", os.X_OK)
    assert os.path.samefile(tmp_path / "ws" / "workshop", PROJECT / "workshop")
    assert find(tmp_path / "ws" / "src" / "sdc_package") == tmp_path / "ws"


def test_steps_by_solution_are_noted_until_the_student_changes_them(tmp_path, monkeypatch):
    make(tmp_path / "ws")
    monkeypatch.setenv("PWD", str(tmp_path / "ws"))
    for step in ("messages-1", "controller-2.7"):
        assert check.main(["--solution", step]) == 0
    solve(tmp_path / "ws", find_step("controller-2.6"))
    assert solved_steps(tmp_path / "ws") == ["messages-1", "controller-2.7"]
    write(tmp_path / "ws", find_step("controller-2.7"), "    return 0.0\n")
    assert solved_steps(tmp_path / "ws") == ["messages-1"]


@pytest.mark.parametrize("lab", LABS)
def test_lab_is_added_to_a_workspace_with_a_car_of_its_own(tmp_path, lab):
    folder = tmp_path / "ws"
    make(folder)
    own = folder / "src" / "sdc_package" / "scripts" / "camera.py"
    own.write_text("mine")
    make(folder, lab)
    assert own.read_text() == "mine"
    assert all((folder / "src" / name).is_file() for name in package_files(lab))
    with pytest.raises(WorkspaceError, match="already has"):
        make(folder, lab)


def test_workspace_of_another_version_is_recognised_and_updated(tmp_path, monkeypatch, capsys):
    folder = tmp_path / "ws"
    make(folder)
    assert not is_older(folder)
    with pytest.raises(WorkspaceError, match=f"./workshop/start --update {folder} brings"):
        make(folder)
    # As the first version marked its workspaces.
    (folder / ".workshop").write_text(f"{PROJECT}\n\n")
    monkeypatch.setenv("PWD", str(folder))
    assert check.main(["--solution", "messages-7"]) == 0
    shown = capsys.readouterr().out
    assert "is of another version of the workshop: `./workshop/start --update .`" in shown
    update(folder)
    assert not is_older(folder)


def test_update_restores_given_lines_and_keeps_the_todos(tmp_path):
    folder = tmp_path / "ws"
    make(folder)
    solve(folder, find_step("camera-2"))
    camera, pid, gains = (
        folder / "src" / "sdc_package" / name
        for name in ("scripts/camera.py", "src/sdc_package/pid.py", "config/simple_controller.yaml")
    )
    written = camera.read_text()
    camera.write_text(written.replace("def run(self)", "def walk(self)"))
    pid.unlink()
    gains.write_text(gains.read_text() + "# tuned\n")
    changed, copy = update(folder)
    assert changed == ["sdc_package/scripts/camera.py", "sdc_package/src/sdc_package/pid.py"]
    assert camera.read_text() == written
    assert "def walk" in (copy / "sdc_package/scripts/camera.py").read_text()
    assert pid.is_file() and gains.read_text().endswith("# tuned\n")
    assert update(folder)[0] == []
    camera.write_text(written.replace("TODO 2:", "2:"))
    with pytest.raises(WorkspaceError, match="src/sdc_package/scripts/camera.py: line"):
        update(folder)


def test_lines_that_are_given_now_come_into_an_older_workspace_where_none_are_written(tmp_path):
    folder = tmp_path / "ws"
    make(folder)
    node = folder / "src" / "sdc_package" / "scripts" / "mission_planner.py"
    new = node.read_text()
    given = find_step("mission_planner-1"), find_step("mission_planner-3")
    for step in given:
        write(folder, step, "")
    node.write_text(node.read_text().replace(" (given)", ""))
    write(folder, given[1], "        self.publisher = mine\n")
    update(folder)
    latched = solution_body(given[1])
    assert node.read_text() == new.replace(latched, "        self.publisher = mine\n")


def test_unusable_folders_are_refused(tmp_path):
    with pytest.raises(WorkspaceError, match="own workspace"):
        make(PROJECT / "catkin_ws" / "src" / "mine")
    with pytest.raises(WorkspaceError, match="is in no workspace"):
        find(tmp_path)


@pytest.mark.slow(2)
def test_start_refuses_a_full_folder_in_one_line(tmp_path):
    (tmp_path / "mine").write_text("")
    done = run(PROJECT / "workshop" / "start", tmp_path)
    assert done.returncode == 1
    lines = [line for line in done.stdout.splitlines() if not line.startswith("prepare: ")]
    assert lines == [f"start: {tmp_path} is not empty; name a new folder, or empty this one"]
