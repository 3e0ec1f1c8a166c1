"""Restart a node that a signal killed.

Roslaunch cannot both restart a crashed node and end the launch when the node exits by itself:
`respawn` restarts it after every exit, `required` ends the launch after every exit. A node that
calls `supervise()` first is restarted after a crash, and its own exit keeps the meaning that its
launch file gives it.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import sys
import tempfile
import time

STATE_FOLDER_VARIABLE = "NODE_STATE_FOLDER"
# A node that crashes this many times in a row, each time so soon after its start, is given up.
SOON_S = 10.0
MAX_SOON_CRASHES = 5
# A node that one of these signals ended was asked to end.
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_PR_SET_PDEATHSIG, _PR_SET_NAME = 1, 15


def supervise() -> None:
    """Return in a child process, which runs the node; the calling process supervises it.

    The calling process restarts the child when a signal kills it, passes requests to end on to it,
    and exits with its exit code, or with 128 plus the number of the signal that killed it last. In
    the child the environment variable NODE_STATE_FOLDER names a folder that all children share; it
    is removed at the end.
    """
    if STATE_FOLDER_VARIABLE in os.environ:
        return  # another process supervises this node already
    name = next(
        (word[len("__name:=") :] for word in sys.argv if word.startswith("__name:=")),
        os.path.basename(sys.argv[0]),
    )
    supervisor = _Supervisor(name)
    if supervisor.run_children():
        return
    sys.exit(supervisor.exit_status)


class _Supervisor:
    def __init__(self, name: str):
        self.name = name
        self.exit_status = 0
        self._child = 0
        self._end_signal = 0
        self._libc = ctypes.CDLL(None)
        for number in END_SIGNALS:
            signal.signal(number, self._pass_on)

    def _pass_on(self, number: int, _frame: object) -> None:
        self._end_signal = number
        if self._child:
            os.kill(self._child, number)

    def run_children(self) -> bool:
        """Run children in turn; return True in a child, False in the supervisor at the end."""
        self._libc.prctl(_PR_SET_NAME, b"supervisor")
        folder = tempfile.mkdtemp(prefix="supervisor-")
        soon_crashes = 0
        while True:
            started_at = time.monotonic()
            if self._fork():
                os.environ[STATE_FOLDER_VARIABLE] = folder
                return True
            code = self._wait()
            if code >= 0 or self._end_signal or -code in END_SIGNALS:
                break
            soon_crashes = soon_crashes + 1 if time.monotonic() - started_at < SOON_S else 0
            given_up = soon_crashes >= MAX_SOON_CRASHES
            action = (
                f"giving up after {soon_crashes} crashes in a row" if given_up else "restarting"
            )
            print(
                f"supervisor: {self.name} was killed by {signal.Signals(-code).name}; {action}",
                file=sys.stderr,
                flush=True,
            )
            if given_up:
                break
        shutil.rmtree(folder, ignore_errors=True)
        self.exit_status = code if code >= 0 else 128 - code
        return False

    def _fork(self) -> bool:
        """Return True in the child."""
        supervisor = os.getpid()
        # A request to end that reaches the child before its own handlers are set waits for them.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, END_SIGNALS)
        self._child = os.fork()
        if self._child:
            if self._end_signal:
                os.kill(self._child, self._end_signal)
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            return False
        for number in END_SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        # Roslaunch signals the process group of the supervisor, which passes the signal on once.
        os.setsid()
        # The kernel kills the child when its supervisor is killed, so that no orphan is left.
        self._libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        self._libc.prctl(_PR_SET_NAME, self.name.encode()[:15])
        if os.getppid() != supervisor:
            os._exit(1)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        return True

    def _wait(self) -> int:
        """Return the exit code of the child, negative for the signal that killed it."""
        _, status = os.waitpid(self._child, 0)
        self._child = 0
        return -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
