"""The process of a driver, in its sandbox: python3 -m sdc_experiments.championship.host SOCKET.

The server imports the library. For each drive it forks a process that gives up what a driver does
not need, loads the file and answers observations. No drive shares anything with another one.
"""

from __future__ import annotations

import ctypes
import gc
import linecache
import os
import pickle
import random
import signal
import socket
import struct
import sys
import time
import traceback
from types import ModuleType
from typing import Any

import numpy as np

from sdc_common.driving import Command, Observation
from sdc_experiments.championship.league import TABLE
from sdc_experiments.championship.mission import DriverMission, car_of
from sdc_experiments.sandbox import seccomp_module
from sdc_map.network_file import load_network

FILE = "driver.py"
# Of an answer: whether there is a command, throttle, steer, brake, hand brake, reverse, and the
# speed that the car plans [m/s], NaN if it is unknown. A reason follows.
ANSWER = struct.Struct("<?fff??f")
HELLO, READY = b"hello", b"ready"
MAX_REASON = 40  # characters
MAX_MESSAGE = 1 << 18  # bytes
REFUSED = "refused:"
_WARM_UPS = 5
_PR_SET_DUMPABLE = 4
# Limits of the kernel for the process, named as in the module resource.
_LIMITS = {
    "RLIMIT_FSIZE": 1 << 16,  # bytes, of the log, the only file that can be written
    "RLIMIT_AS": 4 << 30,  # bytes
    "RLIMIT_CPU": 600,  # s
    "RLIMIT_NOFILE": 64,
    "RLIMIT_CORE": 0,
}
_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time", "clock_gettime")
# Commands of fcntl by which a process gets signals from a file: F_SETOWN, F_SETSIG, F_SETOWN_EX.
_SET_OWNER = (8, 10, 15)
# Audit events of Python that are refused and named before the kernel ends the process.
_EVENTS = ("os.fork", "os.exec", "os.posix_spawn", "os.system", "os.kill", "subprocess", "socket")
_FILE_EVENTS = ("open", "os.listdir", "os.scandir")
REFUSALS = (*_EVENTS, "to open")
# Status of a driver that is refused something when its log has no more room to name it.
FULL = 3
_READABLE = ("/usr/", "/lib", "/opt/ros/", "/dev/null", "/dev/urandom")


def main() -> None:
    """Serve drives: receive the source, then for each drive a socket and a log."""
    control = socket.socket(fileno=int(sys.argv[1]))
    sys.path.remove(os.getcwd())
    source = control.recv(MAX_MESSAGE).decode(errors="replace")
    # The memory of this process is not readable or writable for those that it forks.
    ctypes.CDLL(None).prctl(_PR_SET_DUMPABLE, 0, 0, 0, 0)
    rules = _rules()
    control.send(READY)
    while True:
        message, files, _, _ = socket.recv_fds(control, 16, 2)
        if not message:
            return
        child = os.fork()
        if not child:
            control.close()
            _run(socket.socket(fileno=files[0]), files[1], source, rules)
        for file in files:
            os.close(file)
        _, status = os.waitpid(child, 0)
        control.send(struct.pack("<i", os.waitstatus_to_exitcode(status)))


def _rules() -> Any:
    """Return the filter of system calls; None without the module, where there is no sandbox."""
    seccomp = seccomp_module()
    if seccomp is None:
        return None
    rules = seccomp.SyscallFilter(seccomp.ALLOW)
    for name in TABLE["forbidden_calls"]:
        rules.add_rule(seccomp.KILL_PROCESS, name)
    for number in _SET_OWNER:
        rules.add_rule(seccomp.KILL_PROCESS, "fcntl", seccomp.Arg(1, seccomp.EQ, number))
    return rules


def _run(link: socket.socket, log: int, source: str, rules: Any) -> None:
    """Be the process of a drive; never return."""
    for number in (1, 2):
        os.dup2(log, number)
    os.close(log)
    import resource  # Other systems lack it.

    for limit, value in _LIMITS.items():
        resource.setrlimit(getattr(resource, limit), (value, value))
    status = 1
    try:
        link.send(HELLO)
        mission: DriverMission = pickle.loads(link.recv(MAX_MESSAGE))
        if mission.map:
            load_network(mission.map)  # Its file cannot be read after the next lines.
        random.seed(0)
        np.random.seed(0)  # noqa: NPY002  a driver may use it
        if rules is not None:
            rules.load()
        sys.addaudithook(_refuse)
        answer(link, mission, source)
        status = 0
    except BaseException as error:  # noqa: BLE001  it is the driver's, of any type
        frames = traceback.extract_tb(error.__traceback__)
        place = [f"line {frame.lineno}: " for frame in frames if frame.filename == FILE][-1:]
        print(*place, f"{type(error).__name__}: {error}", sep="", file=sys.stderr, flush=True)
    os._exit(status)


def answer(link: socket.socket, mission: DriverMission, source: str) -> None:
    """Load the driver's file and answer observations until the socket is closed."""
    module = ModuleType("driver")
    linecache.cache[FILE] = len(source), None, source.splitlines(True), FILE
    exec(compile(source, FILE, "exec"), vars(module))
    now_s = [mission.first.stamp_s]
    for name in _CLOCKS:
        setattr(time, name, lambda *_: now_s[0])
    if not hasattr(module, "Driver"):
        raise TypeError("the file has no class Driver")
    # First calls are slow, so a car that does not drive makes them.
    idle = car_of(module.Driver(mission), mission)
    for _ in range(_WARM_UPS):
        packed(idle.step(mission.first), idle)
    car = car_of(module.Driver(mission), mission)
    gc.collect()
    gc.freeze()
    link.send(READY)
    while True:
        message = link.recv(MAX_MESSAGE)
        if not message:
            return
        observation: Observation = pickle.loads(message)
        now_s[0] = observation.stamp_s
        link.send(packed(car.step(observation), car))


def packed(command: Command | None, car: Any) -> bytes:
    """Return an answer."""
    if not isinstance(command, (Command, type(None))):
        raise TypeError(f"step must return a Command or None, got {command!r}")
    path, reason = getattr(car, "path", None), str(getattr(car, "reason", ""))[:MAX_REASON]
    planned = path.points[0][2] if path is not None else float("nan")
    answer = command or Command()
    pedals = answer.throttle, answer.steer, answer.brake, answer.hand_brake, answer.reverse
    return ANSWER.pack(command is not None, *pedals, planned) + reason.encode()


def _refuse(event: str, arguments: tuple) -> None:
    """Refuse what a driver has no reason to do, and name it in the log."""
    text = ""
    if event.startswith(_EVENTS):
        text = event
    elif event in _FILE_EVENTS and isinstance(arguments[0], (str, bytes)):
        path = os.path.abspath(os.fsdecode(arguments[0]))
        packages = os.environ.get("ROS_PACKAGE_PATH", "").split(":")
        known = (*_READABLE, *filter(None, [*sys.path, *packages]))
        text = "" if path.startswith(known) else f"to open {path}"
    if text:
        try:
            os.write(2, f"{REFUSED} {text}\n".encode())
        except OSError:
            os._exit(FULL)
        raise PermissionError(f"a driver is not allowed {text}")


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    main()
