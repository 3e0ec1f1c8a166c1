"""Sweeps in real processes: kills, interrupts, a cluster of another terminal, real nodes."""

import json
import os
import signal
import socket
import sys
import time
from collections import Counter
from pathlib import Path

import distributed
import psutil
import pytest

from sdc_common.processes import matching
from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_testing.program import Program, programs

pytestmark = pytest.mark.slow(15)

SCRIPT = Path(__file__).resolve().parents[1] / "scripts" / "sweep.py"
LIMIT_S = 300.0
CELLS, FAILING = 36, 9
SCENARIO = "route: [{straight_m: 10}, {left_deg: 20, radius_m: 30, transition_m: 4}]\n"
STUDY = """
scenarios: [bend.yaml]
settings: {steering_method: stanley, planned_speed_mps: 4.0}
factors:
  simple_controller/stanley/k: [1.0, 2.5, -1.0, 4.0]
  sim_options/odometry_noise/position_m: [0.0, 0.02, 0.1]
seeds: 3
metrics: [cross_track_rms_m]
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "bend.yaml").write_text(SCENARIO)
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    return path


@pytest.fixture
def start(tmp_path):
    with programs(tmp_path, end=Program.kill) as start:
        yield start


def wait_for(condition, program):
    limit = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < limit, program.output
        time.sleep(0.02)


def rows(folder):
    path = folder / "drives.jsonl"
    lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
    return [json.loads(line) for line in lines if line.endswith(b"\n")]


def wait_for_rows(folder, count, program):
    wait_for(lambda: len(rows(folder)) >= count or program.process.poll() is not None, program)
    assert program.process.poll() is None, f"it ended too early:\n{program.output}"


def traces(folder):
    return {row["key"]: row.get("trace_sha256") for row in rows(folder)}


def has_ended(process):
    """Return whether a psutil.Process has ended, also if nothing has asked for its exit code."""
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def children(program):
    """Return the processes of a program's workers."""
    every = psutil.Process(program.process.pid).children(recursive=True)
    return matching(every, lambda process: "spawn_main" in " ".join(process.cmdline()))


@pytest.fixture
def cluster(start, tmp_path):
    """Start a scheduler; return its address and a function that starts a worker."""
    python = (sys.executable, "-m")
    scheduler = start(
        *python, "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0",
        "--no-dashboard", "--no-show",
    )  # fmt: skip
    address = scheduler.wait_for_match(r"Scheduler at:\s+(\S+)\s")

    def worker():
        return start(
            *python, "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny",
            "--no-dashboard", "--local-directory", tmp_path,
        )  # fmt: skip

    return address, worker


def interrupt_after(count, sweep, folder):
    """Interrupt a sweep that has so many rows, as Ctrl-C in a terminal does."""
    wait_for_rows(folder, count, sweep)
    os.killpg(sweep.process.pid, signal.SIGINT)
    assert sweep.wait_for_end(LIMIT_S) == 130, sweep.output
    assert "interrupted; the same command continues" in sweep.output


def test_interrupted_sweep_continues_with_the_drives_that_are_missing(study, start, tmp_path):
    study.write_text(STUDY.replace("seeds: 3", "seeds: 1"))
    folder = tmp_path / "sweep"

    def sweep():
        return start(sys.executable, SCRIPT, study, "--output", folder, "--workers", "1")

    first = sweep()
    interrupt_after(1, first, folder)
    assert "Traceback" not in first.output and (folder / "study.html").is_file()
    before = rows(folder)
    second = sweep()
    assert second.wait_for_end(LIMIT_S) == 1, second.output
    assert rows(folder)[: len(before)] == before, "a finished drive was changed"
    repeated = Counter(row["key"] for row in rows(folder) if row["status"] != "failed")
    assert list(repeated.values()) == 9 * [1]


@pytest.mark.nightly
def test_no_drive_is_lost_or_repeated_and_none_depends_on_its_worker(
    study, start, cluster, tmp_path
):
    address, worker = cluster
    folder = tmp_path / "cluster"
    first = worker()
    sweep = start(sys.executable, SCRIPT, study, "--output", folder, "--scheduler", address)
    wait_for_rows(folder, 2, sweep)
    first.process.kill()
    worker()
    assert sweep.wait_for_end(LIMIT_S) == 1, sweep.output
    assert len({row["worker"] for row in rows(folder)}) == 2
    expected = traces(folder)
    assert len(rows(folder)) == len(expected) == CELLS
    # Without noise, the seed changes nothing; with noise, it does.
    assert len(set(expected.values()) - {None}) == 3 * (1 + 3 + 3)

    failed = [row for row in rows(folder) if row["status"] == "failed"]
    assert len(failed) == FAILING
    assert {row["settings"]["simple_controller/stanley/k"] for row in failed} == {-1.0}
    log = (folder / failed[0]["log"]).read_text()
    assert log.strip().endswith("k must be a positive number, got -1.0")
    for part in ("got -1.0", f"{FAILING} drives failed", f"{CELLS} of {CELLS}", "results.csv"):
        assert part in sweep.output

    check_kills_on_this_machine(study, start, tmp_path / "killed", expected)

    (tmp_path / "bend.yaml").write_text(SCENARIO.replace("10", "12"))
    changed = start(sys.executable, SCRIPT, study, "--output", folder, "--scheduler", address)
    assert changed.wait_for_end(LIMIT_S) == 2
    assert changed.output.count("\n") == 1
    assert "a scenario or another file of the study changed" in changed.output


def check_kills_on_this_machine(study, start, folder, expected):
    """Sweep with two processes: kill a process, kill the sweep, let it end."""

    def sweep():
        return start(sys.executable, SCRIPT, study, "--output", folder, "--workers", "2")

    first = sweep()
    wait_for_rows(folder, 1, first)
    victim = children(first)[0]
    victim.kill()
    wait_for(lambda: has_ended(victim), first)
    wait_for_rows(folder, 4, first)
    workers = children(first)
    first.process.kill()
    first.process.wait()
    wait_for(lambda: all(map(has_ended, workers)), first)
    killed = rows(folder)

    second = sweep()
    assert second.wait_for_end(LIMIT_S) == 1, second.output
    done = rows(folder)
    assert done[: len(killed)] == killed, "a finished drive was changed"
    assert traces(folder) == expected
    repeated = Counter(row["key"] for row in done if row["status"] != "failed")
    assert set(repeated.values()) == {1}
    assert len(repeated) == CELLS - FAILING


@pytest.mark.nightly
def test_real_nodes_drive_as_the_process_does(study, start, tmp_path):
    text = STUDY.replace("[1.0, 2.5, -1.0, 4.0]", "[1.3]").replace("[0.0, 0.02, 0.1]", "[0.05]")
    found = []
    for stack in ("in_process", "ros"):
        study.write_text(text.replace("seeds: 3", f"seeds: [7]\nstack: {stack}"))
        folder = tmp_path / stack
        sweep = start(sys.executable, SCRIPT, study, "--output", folder, "--workers", "1")
        assert sweep.wait_for_end(LIMIT_S) == 0, sweep.output
        (row,) = rows(folder)
        found.append(row["metrics"])
    process, nodes = found
    assert nodes["missed_ticks"] == 0
    clock = {"wall_duration_s", "real_time_factor"}
    names = nodes.keys() - clock
    assert {name: process[name] for name in names} == {name: nodes[name] for name in names}


def greeting(port, ssl_context):
    """Return what a server of Dask sends to a client that it accepts; b"" to another one."""
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=0.3) as plain:
            client = ssl_context.wrap_socket(plain) if ssl_context else plain
            return client.recv(1)
    except OSError:  # also a timeout, and a certificate that is refused
        return b""


def test_client_without_the_certificate_of_the_cluster_cannot_connect():
    """Who connects runs code as the user of the cluster; each local user reaches the loopback."""
    with DaskEngine("") as engine:
        assert [outcome.result for outcome in engine.outcomes(abs, [("a", (-3,))])] == [3]
        assert all(address.startswith("tls://127.0.0.1:") for address in engine.workers)
        own = psutil.Process()
        processes = own, *own.children(recursive=True)
        open_ones = (one for process in processes for one in process.connections("inet"))
        listening = [one.laddr for one in open_ones if one.status == psutil.CONN_LISTEN]
        assert {address.ip for address in listening} == {"127.0.0.1"}
        other = distributed.Security.temporary().get_connection_args("scheduler")["ssl_context"]
        for port in {address.port for address in listening}:
            assert greeting(port, None) == b""
            assert greeting(port, other) == b""
