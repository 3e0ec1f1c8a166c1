"""Parts of a sandbox of bubblewrap for programs of strangers: files, users, system calls."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path
from typing import Any

_SYSTEM_FOLDERS = ("/usr", "/opt/ros")
_SYSTEM_LINKS = ("/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32")
# No passwords and no keys.
_ETC = (
    *("alternatives", "catkin", "debian_version", "fonts", "group", "host.conf", "hostname"),
    *("hosts", "ld.so.cache", "ld.so.conf", "ld.so.conf.d", "locale.alias", "localtime"),
    *("lsb-release", "matplotlibrc", "nsswitch.conf", "os-release", "passwd", "protocols"),
    *("python3", "ros", "services", "X11"),
)
MAX_DISK = 400 << 20  # bytes, all files of one folder that can be written, which is in memory
_NEW_USER = 0x10000000  # CLONE_NEWUSER of the kernel
USER_IDS = range(20_000, 60_000)


class SandboxError(RuntimeError):
    """There is no sandbox on this machine; the message is one line with the fix."""


def seccomp_module() -> Any:
    """Return the module for filters of system calls, None without it or the library libseccomp."""
    with contextlib.suppress(ImportError):
        import seccomp

        return seccomp
    with contextlib.suppress(ImportError, RuntimeError):
        import pyseccomp  # PyPI's, with the same functions

        return pyseccomp
    return None


def write_filter(path: Path) -> None:
    """Write the filter of system calls.

    No user namespace, no memory that belongs to no process, no other processors.
    """
    seccomp = seccomp_module()
    rules = seccomp.SyscallFilter(seccomp.ALLOW)
    no, flags = seccomp.ERRNO(errno.EPERM), (seccomp.MASKED_EQ, _NEW_USER, _NEW_USER)
    for name in ("unshare", "clone"):
        rules.add_rule(no, name, seccomp.Arg(0, *flags))
    # Its flags are in memory, which a filter cannot read; the C library then uses clone.
    rules.add_rule(seccomp.ERRNO(errno.ENOSYS), "clone3")
    for name in ("setns", "memfd_create", "memfd_secret", "shmget", "msgget", "sched_setaffinity"):
        rules.add_rule(no, name)
    with path.open("wb") as file:
        rules.export_bpf(file)


def user_id(number: int) -> int:
    """Return a user id for programs that have a number."""
    return USER_IDS[(os.getpid() * 64 + number) % len(USER_IDS)]


def system() -> list:
    """Return the command and the options that show the system's programs and libraries."""
    words = ["bwrap", "--die-with-parent", "--unshare-pid", "--unshare-ipc", "--unshare-uts"]
    words += ["--proc", "/proc", "--dev", "/dev", *in_memory("/dev/shm"), *in_memory("/tmp")]
    for name in _SYSTEM_LINKS:
        if os.path.islink(name):
            words += ["--symlink", os.readlink(name), name]
        elif os.path.isdir(name):
            words += ["--ro-bind", name, name]
    words += bound("--ro-bind-try", *_SYSTEM_FOLDERS)
    return words + bound("--ro-bind-try", *(Path("/etc", name) for name in _ETC))


def bound(option: str, *paths: object) -> list:
    """Return the options that show files at their own paths; option is one of bwrap."""
    return [word for path in paths for word in (*_above(path), option, str(path), str(path))]


def _above(path: object) -> list:
    """Return the options that create the folders above a path: bwrap lets only root enter them."""
    folders = [str(folder) for folder in reversed(Path(str(path)).parents) if len(folder.parts) > 1]
    return [word for folder in folders for word in ("--perms", "0755", "--dir", folder)]


def in_memory(folder: object) -> list:
    """Return the options that make a folder of limited size in memory."""
    return _above(folder) + ["--perms", "1777", "--size", str(MAX_DISK), "--tmpfs", str(folder)]


def identity() -> list:
    """Return the options that take the rights of root from a program."""
    if os.geteuid() != 0:
        return ["--cap-drop", "ALL"]
    return ["--cap-drop", "ALL", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]


def as_user(user: int) -> list:
    """Return the command that makes a program another user's: the kernel limits root in nothing."""
    if os.geteuid() != 0:
        return []
    return ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups", "--inh-caps=-all"]


def own_tasks() -> int:
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
