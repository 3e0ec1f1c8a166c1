"""A student's workspace overlays the world's: it finds the world, and never the finished car."""

import subprocess

import pytest
from finished_workspace import build, run

from sdc_common.processes import isolated_ros_environment
from sdc_testing.program import Program
from sdc_workshop.exam.answer import PASSED, WRONG
from sdc_workshop.exam.files import workspace_answer
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.workspace import PROJECT, WORLD, make

pytestmark = pytest.mark.slow(20)

TIMEOUT_S = 60


@pytest.fixture(scope="module")
def unsolved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("student") / "ws"
    make(folder)
    build(folder)
    return folder


def checked(folder):
    student = Student(folder)
    with Stage(student) as stage:
        return workspace_answer(student, stage)


def test_unsolved_workspace_passes_the_check(unsolved):
    assert checked(unsolved).status == PASSED


def test_packages_of_the_world_are_found_and_sdc_package_is_the_students(unsolved):
    for package, folder in (
        ("sdc_package", unsolved / "src" / "sdc_package"),
        ("sdc_sim", WORLD / "src" / "sdc_sim"),
        ("sdc_common", WORLD / "src" / "sdc_common"),
        ("sdc_cockpit", WORLD / "src" / "sdc_cockpit"),
    ):
        assert run(unsolved, "rospack", "find", package).stdout.strip() == str(folder)


def test_students_watch_their_own_drive_in_the_cockpit(unsolved):
    nodes = run(unsolved, "roslaunch", "--nodes", "sdc_package", "all.launch", "cockpit:=true")
    assert "/cockpit" in nodes.stdout.split()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("python3 -c 'from sdc_package.msg import Path'", "No module named 'sdc_package.msg'"),
        ("rosrun sdc_package hello.sh", "ouldn't find executable named hello.sh"),
    ],
)
def test_what_is_not_written_is_missing(unsolved, command, words):
    assert words in run(unsolved, "bash", "-c", command).stdout


@pytest.mark.parametrize(
    ("setup", "seen"),
    [
        (PROJECT / "catkin_ws" / "devel" / "setup.bash", "overlays the finished car"),
        (None, "does not overlay the world"),
    ],
    ids=["finished_car", "no_world"],
)
def test_workspace_built_in_a_wrong_terminal_is_reported_with_the_fix(tmp_path, setup, seen):
    make(tmp_path / "ws")
    build(tmp_path / "ws", setup)
    answer = checked(tmp_path / "ws")
    assert answer.status == WRONG
    assert seen in answer.seen
    assert "world_ws/devel/setup.bash" in answer.hint


def test_world_runs_beside_a_broken_student_package(unsolved, tmp_path):
    library = unsolved / "src" / "sdc_package" / "src" / "sdc_package" / "__init__.py"
    text = library.read_text()
    library.write_text("raise RuntimeError('broken')\n")
    try:
        assert "RuntimeError: broken" in run(unsolved, "python3", "-c", "import sdc_package").stdout
        with isolated_ros_environment(tmp_path) as variables:
            names = ("ROS_MASTER_URI", "ROS_IP", "ROS_HOME")
            ros = {name: variables[name] for name in names}
            environment = {**Student(unsolved).environment, **ros}
            launch = ["roslaunch", "sdc_sim", "sim.launch", "camera:=false"]
            world = Program(launch, environment, tmp_path, tmp_path / "world.log")
            try:
                world.wait_for_output("process[sim")
                topic = "/carla/ego_vehicle/odometry"
                echo = ["rostopic", "echo", "-n", "1", topic]
                odometry = Program(echo, environment, tmp_path, tmp_path / "odometry.log")
                assert odometry.wait_for_end() == 0, world.output
                assert "frame_id" in odometry.output
            finally:
                world.interrupt()
    finally:
        library.write_text(text)


def test_world_is_not_built_again_without_a_change():
    prepare = [PROJECT / "docker" / "prepare", "world"]
    subprocess.run(prepare, check=True, timeout=300)
    built = (WORLD / "devel" / ".built").stat().st_mtime_ns
    done = subprocess.run(prepare, capture_output=True, text=True, check=True, timeout=TIMEOUT_S)
    assert done.stdout + done.stderr == ""
    assert (WORLD / "devel" / ".built").stat().st_mtime_ns == built
