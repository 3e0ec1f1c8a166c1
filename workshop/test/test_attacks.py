"""Attacks of attacks.yaml on what a student must not see or use up, each beside its control."""

import functools
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from finished_workspace import finished

from sdc_experiments.sandbox import user_id
from sdc_workshop.exam.limits import control_groups, entering, has_share, kills
from sdc_workshop.grading.grade import line
from sdc_workshop.grading.grading import Conditions, grade
from sdc_workshop.grading.handed_in import names
from sdc_workshop.grading.rubric import load_rubric
from sdc_workshop.grading.summary import ranked, write_csv
from sdc_workshop.workspace import make

pytestmark = [pytest.mark.slow(60), pytest.mark.usefixtures("sandboxed")]
TABLE = yaml.safe_load(Path(__file__).with_name("attacks.yaml").read_text())
LIMIT_S = 300.0
WORKSHOP = Path(__file__).resolve().parents[1]
# For a process of its own, whose memory is measured.
OWN = {**os.environ, "PYTHONPATH": f"{WORKSHOP}{os.pathsep}{os.environ['PYTHONPATH']}"}
# Call the attempts one after the other, and end the launch with the list of those that succeeded.
ATTEMPTS = """
import json, os, signal, sys, time
succeeded = []
for name, attempt in attempts:
    try:
        succeeded += [name] if attempt() else []
    except Exception:
        pass
print("Traceback (most recent call last):\\n  File \\"x\\", line 1, in x")
print("Attempts:", json.dumps(succeeded), flush=True)
"""


def program(rows):
    """Return the text of a program that makes the attempts of some rows."""
    listed = ", ".join(f"({row['name']!r}, lambda: {row['found']})" for row in rows)
    code = "".join(row.get("code", "") for row in rows)
    return f"{TABLE['common']}{code}\nattempts = [{listed}]\n{ATTEMPTS}"


@pytest.fixture(scope="module")
def succeeded(world, tmp_path_factory):
    """Return a function that drives the car of a lab once, and returns what succeeded."""

    @functools.lru_cache
    def of(lab):
        folder = finished(tmp_path_factory.mktemp("student") / "eve", lab)
        code = program([row for row in TABLE["drive"] if row["lesson"] == lab])
        end = "os.kill(os.getppid(), signal.SIGINT)\ntime.sleep(99)\n"
        node = folder / "src" / TABLE["nodes"][lab]
        node.write_text(f"#!/usr/bin/env python3\n{code}{end}")
        conditions = Conditions(LIMIT_S, user_id(1), steps=(f"{lab}-drive",), lab=lab)
        return attempts(grade("eve", folder, folder.parent / "result", conditions))

    return of


def attempts(found):
    (answer,) = found.answers.values()
    # Behind it may be what the check says of the drive.
    return json.JSONDecoder().raw_decode(answer["seen"].partition("Attempts: ")[2])[0]


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, marks=pytest.mark.nightly if row["lesson"] == "perception" else ())
        for row in TABLE["drive"]
    ],
    ids=lambda row: row["name"],
)
def test_program_sees_nothing_of_the_referee(succeeded, row):
    assert (row["name"] in succeeded(row["lesson"])) == bool(row.get("control"))


@pytest.fixture(scope="module")
def hello(world, tmp_path_factory):
    folder = tmp_path_factory.mktemp("memory") / "eve"
    make(folder)
    script = folder / "src" / "sdc_package" / "scripts" / "hello.sh"
    code = program(TABLE["memory"]) + "sys.exit(1)\n"
    script.write_text(f"#!/usr/bin/env bash\nexec python3 - <<'END'\n{code}END\n")
    script.chmod(0o755)
    conditions = Conditions(LIMIT_S, user_id(2), steps=("hello",), seed=471104711047110)
    return attempts(grade("eve", folder, folder.parent / "result", conditions))


@pytest.mark.parametrize("row", TABLE["memory"], ids=lambda row: row["name"])
def test_program_takes_no_more_memory_than_its_limit_and_sees_no_secret(hello, row):
    assert (row["name"] in hello) == bool(row.get("control"))


PEAK = """
import resource, sys
from pathlib import Path
from sdc_workshop.exam.student import NotBuilt, Student
try:
    Student(Path(sys.argv[1])).environment
except NotBuilt:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_output_of_a_setup_file_does_not_fill_the_memory(tmp_path):
    peaks = []
    for megabytes in (0, 300):
        folder = tmp_path / str(megabytes)
        (folder / "devel").mkdir(parents=True)
        text = f"head -c {megabytes}M /dev/zero >&2\n"
        (folder / "devel" / "setup.bash").write_text(text)
        done = subprocess.run([sys.executable, "-c", PEAK, folder], stdout=-1, check=True, env=OWN)
        peaks.append(int(done.stdout))
    assert peaks[1] < peaks[0] + 50_000  # kB


FLOOD = """
import os, sys, xmlrpc.client
os.environ["ROS_IP"] = "127.0.0.1"
from rosmaster.master import Master
from sdc_common.ros.drive_master import free_master_port
from sdc_workshop.exam.limits import limit_requests
said = []
limit_requests(said.append)
master = Master(port=free_master_port())
master.start()
proxy = xmlrpc.client.ServerProxy(master.uri)
try:
    for count in range(int(sys.argv[1])):
        proxy.setParam("/me", f"/large/{count}", "x" * 900_000)
except (xmlrpc.client.ProtocolError, OSError):
    pass
print(count, len(said))
"""


@pytest.mark.parametrize(("sent", "refused"), ((50, 0), (100, 1)))
def test_large_parameters_do_not_fill_the_memory_of_the_check(sent, refused):
    done = subprocess.run([sys.executable, "-c", FLOOD, str(sent)], stdout=-1, check=True, env=OWN)
    count, said = map(int, done.stdout.split())
    assert (count < sent - 1, said) == (bool(refused), refused)
    assert count < 80


EATER = "import os, sys; f = os.memfd_create('x'); [os.write(f, bytes(1 << 20)) for _ in range({})]"


def test_control_group_counts_files_in_memory():
    with control_groups() as (check, programs):
        if programs is None:
            pytest.skip("this machine allows no control group")
        for megabytes, killed in ((100, 0), (2500, 1)):
            command = [sys.executable, "-c", EATER.format(megabytes)]
            done = subprocess.run(entering(programs, command), check=False)
            assert (done.returncode != 0, kills(programs)) == (bool(killed), killed)
    assert not any(Path(path).parent.exists() for path in check.split(":"))


def test_program_has_a_share_of_the_processor_in_its_control_group():
    with control_groups() as (check, programs):
        if not has_share(check):
            pytest.skip("this machine allows no control group")
        command = entering(programs, ["cat", "/proc/self/cgroup"])
        shown = subprocess.run(command, check=True, stdout=-1, text=True).stdout
        assert all("/" + path.split("/", 5)[-1] in shown for path in programs.split(":"))


def test_no_control_group_where_the_kernel_offers_none(tmp_path):
    with control_groups(tmp_path) as groups:
        assert groups == (None, None)
    assert [*tmp_path.iterdir()] == []


def test_name_of_a_file_writes_no_line_of_the_table(tmp_path):
    forged = "eve\ngrade: ada: 58 of 58 steps\x1b[1A"
    (tmp_path / forged).mkdir()
    grades = []
    for folder, name in names([tmp_path / "ada", tmp_path / forged]).items():
        grades.append(grade(name, folder, tmp_path / "result", Conditions(LIMIT_S)))
        assert line(grades[-1], 58).isprintable()
        assert "\\n" in grades[-1].note or folder.name == "ada"
    write_csv(tmp_path / "grades.csv", ranked(grades, load_rubric()))
    assert len((tmp_path / "grades.csv").read_text().splitlines()) == 3


def test_summary_does_not_show_whether_a_file_exists(world, tmp_path):
    path = tmp_path / "secret"
    path.touch()
    folder = tmp_path / "eve"
    make(folder)
    script = folder / "src" / "sdc_package" / "scripts" / "hello.sh"
    script.write_text(f"#!/usr/bin/env bash\ncat {path} ~/absent\n")
    script.chmod(0o755)
    conditions = Conditions(LIMIT_S, user_id(3), steps=("hello",))
    found = grade("eve", folder, tmp_path / "result", conditions)
    assert found.contained == [f"hello: {path} is missing, invisible or read only in the sandbox"]
