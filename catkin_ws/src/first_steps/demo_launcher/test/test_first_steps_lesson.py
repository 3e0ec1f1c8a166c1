"""Follow docs/first-steps.md: run its commands, write its files, check the results."""

import itertools
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sdc_common.ros.drive_master import free_master_port

FIRST_STEPS = Path(__file__).resolve().parents[2]
WORKSHOP = FIRST_STEPS.parents[2]
LESSON = WORKSHOP / "docs" / "first-steps.md"
LIMIT_SECONDS = 60.0
POINTS = 30  # of the ellipse
# These commands do not end by themselves, or are not for the reader's main terminal.
RUNNING = ("roscore", "rosrun", "roslaunch", "rostopic", "export WORKSHOP")
# Variables of the system's ROS, without those that a workspace adds
SYSTEM_VARIABLES = (
    "ROS_DISTRO",
    "ROS_ROOT",
    "ROS_ETC_DIR",
    "ROS_VERSION",
    "ROS_PYTHON_VERSION",
    "LANG",
)

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.slow(100),
    pytest.mark.skipif(not LESSON.exists(), reason="the lesson is not in this tree"),
]


def sections():
    """Return the lesson's numbered sections: {number: text}."""
    parts = re.split(r"^## (\d+)\. ", LESSON.read_text(), flags=re.MULTILINE)
    return {int(number): text for number, text in zip(parts[1::2], parts[2::2])}


def blocks(text):
    """Return the fenced blocks: (language, text before the block, block)."""
    return [
        (match[2], match[1], match[3])
        for match in re.finditer(
            r"(.*?)^```(\w+)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL
        )
    ]


class Reader:
    """A reader of the lesson, with an empty home folder and a ROS master port of their own."""

    def __init__(self, home):
        self.home, self.workspace, self.folder = home, home / "first_steps_ws", str(home)
        self.port = free_master_port()
        # catkin must build for the Python that runs this test.
        interpreter = os.path.dirname(sys.executable)
        self.environment = {
            "HOME": str(home),
            "WORKSHOP": str(WORKSHOP),
            "PATH": f"{interpreter}:/usr/bin:/bin",
            "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "PYTHONUNBUFFERED": "1",
        }
        self.environment.update(
            {name: os.environ[name] for name in SYSTEM_VARIABLES if name in os.environ}
        )
        self.processes = []

    def shell(self, command):
        known = "".join(
            f"[ -f {path} ] && . {path}\n"
            for path in ("/opt/ros/noetic/setup.bash", self.workspace / "devel" / "setup.bash")
        )
        return ["bash", "-c", known + command]

    def run(self, command):
        """Run the commands in a terminal and return their output."""
        result = subprocess.run(
            self.shell(f"set -e\n{command}"),
            cwd=str(self.home),
            env=self.environment,
            check=False,
            timeout=LIMIT_SECONDS,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        assert result.returncode == 0, f"{command}\n{result.stdout}"
        return result.stdout

    def check(self, chapter):
        return self.run(f"{FIRST_STEPS}/check.py {chapter}")

    def start(self, command):
        """Start the command in another terminal."""
        process = subprocess.Popen(
            self.shell(f"exec {command}"),
            cwd=str(self.home),
            env=self.environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.processes.append(process)
        return process

    def stop(self, process):
        """Press Ctrl-C."""
        process.send_signal(signal.SIGINT)
        try:
            process.wait(timeout=LIMIT_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()

    def stop_all(self):
        for process in reversed(self.processes):
            if process.poll() is None:
                self.stop(process)

    def follow(self, text):
        """Write the files of a section and run its commands that end by themselves, in order."""
        for language, before, block in blocks(text):
            named = re.findall(r"`([\w/]+\.(?:msg|py|txt|launch))`", before)
            if language == "bash" and not block.startswith(RUNNING):
                output = self.run(
                    f"cd {self.folder}\n{block.replace('source devel/setup.bash', '')}\npwd"
                )
                self.folder = output.splitlines()[-1]  # the next command runs in the same folder
            elif (
                language != "bash"
                and named
                and not block.startswith((" ", "from", "um_msgs/", "waypoints:"))
            ):
                path = self.workspace / "src" / named[-1]
                mode = path.stat().st_mode if path.exists() else None
                path.write_text(block)
                if mode:
                    path.chmod(mode)

    def echo(self, topic, count=1):
        """Return messages of a topic as text."""
        return self.run(f"timeout {LIMIT_SECONDS:.0f} rostopic echo -n {count} {topic}")

    def number(self, topic, field):
        """Return a number from a message of a topic."""
        return float(self.echo(f"{topic}/{field}").split()[0])

    def wait_for(self, condition, what):
        end = time.monotonic() + LIMIT_SECONDS
        while not condition():
            assert time.monotonic() < end, f"timeout while waiting for {what}"
            time.sleep(0.1)


def edit(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1, f"{path}: {old!r} occurs {text.count(old)} times"
    path.write_text(text.replace(old, new))


@pytest.fixture
def reader(tmp_path):
    reader = Reader(tmp_path)
    yield reader
    reader.stop_all()
    shutil.rmtree(str(tmp_path), ignore_errors=True)


def test_lesson_leads_to_the_results_that_it_describes(reader):
    steps = sections()
    assert sorted(steps) == list(range(1, 12))
    world = reader.workspace / "src" / "world" / "scripts" / "world_node.py"
    driver = reader.workspace / "src" / "driverless" / "scripts" / "driverless_node.py"

    reader.follow(steps[1])
    assert {"build", "devel", "src"} <= {path.name for path in reader.workspace.iterdir()}

    reader.check(1)

    reader.follow(steps[2])
    reader.check(2)
    expected = [block for language, _, block in blocks(steps[2]) if language == "text"][-1]
    assert expected in reader.run("rosmsg show um_msgs/Waypoints")

    reader.follow(steps[3])
    reader.start(f"roscore -p {reader.port}")  # avoid the port of another master
    reader.wait_for(lambda: "/rosout" in reader.run("rostopic list || true"), "the master")
    node = reader.start("rosrun world world_node.py")
    expected = [block for language, _, block in blocks(steps[3]) if language == "text"][-1]
    output = re.sub(r" +$", "", reader.echo("/world_waypoints"), flags=re.MULTILINE)
    assert expected in output and output.count("idx:") == POINTS
    reader.check(3)
    reader.stop(node)

    reader.follow(steps[4])
    assert (reader.workspace / "src" / "qt_interface" / "package.xml").exists()
    reader.run("roslaunch --files qt_interface qt_interface.launch")
    reader.check(4)

    reader.follow(steps[5])
    node = reader.start("rosrun world world_node.py")
    hz = f"PYTHONUNBUFFERED=1 timeout {LIMIT_SECONDS:.0f} rostopic hz -w 60 /car_position"
    assert "average rate: " in reader.run(f"{hz} | grep --max-count=1 'average rate: '")
    reader.wait_for(
        lambda: abs(reader.number("/car_position", "direction") - 0.6) > 0.1, "a bounce"
    )
    assert reader.run("rosparam get /world/field_width").strip() == "800"
    reader.check(5)
    reader.stop(node)

    publisher, tick = [block for language, _, block in blocks(steps[6]) if language == "python"]
    edit(
        world,
        '        self.car_pub = rospy.Publisher("/car_position", CarPosition, queue_size=10)\n',
        '        self.car_pub = rospy.Publisher("/car_position", CarPosition, queue_size=10)\n'
        + publisher,
    )
    edit(
        world,
        "    def tick(self, event):\n        self.move()\n        self.car_pub.publish(self.car)\n",
        tick,
    )
    importing, subscriber, callback = [
        block for language, _, block in blocks(steps[7]) if language == "python"
    ]
    edit(world, "from um_msgs.msg import CarPosition, Waypoint, Waypoints\n", importing)
    edit(
        world,
        "        rospy.Timer(rospy.Duration(TICK), self.tick)\n",
        "        rospy.Timer(rospy.Duration(TICK), self.tick)\n" + subscriber,
    )
    edit(world, "    def move(self):\n", callback + "\n    def move(self):\n")
    node = reader.start("rosrun world world_node.py")
    reader.wait_for(lambda: "idx" in reader.echo("/sensed_waypoints"), "a sensed point")
    reader.check("6 7")
    before = reader.number("/car_position", "direction")
    reader.run("rostopic pub -1 /cmd um_msgs/SteeringCommand 1.5708")
    turned = reader.number("/car_position", "direction") - before
    assert any(
        abs(abs(math.remainder(way, 2 * math.pi)) - 1.5708) < 1e-3
        for way in (turned, turned + 2 * before, math.pi - turned, math.pi - turned - 2 * before)
    )

    reader.follow(steps[8])
    (wrap,) = [block for language, _, block in blocks(steps[9]) if language == "python"]
    edit(driver, wrap.splitlines(keepends=True)[0], wrap)
    driving = reader.start("rosrun driverless driverless_node.py")
    reader.wait_for(lambda: "/driverless" in reader.run("rosnode list"), "the driver")
    reader.check("8 9")
    reader.stop(driving)
    reader.stop(node)

    reader.follow(steps[10])
    reader.check(10)
    reader.stop_all()
    reader.start("roslaunch demo_launcher demo.launch headless:=true")
    reader.wait_for(
        lambda: "idx" in reader.run("timeout 30 rostopic echo -n 1 /target_waypoint || true"),
        "driver",
    )
    record = reader.home / "targets.txt"
    record.write_text("")
    reader.start(f"rostopic echo /target_waypoint/idx > {record}")

    def targets():
        return [int(idx) for idx in re.findall(r"^(\d+)$", record.read_text(), flags=re.MULTILINE)]

    reader.wait_for(
        lambda: {8, 9, 10} <= set(targets()), "the points where the direction is near pi"
    )
    seen = targets()
    assert {(after - before) % POINTS for before, after in zip(seen, seen[1:])} <= {0, 1}, (
        "the target moves to the next point, never back"
    )
    stays = [len(list(same)) for _, same in itertools.groupby(seen)]
    assert max(stays[1:]) < 30, "no loop: a loop takes 43 ticks, a point 13"
