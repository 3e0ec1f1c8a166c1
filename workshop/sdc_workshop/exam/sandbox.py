"""Run programs of strangers in a sandbox of bubblewrap, within limits.

There are two sandboxes, one in the other. The outer one holds the whole check of one workspace: it
has a network of its own with nothing but loopback, and of the machine's files only the system and
the project, read only. In it runs the check itself, the ROS master and the simulator. Each of the
student's programs runs in an inner one, which has processes and temporary files of its own. Only
the network of the outer one is shared, so that a student's node reaches the master.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Callable, Sequence

from sdc_experiments.sandbox import (
    MAX_DISK,
    USER_IDS,
    SandboxError,
    as_user,
    bound,
    identity,
    in_memory,
    own_tasks,
    system,
    write_filter,
)
from sdc_workshop.exam.limits import GROUP, entering
from sdc_workshop.exam.process import Program
from sdc_workshop.exam.watch import BYSTANDER, Watch
from sdc_workshop.workspace import PACKAGE, PROJECT, SOLUTION, WORLD

# Limits of the kernel for each of the student's programs, with all that it starts.
MAX_TASKS = 400  # processes and threads
MAX_ADDRESS_SPACE = 6 << 30  # bytes, one process
_CHECK_ADDRESS_SPACE = 3 << 30  # bytes, one process of the check
MAX_FILE = 100 << 20  # bytes, one file
MAX_OPEN = 1024  # files and sockets, one process
MAX_CPU_S = 300  # one process
_PROJECT_FOLDERS = ("catkin_ws", "world_ws", "workshop", "docker", ".venv")
# Of the project, a student's program sees the world, the configuration that students get, and the
# programs that call its modules, but neither the solution nor the tables of the checks.
_PARTS = (
    *(WORLD, SOLUTION / PACKAGE / "config", Path(__file__).with_name("probes")),
    PROJECT / ".venv",  # the solver of the lab on MPC
)
# ROS gives a new folder the owner of the folder above, which only root may do. No program of the
# student has a reason to kill the process that sleeps beside it.
_START = f'mkdir -p "$HOME/ros/log"; ({" ".join(BYSTANDER)} >/dev/null 2>&1 &); exec "$@"'
_TEST_TIMEOUT_S = 30.0


def outer_command(
    command: Sequence,
    result: Path,
    temporary: Path,
    sized: Sequence = (),
    group: str = "",
) -> list:
    """Return the command line that runs the check of one workspace.

    It can write into the folder of the results, into that of the copy of the workspace, and into
    empty folders in it of limited size. It puts the student's programs into the control group.
    """
    return [
        *system(),
        *bound("--ro-bind-try", *(PROJECT / name for name in _PROJECT_FOLDERS)),
        "--unshare-net",
        *bound("--bind", result, temporary),
        *(word for folder in sized for word in in_memory(folder)),
        *bound("--bind", *filter(None, group.split(":"))),
        *("--remount-ro", "/", "--"),
        # What the programs send to the check must not fill the machine's memory or disk.
        *("prlimit", f"--as={_CHECK_ADDRESS_SPACE}:{MAX_ADDRESS_SPACE}"),
        *(f"--fsize={MAX_DISK}", "--"),
        *map(str, command),
    ]


def require() -> None:
    """Raise SandboxError unless both sandboxes work on this machine."""
    if shutil.which("bwrap") is None:
        raise SandboxError(_without("bwrap is not installed (apt-get install bubblewrap)"))
    if find_spec("seccomp") is None:
        raise SandboxError(_without("seccomp is not installed (apt-get install python3-seccomp)"))
    with tempfile.TemporaryDirectory(prefix="workshop_sandbox_") as name:
        folder = Path(name)
        for path in ("tmp", "workspace/src"):
            (folder / path).mkdir(parents=True)
        inner = Sandbox(folder / "workspace", USER_IDS[0]).command(["/bin/true"], {}, folder)
        done = subprocess.run(
            outer_command(inner, folder, folder),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=_TEST_TIMEOUT_S,
            check=False,
        )
    if done.returncode != 0:
        seen = (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]
        raise SandboxError(_without(f"the kernel forbids it ({seen})"))


def _without(reason: str) -> str:
    return (
        f"no sandbox for students' programs: {reason}; --no-sandbox grades without one: then "
        "the programs can do all that you can do"
    )


@dataclass(frozen=True)
class Sandbox:
    """Starts a student's programs, in the outer sandbox."""

    workspace: Path  # the copy of the student's workspace
    user_id: int  # the user of the programs where the check runs as root
    report: Callable[[str, str], None] = lambda text, path: None  # see Watch

    def program(
        self, command: Sequence, environment: dict, folder: Path, stdin: Any = None, **options: Any
    ) -> Program:
        """Start a program; see `command` and Program. It is ended when it meets a limit."""
        inner = self.command(command, environment, folder, **options)
        started = Program(inner, dict(os.environ), stdin=stdin)
        started.watch = Watch(started, folder / "tmp", self.report)
        started.watch.start()
        return started

    def command(
        self,
        command: Sequence,
        environment: dict,
        folder: Path,
        building: bool = False,
        replaced: dict | None = None,
    ) -> list:
        """Return the command line of a program, which can read the folder of the check.

        With `building`, it may write the folders build and devel of the workspace. `replaced` are
        files that it sees in the place of others, by their paths.
        """
        # The only folder that a program can write; its files end with the program.
        scratch = folder / "tmp"
        forbidden = self.workspace.parent / "forbidden.bpf"
        if not forbidden.exists():
            write_filter(forbidden)
        places = (replaced or {}).items()
        built = [self.workspace / name for name in ("build", "devel")]
        own = {**environment, "HOME": str(scratch), "TMPDIR": str(scratch), "USER": "student"}
        inner = [
            *system(),
            *("--seccomp", "9"),
            *bound("--ro-bind-try", *_PARTS, *map(os.path.realpath, WORLD.glob("src/*"))),
            # The check passes nothing to bwrap that the student has written: it runs outside.
            *identity(),
            *bound("--ro-bind", folder),
            *in_memory(scratch),
            *in_memory(self.workspace),
            *bound("--ro-bind", self.workspace / "src"),
            *bound("--bind-try" if building else "--ro-bind-try", *built),
            *(word for path, by in places for word in ("--ro-bind", str(by), str(path))),
            *("--remount-ro", "/", "--remount-ro", "/dev"),
            *("--chdir", str(self.workspace if building else folder), "--"),
            *as_user(self.user_id),
            *("prlimit", f"--nproc={MAX_TASKS + own_tasks()}", f"--as={MAX_ADDRESS_SPACE}"),
            *(f"--fsize={MAX_FILE}", f"--cpu={MAX_CPU_S}", "--core=0"),
            *(f"--nofile={MAX_OPEN}", "--"),
            *("/usr/bin/env", "-i", *(f"{name}={value}" for name, value in own.items())),
            *("sh", "-c", _START, "sh", *map(str, command)),
        ]
        opened = ["sh", "-c", 'exec "$@" 9<"$0"', str(forbidden), *inner]
        return entering(os.environ.get(GROUP), opened)
