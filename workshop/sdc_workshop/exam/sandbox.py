"""Run programs of strangers in a sandbox of bubblewrap, within limits.

There are two sandboxes, one in the other. The outer one holds the whole check of one workspace: it
has a network of its own with nothing but loopback, and of the machine's files only the system and
the project, read only. In it runs the check itself, the ROS master and the simulator. Each of the
student's programs runs in an inner one, which has processes and temporary files of its own. Only
the network of the outer one is shared, so that a student's node reaches the master.
"""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Callable, Sequence

from sdc_workshop.exam.limits import GROUP, MAX_DISK, entering
from sdc_workshop.exam.process import Program
from sdc_workshop.exam.watch import BYSTANDER, Watch
from sdc_workshop.workspace import PACKAGE, PROJECT, SOLUTION, WORLD

# Limits of the kernel for each of the student's programs, with all that it starts.
MAX_TASKS = 400  # processes and threads
MAX_ADDRESS_SPACE = 6 << 30  # bytes, one process
_CHECK_ADDRESS_SPACE = 3 << 30  # bytes, one process of the check
MAX_FILE = 100 << 20  # bytes, one file
MAX_CPU_S = 300  # one process
_PROJECT_FOLDERS = ("catkin_ws", "world_ws", "workshop", "docker")
# Of the project, a student's program sees the world, the configuration that students get, and the
# programs that call its modules, but neither the solution nor the tables of the checks.
_PARTS = (WORLD, SOLUTION / PACKAGE / "config", Path(__file__).with_name("probes"))
_SYSTEM_FOLDERS = ("/usr", "/opt/ros")
_SYSTEM_LINKS = ("/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32")
# No passwords and no keys.
_ETC = (
    *("alternatives", "catkin", "debian_version", "fonts", "group", "host.conf", "hostname"),
    *("hosts", "ld.so.cache", "ld.so.conf", "ld.so.conf.d", "locale.alias", "localtime"),
    *("lsb-release", "matplotlibrc", "nsswitch.conf", "os-release", "passwd", "protocols"),
    *("python3", "ros", "services", "X11"),
)
_NEW_USER = 0x10000000  # CLONE_NEWUSER of the kernel
_USER_IDS = range(20_000, 60_000)
# ROS gives a new folder the owner of the folder above, which only root may do. No program of the
# student has a reason to kill the process that sleeps beside it.
_START = f'mkdir -p "$HOME/ros/log"; ({" ".join(BYSTANDER)} >/dev/null 2>&1 &); exec "$@"'
_TEST_TIMEOUT_S = 30.0


class SandboxError(RuntimeError):
    """There is no sandbox on this machine; the message is one line with the fix."""


def outer_command(
    command: Sequence,
    result: Path,
    temporary: Path,
    sized: Sequence = (),
    group: Path | None = None,
) -> list:
    """Return the command line that runs the check of one workspace.

    Args:
        command: the check
        result: folder of the results, which can be written
        temporary: folder of the copy of the workspace, which can be written
        sized: empty folders in it of limited size
        group: control group of the student's programs, which the check puts them into
    """
    return [
        *_system(),
        *_bound("--ro-bind-try", *(PROJECT / name for name in _PROJECT_FOLDERS)),
        "--unshare-net",
        *_bound("--bind", result, temporary),
        *(word for folder in sized for word in _sized(folder)),
        *_bound("--bind", *filter(None, [group])),
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
        inner = Sandbox(folder / "workspace", _USER_IDS[0]).command(["/bin/true"], {}, folder)
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
        self, command: Sequence, environment: dict, folder: Path, **options: Any
    ) -> Program:
        """Start a program; see `command`. It is ended when it meets a limit."""
        inner = self.command(command, environment, folder, **options)
        started = Program(inner, dict(os.environ))
        started.watch = Watch(started, self.scratch(folder), self.report)
        started.watch.start()
        return started

    @staticmethod
    def scratch(folder: Path) -> Path:
        """Return the only folder that a program can write; its files end with the program."""
        return folder / "tmp"

    def command(
        self,
        command: Sequence,
        environment: dict,
        folder: Path,
        building: bool = False,
        replaced: dict | None = None,
    ) -> list:
        """Return the command line of a program.

        Args:
            command: the program and its arguments
            environment: all its environment variables
            folder: folder of the check, which the program can read
            building: whether it may write the folders build and devel of the workspace
            replaced: files that it sees in the place of others, by their paths
        """
        scratch, forbidden = self.scratch(folder), self.workspace.parent / "forbidden.bpf"
        if not forbidden.exists():
            write_filter(forbidden)
        places = (replaced or {}).items()
        own = {**environment, "HOME": str(scratch), "TMPDIR": str(scratch), "USER": "student"}
        inner = [
            *_system(),
            *("--seccomp", "9"),
            *_bound("--ro-bind-try", *_PARTS, *map(os.path.realpath, WORLD.glob("src/*"))),
            # The check passes nothing to bwrap that the student has written: it runs outside.
            *_identity(self.user_id),
            *_bound("--ro-bind", folder),
            *_sized(scratch),
            *_sized(self.workspace),
            *_bound("--ro-bind", self.workspace / "src"),
            *_bound("--bind" if building else "--ro-bind", *_built(self.workspace)),
            *(word for path, by in places for word in ("--ro-bind", str(by), str(path))),
            *("--remount-ro", "/", "--remount-ro", "/dev"),
            *("--chdir", str(self.workspace if building else folder), "--"),
            *_as_user(self.user_id),
            *("prlimit", f"--nproc={MAX_TASKS + _own_tasks()}", f"--as={MAX_ADDRESS_SPACE}"),
            *(f"--fsize={MAX_FILE}", f"--cpu={MAX_CPU_S}", "--core=0", "--"),
            *("/usr/bin/env", "-i", *(f"{name}={value}" for name, value in own.items())),
            *("sh", "-c", _START, "sh", *map(str, command)),
        ]
        opened = ["sh", "-c", 'exec "$@" 9<"$0"', str(forbidden), *inner]
        return entering(os.environ.get(GROUP), opened)


def write_filter(path: Path) -> None:
    """Write the filter of system calls: no user namespace, no memory that belongs to no process."""
    import seccomp

    rules = seccomp.SyscallFilter(seccomp.ALLOW)
    no, flags = seccomp.ERRNO(errno.EPERM), (seccomp.MASKED_EQ, _NEW_USER, _NEW_USER)
    for name in ("unshare", "clone"):
        rules.add_rule(no, name, seccomp.Arg(0, *flags))
    # Its flags are in memory, which a filter cannot read; the C library then uses clone.
    rules.add_rule(seccomp.ERRNO(errno.ENOSYS), "clone3")
    for name in ("setns", "memfd_create", "memfd_secret", "shmget", "msgget"):
        rules.add_rule(no, name)
    with path.open("wb") as file:
        rules.export_bpf(file)


def user_id(number: int) -> int:
    """Return a user id for the programs of the student with this number."""
    return _USER_IDS[(os.getpid() * 64 + number) % len(_USER_IDS)]


def _built(workspace: Path) -> list:
    return [workspace / name for name in ("build", "devel") if (workspace / name).is_dir()]


def _system() -> list:
    words = ["bwrap", "--die-with-parent", "--unshare-pid", "--unshare-ipc", "--unshare-uts"]
    words += ["--proc", "/proc", "--dev", "/dev", *_sized("/dev/shm"), *_sized("/tmp")]
    for name in _SYSTEM_LINKS:
        if os.path.islink(name):
            words += ["--symlink", os.readlink(name), name]
        elif os.path.isdir(name):
            words += ["--ro-bind", name, name]
    words += _bound("--ro-bind-try", *_SYSTEM_FOLDERS)
    return words + _bound("--ro-bind-try", *(Path("/etc", name) for name in _ETC))


def _bound(option: str, *paths: object) -> list:
    return [word for path in paths for word in (*_above(path), option, str(path), str(path))]


def _above(path: object) -> list:
    """Return the options that create the folders above a path: bwrap lets only root enter them."""
    folders = [str(folder) for folder in reversed(Path(str(path)).parents) if len(folder.parts) > 1]
    return [word for folder in folders for word in ("--perms", "0755", "--dir", folder)]


def _sized(folder: object) -> list:
    return [
        *_above(folder),
        *("--perms", "1777", "--size", str(MAX_DISK), "--tmpfs", str(folder)),
    ]


def _identity(user: int) -> list:
    """Return the options that take the rights of root from a program."""
    if os.geteuid() != 0:
        return ["--cap-drop", "ALL"]
    return ["--cap-drop", "ALL", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]


def _as_user(user: int) -> list:
    """Return the command that makes a program another user's: the kernel limits root in nothing."""
    if os.geteuid() != 0:
        return []
    return ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups", "--inh-caps=-all"]


def _own_tasks() -> int:
    """Return the number of tasks that an old kernel counts for this user, too."""
    if os.geteuid() == 0:
        return 0
    count = 0
    for name in os.listdir("/proc"):
        try:
            if name.isdigit() and os.stat(f"/proc/{name}").st_uid == os.geteuid():
                count += len(os.listdir(f"/proc/{name}/task"))
        except OSError:
            continue
    return count
