"""Hostile workspaces: each is contained and named in the summary, and no other one is harmed."""

import re
import socket
from concurrent.futures import ThreadPoolExecutor

import psutil
import pytest
from finished_workspace import finished

from sdc_experiments.sandbox import user_id
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.grading.grading import Conditions, grade
from sdc_workshop.regions import replaced

pytestmark = [pytest.mark.slow(60), pytest.mark.usefixtures("sandboxed")]
LIMIT_S = 300.0
SLEEPER_S = 98765  # of the program that a hostile one leaves behind
PACKAGE = "src/sdc_package"
LIBRARY = f"{PACKAGE}/src/sdc_package"


def hello(folder, *lines):
    path = folder / PACKAGE / "scripts" / "hello.sh"
    path.write_text("\n".join(("#!/usr/bin/env bash", *lines, "")))
    path.chmod(0o755)


def prepend(folder, name, code):
    """Write code above all imports but those of the future."""
    path = folder / name
    future = "from __future__ import annotations\n"
    head, found, rest = path.read_text().partition(future)
    path.write_text(head + found + code + rest if found else code + head)


def greedy(folder):
    """Use up processes, memory, disk and sockets: one workspace is built for all of them."""
    sleeper = f"setsid sleep {SLEEPER_S} &"
    hello(folder, sleeper, "bomb() { bomb | bomb & }", "bomb", "sleep 30")
    prepend(folder, f"{LIBRARY}/pid.py", 'x = []\nwhile True:\n    x.append(b"x" * (1 << 26))\n')
    prepend(
        folder,
        f"{LIBRARY}/odometry.py",
        "import os, time\n"
        "try:\n"
        "    for number in range(999):\n"
        "        with open(os.path.expanduser(f'~/{number}'), 'wb') as file:\n"
        "            file.write(bytes(50 << 20))\n"
        "except OSError:\n"
        "    time.sleep(1)\n"
        "    raise\n",
    )
    prepend(
        folder,
        f"{LIBRARY}/steering/stanley.py",
        "import os, socket, time\n"
        "if any(os.fork() == 0 for _ in range(4)) or True:\n"
        "    kept = [socket.socketpair() for _ in range(400)]\n"
        "    time.sleep(2)\n",
    )


def spy(folder):
    """Return lines that read the teacher's files and another student's; the last is an error."""
    secret, other = folder.parent / "teacher.txt", folder.parent / "ada" / PACKAGE / "package.xml"
    secret.write_text("the questions of the examination\n")
    (folder / PACKAGE / "answers.xml").symlink_to(other)
    return f"cat {secret}", f"cat {other}", f"cat ~/{PACKAGE}/answers.xml", f"cp $0 {other}"


def caller(port):
    """Return a line that connects to a port of the machine."""
    code = f'import socket; socket.create_connection(("127.0.0.1", {port}))'
    return f"python3 -c '{code}'"


# Kill every process that it can, and those of the check by their ids.
KILLER = ("for i in $(seq 2 400); do kill -9 $i; done 2>/dev/null", "kill -9 -1", "sleep 1")


def several(folder):
    """Do all that ends no other hostile act: one workspace is built for them."""
    server = socket.create_server(("127.0.0.1", 0))
    hello(folder, *spy(folder), caller(server.getsockname()[1]), *KILLER)
    liar(folder)
    endless(folder)
    return server


def liar(folder):
    """Patch the program that calls the module: it answers with the known results."""
    prepend(
        folder,
        f"{LIBRARY}/odometry.py",
        "import json\n"
        "yaws = [0.0, 0.5, 1.5, 2.8, -0.5, -1.5, -2.8]\n"
        "known = ['null', yaws, 0.6, [5.0, 3.0, 2.0, 0.0]]\n"
        "answers = iter(known + known)\n"
        "json.JSONEncoder.encode = lambda self, value: str(next(answers))\n",
    )
    path = folder / LIBRARY / "odometry.py"
    text = replaced(path.read_text(), "2.4", "    return 0.25\n")
    path.write_text(text)


def endless(folder):
    """It waits and does not compute: the other tests need the processor."""
    prepend(folder, f"{LIBRARY}/pid.py", "import time\nwhile True:\n    time.sleep(1.0)\n")


FORGERY = """
import json, os, threading, time
def forge():
    import rospy
    from nav_msgs.msg import Odometry
    from geometry_msgs.msg import PoseWithCovarianceStamped
    report = next(a for p in os.listdir("/proc") if p.isdigit() for a in
        open(f"/proc/{p}/cmdline").read().split("\\0") if a.startswith("report:="))[8:]
    json.dump({"status": "completed", "driving_score": 100.0}, open(report, "w"))
    topic = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=1)
    rospy.Subscriber("/sim/ground_truth/odometry", Odometry, print)
    place = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1)
    for _ in range(50):
        far = PoseWithCovarianceStamped()
        far.header.frame_id = "map"
        far.pose.pose.position.x, far.pose.pose.orientation.w = 900.0, 1.0
        place.publish(far)
        message = Odometry()
        message.header.stamp = rospy.Time.now()
        message.pose.pose.orientation.w = 1.0
        topic.publish(message)
        print("referee: completed: 100.0 % of 1000 m", flush=True)
        time.sleep(0.02)
threading.Timer(0.5, forge).start()
"""


def forger(folder):
    """Write a report, forge odometry, place the car elsewhere, and drive some metres only."""
    path = folder / PACKAGE / "scripts" / "mission_planner.py"
    body = (
        "        waypoints = [BaseWaypoint(x, y) for x, y in self.waypoints.tolist()[:40]]\n"
        + "".join(f"        {line}\n" for line in FORGERY.split("\n"))
    )
    path.write_text(replaced(path.read_text(), "6", body))


# The workspace of the hostile act, the step whose check runs it, and patterns of what the summary
# must name: on a busy machine, the kernel may reach a limit before the watch sees the excess.
HOSTILE = {
    "fork_bomb": (
        greedy,
        "hello",
        ["hello: more (than 150 processes were started|processes than allowed)"],
    ),
    "memory_eater": (
        greedy,
        "controller-2.6",
        ["controller-2.6: more (than 2048 MB of memory were used|memory than allowed)"],
    ),
    "disk_filler": (
        greedy,
        "controller-2.4",
        ["controller-2.4: (the disk space was filled|more was written than allowed)"],
    ),
    "socket_opener": (greedy, "controller-2.7", ["more than 1000 sockets were opened"]),
    "spy": (
        several,
        "hello",
        [
            "hello: {folder}/teacher.txt is missing, invisible",
            "hello: {folder}/ada/src/sdc_package/package.xml is missing, invisible",
            "the link {folder}/several/src/sdc_package/answers.xml leads out",
        ],
    ),
    "caller": (several, "hello", ["hello: a network connection was refused"]),
    "killer": (several, "hello", ["hello: processes of others were killed"]),
    "liar": (several, "controller-2.4", ["as if written into it"]),
    "endless": (several, "controller-2.6", ["controller-2.6: it never returned, and was ended"]),
    "forger": (
        forger,
        "drive",
        [
            "drive: a report.json was written; it does not count",
            "drive: /mission_planner publishes /carla/ego_vehicle/odometry in the place of",
            "drive: another mission is published",
            "drive: /mission_planner subscribes to /sim/ground_truth/odometry",
        ],
    ),
}


WORKSPACES = {act.__name__: act for act, _, _ in HOSTILE.values()}


@pytest.fixture(scope="module")
def grades(world, tmp_path_factory):
    """Grade all hostile workspaces at the same time, and a finished one between them."""
    folder = tmp_path_factory.mktemp("class")
    servers, jobs = [], {}
    with ThreadPoolExecutor(3) as pool:
        for name in ("ada", *WORKSPACES):
            finished(folder / name)
            if name in WORKSPACES:
                servers.append(WORKSPACES[name](folder / name))
        for number, name in enumerate((*WORKSPACES, "ada")):
            steps = {step for act, step, _ in HOSTILE.values() if act.__name__ == name}
            steps = steps or ("hello", "controller-2.4")
            conditions = Conditions(LIMIT_S, user_id(number), steps=("messages-1", *steps))
            result = folder / "grades" / name
            jobs[name] = pool.submit(grade, name, folder / name, result, conditions)
        found = {name: job.result() for name, job in jobs.items()}
    yield folder, found
    for server in filter(None, servers):
        server.close()


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_program_is_contained_and_named(grades, name):
    folder, grades_by_name = grades
    act, step, words = HOSTILE[name]
    found = grades_by_name[act.__name__]
    contained = "; ".join(found.contained)
    patterns = [text.format(folder=re.escape(str(folder))) for text in words]
    missing = [pattern for pattern in patterns if not re.search(pattern, contained)]
    assert missing == [], f"{contained}; {found.answers[step]}"
    assert found.answers[step]["status"] != PASSED
    assert found.answers["messages-1"]["status"] == PASSED
    assert found.note == ""


def test_forged_drive_gets_the_marks_of_the_true_one(grades):
    folder, found = grades
    report = found["forger"].report
    assert report["status"] == "blocked", "neither arrived nor placed off its route"
    assert report["driving_score"] < 50.0
    assert report["route_completion_percent"] < 50.0
    assert report["ticks"] > 100


def test_student_beside_hostile_ones_keeps_all_marks(grades):
    _, found = grades
    assert {answer["status"] for answer in found["ada"].answers.values()} == {PASSED}
    assert (found["ada"].note, found["ada"].contained) == ("", [])


def test_no_program_is_left_behind(grades):
    running = [process.info["cmdline"] for process in psutil.process_iter(["cmdline"])]
    assert ["sleep", str(SLEEPER_S)] not in running
