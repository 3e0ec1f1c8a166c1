"""Works through docs/first-steps.md as a reader does: types its commands, writes its files, looks at what comes out."""

import itertools
import math
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

FIRST_STEPS = Path(__file__).resolve().parents[2]
WORKSHOP = FIRST_STEPS.parents[2]
LESSON = WORKSHOP / "docs" / "first-steps.md"
LIMIT_SECONDS = 60.0
POINTS = 30  # of the ellipse
RUNNING = (
    "roscore",
    "rosrun",
    "roslaunch",
    "rostopic",
    "export WORKSHOP",
)  # commands for terminals of their own

pytestmark = pytest.mark.skipif(not LESSON.exists(), reason="the lesson is not beside the packages")


def sections():
    """The lesson's numbered sections: {number: text}."""
    parts = re.split(r"^## (\d+)\. ", LESSON.read_text(), flags=re.MULTILINE)
    return {int(number): text for number, text in zip(parts[1::2], parts[2::2])}


def blocks(text):
    """The fenced blocks: (language, the text before it, the block)."""
    return [
        (match[2], match[1], match[3])
        for match in re.finditer(
            r"(.*?)^```(\w+)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL
        )
    ]


class Reader:
    """Somebody with an empty home who follows the lesson."""

    def __init__(self, home):
        self.home, self.workspace, self.folder = home, home / "first_steps_ws", str(home)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        interpreter = os.path.dirname(
            sys.executable
        )  # catkin shall build for the Python that runs this test
        self.environment = {
            "HOME": str(home),
            "WORKSHOP": str(WORKSHOP),
            "PATH": f"{interpreter}:/usr/bin:/bin",
            "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "PYTHONUNBUFFERED": "1",
        }
        for (
            name,
            value,
        ) in os.environ.items():  # what the system's own ROS set up, not what a workspace added
            if name in (
                "ROS_DISTRO",
                "ROS_ROOT",
                "ROS_ETC_DIR",
                "ROS_VERSION",
                "ROS_PYTHON_VERSION",
                "LANG",
            ):
                self.environment[name] = value
        self.processes = []

    def shell(self, command):
        known = "".join(
            f"[ -f {path} ] && . {path}\n"
            for path in ("/opt/ros/noetic/setup.bash", self.workspace / "devel" / "setup.bash")
        )
        return ["bash", "-c", known + command]

    def run(self, command):
        """Types the commands into a terminal and waits for them; returns what they print."""
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

    def start(self, command):
        """Types the command into a terminal of its own."""
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
        """Presses Ctrl-C."""
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
        """Writes the files of a section and types its commands that end by themselves, in the order they stand in."""
        for language, before, block in blocks(text):
            named = re.findall(r"`([\w/]+\.(?:msg|py|txt|launch))`", before)
            if language == "bash" and not block.startswith(RUNNING):
                said = self.run(
                    f"cd {self.folder}\n{block.replace('source devel/setup.bash', '')}\npwd"
                )
                self.folder = said.splitlines()[-1]  # the terminal stays where it was
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

    def ask(self, topic, count=1):
        """What is said on a topic."""
        return self.run(f"timeout {LIMIT_SECONDS:.0f} rostopic echo -n {count} {topic}")

    def number(self, topic, field):
        """A number from a message on a topic."""
        return float(self.ask(f"{topic}/{field}").split()[0])

    def wait_for(self, condition, what):
        end = time.monotonic() + LIMIT_SECONDS
        while not condition():
            assert time.monotonic() < end, f"waited in vain for {what}"
            time.sleep(0.1)


def edit(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1, f"{path}: {old!r} is there {text.count(old)} times"
    path.write_text(text.replace(old, new))


@pytest.fixture
def reader(tmp_path):
    reader = Reader(tmp_path)
    yield reader
    reader.stop_all()
    shutil.rmtree(str(tmp_path), ignore_errors=True)


def test_the_lesson_holds_what_it_promises(reader):
    steps = sections()
    assert sorted(steps) == list(range(1, 12))
    world = reader.workspace / "src" / "world" / "scripts" / "world_node.py"
    driver = reader.workspace / "src" / "driverless" / "scripts" / "driverless_node.py"

    reader.follow(steps[1])
    assert {"build", "devel", "src"} <= {path.name for path in reader.workspace.iterdir()}

    reader.follow(steps[2])
    promised = [block for language, _, block in blocks(steps[2]) if language == "text"][-1]
    assert promised in reader.run("rosmsg show um_msgs/Waypoints")

    reader.follow(steps[3])
    reader.start(f"roscore -p {reader.port}")  # a port of its own, so as not to meet another master
    reader.wait_for(lambda: "/rosout" in reader.run("rostopic list || true"), "the master")
    node = reader.start("rosrun world world_node.py")
    promised = [block for language, _, block in blocks(steps[3]) if language == "text"][-1]
    said = re.sub(r" +$", "", reader.ask("/world_waypoints"), flags=re.MULTILINE)
    assert promised in said and said.count("idx:") == POINTS
    reader.stop(node)

    reader.follow(steps[4])
    assert (reader.workspace / "src" / "qt_interface" / "package.xml").exists()
    reader.run("roslaunch --files qt_interface qt_interface.launch")

    reader.follow(steps[5])
    node = reader.start("rosrun world world_node.py")
    reader.wait_for(
        lambda: (
            "average rate: "
            in reader.run("timeout -s INT 4 rostopic hz -w 60 /car_position || true")
        ),
        "a rate",
    )
    reader.wait_for(
        lambda: abs(reader.number("/car_position", "direction") - 0.6) > 0.1, "a bounce"
    )
    assert reader.run("rosparam get /world/field_width").strip() == "800"
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
    reader.wait_for(lambda: "idx" in reader.ask("/sensed_waypoints"), "a sensed point")
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
    reader.stop(node)

    reader.follow(steps[10])
    reader.stop_all()
    reader.start("roslaunch demo_launcher demo.launch headless:=true")
    reader.wait_for(
        lambda: "idx" in reader.run("timeout 9 rostopic echo -n 1 /target_waypoint || true"),
        "driver",
    )
    record = reader.home / "targets.txt"
    record.write_text("")
    reader.start(f"rostopic echo /target_waypoint/idx > {record}")

    def targets():
        return [int(idx) for idx in re.findall(r"^(\d+)$", record.read_text(), flags=re.MULTILINE)]

    reader.wait_for(lambda: {8, 9, 10} <= set(targets()), "the place where it turns at pi")
    seen = targets()
    assert {(after - before) % POINTS for before, after in zip(seen, seen[1:])} <= {0, 1}, (
        "from one point to the next, never back"
    )
    stays = [len(list(same)) for _, same in itertools.groupby(seen)]
    assert max(stays[1:]) < 30, "no needless loop: it takes 43 ticks, a point 13"
