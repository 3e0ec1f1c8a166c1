"""Starts a node again when a signal has killed it. As the launch-prefix of its <node>: python3 -m sdc_common.ros.supervisor

roslaunch starts a node again however it ended (respawn), or ends everything with it (required), but never both. With this in
front, required="true" keeps its meaning for a node that ends by itself, and one that is killed comes back.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time

# A node that dies this soon, so many times in a row, will not do better the next time.
SOON_S = 10.0
MOST_SOON = 5
# Killed by one of these, a node was asked to end.
ASKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Supervisor:
    """Runs one command until it ends by itself, is asked to end, or keeps dying."""

    def __init__(self, command):
        self.command = command
        self.name = next(
            (word[len("__name:=") :] for word in command if word.startswith("__name:=")),
            os.path.basename(command[0]),
        )
        self.child = None
        self.asked = None
        for number in ASKED:
            signal.signal(number, self.pass_on)

    def pass_on(self, number, _frame):
        self.asked = number
        if self.child is not None:
            self.child.send_signal(number)

    def run_once(self, folder):
        """Returns the exit code, negative for the signal that killed the node."""
        # Should this process be killed, the system kills the node: nothing is left behind.
        self.child = subprocess.Popen(
            ["setpriv", "--pdeathsig", "KILL", *self.command],
            start_new_session=True,
            env={**os.environ, "NODE_STATE_FOLDER": folder},
        )
        if self.asked:
            self.child.send_signal(self.asked)
        return self.child.wait()

    def run(self):
        """Returns the exit status: that of the node, or 128 and the signal that killed it last."""
        soon = 0
        with tempfile.TemporaryDirectory(prefix="keep_running-") as folder:
            while True:
                started = time.monotonic()
                code = self.run_once(folder)
                if code >= 0 or self.asked or -code in ASKED:
                    return code if code >= 0 else 128 - code
                soon = soon + 1 if time.monotonic() - started < SOON_S else 0
                again = soon < MOST_SOON
                print(
                    f"keep_running: {self.name} was killed by {signal.Signals(-code).name}; "
                    + ("starting it again" if again else f"{soon} times at once, giving up"),
                    file=sys.stderr,
                    flush=True,
                )
                if not again:
                    return 128 - code


if __name__ == "__main__":
    sys.exit(Supervisor(sys.argv[1:]).run() if len(sys.argv) > 1 else __doc__)
