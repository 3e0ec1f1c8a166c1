"""./workshop/check: its answers, with place and fix, and its command line."""

import io
import os
import shutil
import subprocess
import sys
import tempfile
import time

import pytest
from finished_workspace import is_given

from sdc_workshop import progress
from sdc_workshop.check import end, stamps
from sdc_workshop.exam import examination, process
from sdc_workshop.exam.answer import NOT_JUDGED, PASSED, UNFINISHED, WAITING, WRONG, Answer
from sdc_workshop.exam.examination import Examination, check_of
from sdc_workshop.exam.output import crash, meaning
from sdc_workshop.exam.probes import library_probe
from sdc_workshop.exam.process import NotJudged, Program, marked
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.show import Show
from sdc_workshop.steps import StepError, chosen, find_step, load_steps
from sdc_workshop.temporary import temporary_folder
from sdc_workshop.workspace import PROJECT, make, solve, solved_steps, write

pytestmark = pytest.mark.slow(10)

CHECK = PROJECT / "workshop" / "check"
CAMERA = "src/sdc_package/scripts/camera.py"


@pytest.fixture(scope="module")
def new_workspace(tmp_path_factory):
    folder = tmp_path_factory.mktemp("new") / "ws"
    make(folder)
    return folder


@pytest.fixture
def folder(new_workspace, tmp_path):
    """Return a new workspace; to copy one is quicker than to derive it from the solution."""
    return shutil.copytree(new_workspace, tmp_path / "ws", symlinks=True)


def run(folder, *arguments):
    with Program([CHECK, *arguments], {**os.environ, "PWD": str(folder)}, folder) as program:
        return program.wait(120), program.output


def answers(folder, *ids):
    """Check steps that need no ROS."""
    student = Student(folder)
    with Stage(student) as stage:
        return Examination(student, stage).judge([find_step(step_id) for step_id in ids])


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_each_step_of_a_new_workspace_is_unfinished_and_has_a_hint(folder):
    found = answers(folder, *(step.id for step in load_steps() if not is_given(step)))
    assert {
        step_id: answer.status for step_id, answer in found.items() if answer.status != UNFINISHED
    } == {}
    assert [
        step_id
        for step_id, answer in found.items()
        if not (answer.expected and answer.seen and answer.hint)
    ] == []


def test_written_step_waits_for_the_build(folder):
    solve(folder, find_step("camera-2"))
    solve(folder, find_step("controller-1.1"))
    found = answers(folder, "camera-2", "controller-1.1")
    assert found["camera-2"].status == found["controller-1.1"].status == WAITING
    assert "catkin_make" in found["camera-2"].hint
    assert "CarlaVehicleControl" in found["controller-1.1"].expected


def test_syntax_error_is_reported_with_the_students_line_at_its_own_step(folder):
    solve(folder, find_step("camera-2"))
    edit(
        folder / CAMERA,
        '        rospy.init_node("camera")',
        '        # so\n        rospy.init_node("camera"',
    )
    solve(folder, find_step("camera-1"))
    (folder / CAMERA).chmod(0o755)
    found = answers(folder, "camera-1", "camera-2")
    assert found["camera-1"].status == PASSED
    assert found["camera-2"].status == WRONG
    line = int(found["camera-2"].where.rpartition(":")[2])
    assert "init_node" in (folder / CAMERA).read_text().split("\n")[line - 1]
    assert "bracket" in found["camera-2"].hint


def test_deleted_rule_is_reported(folder):
    text = (folder / CAMERA).read_text().split("\n")
    at = next(index for index, line in enumerate(text) if "TODO 2" in line)
    del text[at + 1]
    (folder / CAMERA).write_text("\n".join(text))
    found = answers(folder, "camera-1", "camera-2")
    assert found["camera-1"].status == WRONG
    assert "TODO 2 is" in found["camera-1"].seen
    assert found["camera-2"].status == WAITING


def test_change_outside_of_all_todos_is_reported_with_its_line(folder):
    solve(folder, find_step("camera-2"))
    edit(folder / CAMERA, "    def run(self):", "    def run(self)")
    found = answers(folder, "camera-2")["camera-2"]
    assert found.status == WRONG
    assert "outside of your TODOs" in found.hint
    assert "def run" in (folder / CAMERA).read_text().split("\n")[found.line - 1]


def test_missing_file_is_reported_with_the_command_that_restores_it(folder):
    (folder / CAMERA).unlink()
    found = answers(folder, "camera-2")["camera-2"]
    assert found.status == WRONG
    assert "./workshop/start --update ." in found.hint


def test_command_checks_solves_and_hints(folder):
    for arguments, status, words in (
        (["messages-7"], 1, "messages-7: A point of the mission: BaseWaypoint.msg: is not written"),
        (["--solution", "messages-7"], 0, "float32 x\nfloat32 y\n"),
        (["messages-7"], 0, "] 1 of 1\n"),
        (["--hint", "mission_planner-3"], 0, "latch=True"),
    ):
        got, output = run(folder / "src", *arguments)
        assert (got, words in output) == (status, True), output


def test_folder_that_is_no_workspace_is_refused_in_one_line(tmp_path):
    status, output = run(tmp_path, "camera-1")
    assert (status, output.count("\n")) == (2, 1)
    assert output.startswith(f"check: {tmp_path} is in no workspace")


def test_name_of_a_group_selects_its_steps():
    assert [step.id for step in chosen(["controller-1.3", "hello"])] == ["hello", "controller-1.3"]
    assert {step.id for step in chosen(["stack-launch"])} == {"stack-launch-1", "stack-launch-2"}
    assert [step.id for step in chosen(["controller-2"])] == [
        f"controller-2.{i}" for i in range(1, 10)
    ]
    assert len(chosen(["camera", "camera-1..camera-launch"])) == len(chosen(["camera"])) == 6
    with pytest.raises(StepError, match="there is no step 'cam'; ./workshop/check --list"):
        chosen(["cam"])
    with pytest.raises(StepError, match="camera-1 comes before camera-3"):
        chosen(["camera-3..camera-1"])


def test_several_solutions_are_written_and_kept_with_all_answers(folder):
    status, output = run(folder, "--solution", "messages-7..messages-8", "messages-9")
    assert (status, output.count("is written:")) == (0, 3), output
    (folder / "src/sdc_package/msg/Path.msg").write_text("BaseWaypoint[]  waypoints\n")
    assert solved_steps(folder) == ["messages-7", "messages-9"]
    run(folder, "messages-7", "messages-10")
    status, output = run(folder, "messages-8")
    assert (status, "2 of 58 steps of the lesson" in output) == (0, True), output
    kept = progress.statuses(folder)
    assert kept == {"messages-7": PASSED, "messages-8": PASSED, "messages-10": UNFINISHED}
    status, output = run(folder)
    assert [line.split("]")[1] for line in output.splitlines() if line.startswith("phase")] == [
        " 0 of 1",
        " 1 of 22",
        " 3 of 34",
        " 0 of 1",
    ], output
    assert len(progress.statuses(folder)) == 58
    (folder / "src/sdc_package/msg/Path.msg").rename(folder / "src/sdc_package/scripts/Path.msg")
    output = run(folder, "messages-8")[1]
    assert "there is src/sdc_package/scripts/Path.msg" in " ".join(output.split()), output


def test_hint_gives_the_line_away_with_the_third_attempt(folder):
    status, output = run(folder, "controller-2.7")
    assert "nothing is written" in output and "atan2" not in output and "--hint" in output
    step = find_step("controller-2.7")
    path = folder / "src" / step.file
    answer = Answer(WRONG, "0.1", "-0.1", "The sign is wrong. In full: e - atan2(k, v)")
    for change, full in ((" ", False), ("", False), (" ", False), ("", False), (" ", True)):
        path.write_text(path.read_text() + change)
        stream = io.StringIO()
        end(folder, [step], {step.id: answer}, Show(stream))
        assert "The sign is wrong." in stream.getvalue() and "expected  0.1" in stream.getvalue()
        assert ("e - atan2(k, v)" in stream.getvalue()) == full
    assert progress.statuses(folder) == {step.id: WRONG}


def test_same_seed_draws_the_same_arguments(folder):
    call = "stanley_angle(0.2, 0.0, 5.0, 2)"
    one, again, other = (library_probe.varied(call, seed) for seed in ("a", "a", "b"))
    assert one == again != other and other.endswith(", 2)")
    with Stage(Student(folder), seed="a") as stage, Stage(Student(folder)) as unknown:
        assert stage.random("x").random() == stage.random("x").random()
        assert stage.random("x").random() != unknown.random("x").random()


def test_watch_checks_again_when_a_file_is_saved(folder):
    namespaces = ["unshare", "--map-root-user", "--net", "true"]
    can_isolate = subprocess.run(namespaces, capture_output=True).returncode == 0
    watch = subprocess.Popen(
        [CHECK, "--watch", "messages-7", "messages-9"],
        cwd=folder,
        env={**os.environ, "PWD": str(folder)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        # The second change breaks a step that was right.
        for step_id, changed, is_right in (
            ("messages-7", "messages-7", True),
            ("messages-9", "messages-7", False),
            ("messages-7", "messages-7", True),
            ("messages-9", "messages-9", True),
        ):
            lines = []
            while not lines or "Waiting for you" not in lines[-1]:
                lines.append(watch.stdout.readline())
                assert lines[-1], "it ended early"
            if can_isolate:
                network = os.readlink(f"/proc/{watch.pid}/ns/net")
                assert network != os.readlink("/proc/self/ns/net"), "other programs reach the check"
            assert f"\n{step_id}: " in "".join(lines)
            if is_right:
                solve(folder, find_step(changed))
            else:
                write(folder, find_step(changed), "float32 z\n")
        assert watch.wait(60) == 0
        assert "2 of 2" in watch.stdout.read()
    finally:
        watch.kill()
        watch.wait()
        watch.stdout.close()


def test_kept_answers_are_no_saved_file(folder):
    before = stamps(folder)
    progress.keep(folder, {"messages-7": Answer(WRONG)})
    assert stamps(folder) == before
    (folder / CAMERA).write_text("")
    assert stamps(folder) != before


def test_wrong_step_is_explained_before_an_unfinished_one():
    steps = [find_step(step_id) for step_id in ("camera-1", "camera-2", "camera-3")]
    found = {
        "camera-1": Answer(PASSED),
        "camera-2": Answer(UNFINISHED, "a", "b", "c", "f", 1),
        "camera-3": Answer(WRONG, "d", "e", "g", "f", 7),
    }
    for encoding, tick, cross in (("utf-8", "✓", "✗"), ("ascii", "+", "x")):
        written = io.BytesIO()
        stream = io.TextIOWrapper(written, encoding)
        show = Show(stream)
        for step in steps:
            show.step(step, found[step.id])
        show.end(steps, found, {"messages-7": PASSED}, {})
        text = written.getvalue().decode(encoding)
        assert f" {tick} camera-1" in text
        assert f" {cross} camera-3" in text
        assert "] 1 of 3\n1 of 58 steps" in text
        assert "camera-3: Camera: the subscriber: is not right yet." in text, (
            "the wrong step comes first"
        )
        assert "where     f:7" in text


def test_terminal_shows_what_the_check_waits_for_until_the_answer():
    class Terminal(io.StringIO):
        encoding = "utf-8"

        def isatty(self):
            return True

    shown = {}
    for stream in (Terminal(), io.StringIO()):
        show, step = Show(stream), find_step("camera-3")
        show.waits(step, check_of(step).waits_for)
        show.step(step, Answer(PASSED))
        shown[stream.isatty()] = stream.getvalue()
    first, last = shown[True].split("\r\x1b[K")
    assert "the node starts" in first and "camera-3" in last
    assert "starts" not in shown[False] and "camera-3" in shown[False]


def test_program_ends_with_all_processes_it_started():
    command = (
        "setsid sleep 1000 & (setsid sh -c 'while :; do sleep 1000; done' &) ; "
        "echo ready; sleep 1000"
    )
    with Program(["sh", "-c", command], dict(os.environ)) as program:
        assert program.wait_until(lambda: "ready" in program.output) == "true"
        assert program.wait_until(lambda: False) == "idle"
        assert len(marked(program.mark)) >= 3
    assert marked(program.mark) == []


def test_endless_loop_and_end_of_a_program_are_detected(monkeypatch):
    monkeypatch.setattr(process, "BUSY_CPU_S", 0.2)
    with Program([sys.executable, "-c", "while True: pass"], dict(os.environ)) as program:
        assert program.wait_until(lambda: False) == "busy"
    with Program(["sh", "-c", "echo last; exit 3"], dict(os.environ)) as program:
        assert program.wait_until(lambda: False) == "ended"
        assert (program.status, program.output) == (3, "last\n")


def test_output_of_a_program_is_limited():
    with Program(["sh", "-c", "yes"], dict(os.environ)) as program:
        time.sleep(0.2)
        assert program.status is None
    assert len(program.output) < 1_000_000


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("import json\n\n\ndef f():\n    json.loads('x')\n\n\nf()\n", 5, "Read the last line"),
        ("rospy.spin()\n", 1, "import rospy"),
    ],
)
def test_traceback_is_reduced_to_the_line_of_the_students_file(tmp_path, text, line, words):
    script = tmp_path / "node.py"
    script.write_text(text)
    with Program([sys.executable, script], dict(os.environ)) as program:
        assert program.wait() == 1
        found = crash("[INFO] [1]: hm\n" + program.output, script)
    assert found.line == line
    assert words in meaning(found)
    assert crash("all is well\n", script) is None


def test_folders_that_killed_commands_have_left_are_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    code = (
        "import os; from sdc_workshop.temporary import temporary_folder\n"
        "with temporary_folder('of_a_test_'): os.kill(os.getpid(), 9)"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path), "PYTHONPATH": str(PROJECT / "workshop")}
    subprocess.run([sys.executable, "-c", code], env=environment, check=False)
    (left,) = tmp_path.iterdir()
    with temporary_folder("of_a_test_") as living, temporary_folder("of_a_test_") as new:
        assert {*tmp_path.iterdir()} == {living, new} and left not in (living, new)
    assert [*tmp_path.iterdir()] == []


def test_program_that_gets_no_processor_is_not_judged(folder, monkeypatch):
    """The machine is busy: the program computes, and got too little time for it."""
    loop = "import time; time.sleep(0.2)\nwhile True: pass"
    with Program([sys.executable, "-c", loop], dict(os.environ)) as program:
        monkeypatch.setattr(Program, "activity", lambda self, of_all=False: (0.01, True))
        with pytest.raises(NotJudged):
            program.wait(0.4)
        with pytest.raises(NotJudged):
            program.wait_until(lambda: False, 0.4)
        # A little later, what it has started has got enough.
        got = iter([0.1, 0.3])
        monkeypatch.setattr(Program, "activity", lambda *_, of_all=0: (of_all and next(got), True))
        assert program.wait(0.4) is None
    step = find_step("hello")
    monkeypatch.setattr(examination, "hello_answer", raised(NotJudged))
    with Stage(Student(folder)) as stage:
        assert Examination(stage.student, stage).judge([step])[step.id].status == NOT_JUDGED


def raised(error):
    def function(*_):
        raise error

    return function
