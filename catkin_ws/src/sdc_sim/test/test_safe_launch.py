"""Parameter files cannot run code."""

import io
import sys

import pytest
import roslaunch
import rosparam
import yaml

from sdc_sim.ros import safe_launch


@pytest.fixture
def launched(monkeypatch):
    """Run safe_launch with a roslaunch that only records its arguments."""
    arguments = []
    loader = dict(yaml.SafeLoader.yaml_constructors)
    monkeypatch.setattr(yaml.SafeLoader, "yaml_constructors", loader)
    monkeypatch.setattr(roslaunch, "main", arguments.extend)
    monkeypatch.setattr(sys, "argv", ["safe_launch", "sdc_package", "all.launch", "sync:=true\n"])
    safe_launch.main()
    return arguments


@pytest.mark.parametrize(
    "value", ["!radians 2*pi", "!degrees 90", "rad(2*pi)", "deg(90)", '!radians "1.0"']
)
def test_expressions_of_parameter_files_are_refused_with_their_line(launched, value):
    with pytest.raises(yaml.constructor.ConstructorError, match="write the number") as caught:
        rosparam.load_str(f"a: 1\nb: {value}\n", "file.yaml")
    assert caught.value.problem_mark.line == 1


def test_roslaunch_receives_the_arguments_and_plain_values_are_read(launched):
    assert launched == ["roslaunch", "sdc_package", "all.launch", "sync:=true"]
    ((values, _),) = rosparam.load_str("a: 1.5\nb: [rad, 'deg 90']\n", "file.yaml")
    assert values == {"a": 1.5, "b": ["rad", "deg 90"]}


def test_argument_of_several_lines_is_refused_with_its_name():
    with pytest.raises(SystemExit, match="^sim_options: the value has several lines; write it"):
        safe_launch.one_line("sim_options:={seed: 7,\n friction: 0.6}")


@pytest.mark.parametrize(
    ("text", "is_usual"),
    [
        ("... logging to /root/.ros/log/1/roslaunch-vm-1.log", True),
        ("\nSUMMARY\n========\n\nPARAMETERS\n * /sim/tick_s: 0.05", True),
        ("\x1b[1mprocess[hero1/sim-4]: started with pid [31360]\x1b[0m", True),
        ("\x1b[31m===REQUIRED process [referee-7] has died!\nprocess has finished cleanly\n", True),
        ("\x1b[31m===REQUIRED process [sim-5] has died!\nprocess has died [pid 3, exit", False),
        ("\x1b[31m[local_planner-3] process has died [pid 4, exit code 1, cmd x", False),
        ("[local_planner-3] restarting process", False),
        ("the drive is done", False),
        ("", False),
    ],
)
def test_usual_texts_of_roslaunch_go_to_the_log_and_all_others_to_the_terminal(text, is_usual):
    terminal, log = io.StringIO(), io.StringIO()
    print(text, file=safe_launch.QuietStream(terminal, log))
    other, found = (terminal, log) if is_usual else (log, terminal)
    assert (found.getvalue(), other.getvalue()) == (text + "\n", "")


def test_log_on_a_full_disk_does_not_end_the_launch():
    with open("/dev/full", "w", buffering=1, encoding="utf-8") as log:
        print("auto-starting new master", file=safe_launch.QuietStream(sys.stderr, log))
        with pytest.raises(OSError, match="No space"):
            log.close()
