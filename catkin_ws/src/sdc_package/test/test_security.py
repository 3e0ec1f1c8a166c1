"""Drives do not affect each other, open no port beyond loopback, and run no code of a file."""

import json
import os
import re
import subprocess

import pytest

from sdc_common.processes import processes_with

pytestmark = pytest.mark.slow(30)

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.abspath(os.path.join(HERE, "..", "..", "..", ".."))
DRIVE = os.path.join(ROOT, "drive")
LISTENS = "0A"


def sockets_of(pids):
    """Return the numbers of all sockets of some processes."""
    numbers = set()
    for pid in pids:
        try:
            for name in os.listdir(f"/proc/{pid}/fd"):
                numbers.update(
                    re.findall(r"socket:\[(\d+)\]", os.readlink(f"/proc/{pid}/fd/{name}"))
                )
        except OSError:
            continue
    return numbers


def listening(pids):
    """Return (protocol, address) of all listening sockets, with addresses as in /proc/net."""
    numbers = sockets_of(pids)
    found = set()
    for protocol in ("tcp", "tcp6", "udp", "udp6"):
        with open(f"/proc/net/{protocol}", encoding="ascii") as file:
            for line in file.read().splitlines()[1:]:
                (_, local, _, state, *_) = line.split()
                if line.split()[9] in numbers and (state == LISTENS or protocol.startswith("udp")):
                    found.add((protocol, local.split(":")[0]))
    return found


def test_two_drives_at_once_choose_masters_of_their_own_and_give_equal_traces(
    environment, start, bend, tmp_path
):
    names = ("one", "two")
    network = ("ROS_MASTER_URI", "ROS_IP", "ROS_HOSTNAME", "SDC_MASTER_URI")
    default = {name: value for name, value in environment.items() if name not in network}
    folder = tmp_path / "elsewhere"
    elsewhere = f"planner_options:={{report: {folder}/r.json, log_folder: {folder}}}"
    options = ["headless:=true", "sync:=true", "camera:=false", f"waypoints_path:={bend}"]
    options.append("verbose:=true")
    drives = []
    for name in names:
        (tmp_path / name).mkdir()
        drives.append(start([DRIVE, *options, elsewhere], default, tmp_path / name))
    assert [drive.wait_for_end() for drive in drives] == [0, 0], [
        drive.output[-2000:] for drive in drives
    ]
    masters = {re.search(r"ROS_MASTER_URI=(http://.*?:\d+)", drive.output)[1] for drive in drives}
    assert len(masters) == 2, "each has a master of its own"
    assert any("export ROS_MASTER_URI=" in drive.output for drive in drives)
    traces = {(tmp_path / name / "report" / "report.csv").read_bytes() for name in names}
    assert len(traces) == 1, "the other drives have no effect"
    assert sorted(os.listdir(tmp_path)) == sorted(["bend.csv", "log0", "log1", "ros", *names])
    for name in names:
        assert os.listdir(tmp_path / name) == ["report"]
        report = json.loads((tmp_path / name / "report" / "report.json").read_text())
        assert report["missed_ticks"] == 0


def test_drive_listens_on_loopback_only_and_refuses_a_second_one(environment, start, tmp_path):
    """The second one would write the report of the first, or use its master."""
    options = ["headless:=true", "camera:=false", "referee_options:={pictures: false}"]
    first = start([DRIVE, *options], environment)
    first.wait_for_output("cross-track error")
    uri = environment["ROS_MASTER_URI"]
    pids = [process.pid for process in processes_with("ROS_MASTER_URI", uri)]
    assert len(sockets_of(pids)) > 20
    local = {("tcp", "0100007F"), ("udp", "0100007F"), ("tcp6", 24 * "0" + "01000000")}
    assert ("tcp", "0100007F") in listening(pids) <= local
    second = start([DRIVE, *options], environment)
    assert second.wait_for_end() == 2
    assert "drive: another drive writes" in second.output
    third = start([DRIVE, *options, "report:=other.json"], environment)
    assert third.wait_for_end() == 2
    assert "is in use by /sim (host 127.0.0.1, process " in third.output
    assert first.interrupt() == 130
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report["status"] == "aborted"


TOUCH = "__import__('os').system('touch {mark}')"
# ./test tries the first two; test_safe_launch.py has what refuses them.
CODE = [
    ('planner_options:={{lookahead_m: !radians "' + TOUCH + '"}}', None),
    ("scenario:={file}", "about: !!python/object/apply:os.system ['touch {mark}']\nroute: town\n"),
    ('sim_options:={{friction: !degrees "' + TOUCH + '"}}', None),
    ('planner_options:={{lookahead_m: !!python/object/apply:os.system ["touch {mark}"]}}', None),
    ("scenario:={file}", 'route: "$(eval ' + TOUCH + ')"\n'),
    ("obstacles_path:={file}", 'frame: map\nobstacles: !radians "' + TOUCH + '"\n'),
    ("waypoints_path:={file}", TOUCH + ",1\n2,3\n"),
    ("waypoints_path:=$(eval " + TOUCH + ")", None),
]


@pytest.mark.parametrize(
    ("argument", "content"),
    [*CODE[:2], *(pytest.param(*row, marks=pytest.mark.nightly) for row in CODE[2:])],
    ids=[f"{row[0].split(':=')[0]}{number}" for number, row in enumerate(CODE)],
)
def test_no_file_and_no_option_runs_code(environment, start, tmp_path, argument, content):
    mark, file = tmp_path / "mark", tmp_path / "file"
    if content:
        file.write_text(content.format(mark=mark))
    options = ["headless:=true", "sync:=true", "camera:=false"]
    drive = start([DRIVE, *options, argument.format(mark=mark, file=file)], environment)
    assert drive.wait_for_end() not in (0, None)
    assert not mark.exists(), drive.output
    assert not (tmp_path / "report" / "report.json").exists()


def test_container_runs_as_an_unprivileged_user():
    with open(os.path.join(ROOT, "docker", "Dockerfile"), encoding="utf-8") as file:
        users = re.findall(r"^USER\s+(\S+)", file.read(), re.MULTILINE)
    assert users
    assert users[-1] not in ("root", "0")
    with open(os.path.join(ROOT, "docker", "compose.yaml"), encoding="utf-8") as file:
        compose = file.read()
    for power in ("privileged", "network_mode", "cap_add", "user:"):
        assert power not in compose
    # test_container.py compares the ports: this machine only.
    assert all("127.0.0.1:" in port for port in re.findall(r"ports:\s+- (.*)", compose))


def ip(*arguments):
    return subprocess.run(["ip", *arguments], capture_output=True, text=True, check=False)


@pytest.fixture
def two_machines():
    """Provide (name, address) of two connected network namespaces, which act as two machines."""
    names = [f"workshop{os.getpid()}{end}" for end in "ab"]
    addresses = ["10.213.7.1", "10.213.7.2"]
    made = [ip("netns", "add", name) for name in names]
    try:
        if any(done.returncode for done in made):
            pytest.skip(f"cannot create network namespaces here: {made[0].stderr.strip()}")
        wires = [f"wsp{os.getpid() % 100000}{end}" for end in "ab"]
        wired = ip("link", "add", wires[0], "type", "veth", "peer", "name", wires[1])
        if wired.returncode:
            pytest.skip(f"cannot connect network namespaces here: {wired.stderr.strip()}")
        for name, wire, address in zip(names, wires, addresses):
            for step in (
                ("link", "set", wire, "netns", name),
                ("-n", name, "address", "add", address + "/24", "dev", wire),
                ("-n", name, "link", "set", wire, "up"),
                ("-n", name, "link", "set", "lo", "up"),
            ):
                done = ip(*step)
                if done.returncode:  # in a chroot, ip cannot enter them
                    pytest.skip(f"cannot use network namespaces here: {done.stderr.strip()}")
        yield list(zip(names, addresses))
    finally:
        for name in names:
            ip("netns", "del", name)


@pytest.mark.nightly
def test_simulator_and_stack_run_on_two_machines(two_machines, start, bend, tmp_path):
    (world, world_address), (car, car_address) = two_machines
    common = {**os.environ, "ROS_MASTER_URI": f"http://{world_address}:11311"}
    common.pop("ROS_HOSTNAME", None)
    folders = {name: tmp_path / name for name in ("world", "car")}
    for folder in folders.values():
        folder.mkdir()
    route = ["camera:=false", f"waypoints_path:={bend}"]

    def launch(machine, address, name, *words):
        """Start a launch file in the folder of this name."""
        variables = {**common, "ROS_IP": address, "ROS_HOME": str(folders[name])}
        command = ["ip", "netns", "exec", machine, "roslaunch", *words, *route]
        return start(command, variables, folders[name])

    options = "sync:=true", "wait_for_nodes:=[/referee]"
    here = launch(world, world_address, "world", "sdc_sim", "sim.launch", *options)
    here.wait_for_output("process[sim")
    options = "sim:=false", "headless:=true", "referee_options:={pictures: false}"
    there = launch(car, car_address, "car", "sdc_package", "all.launch", *options)
    assert there.wait_for_end() == 0, there.output[-3000:] + here.output[-3000:]
    here.interrupt()
    report = json.loads((folders["car"] / "report" / "report.json").read_text())
    assert (report["status"], report["missed_ticks"]) == ("completed", 0)
