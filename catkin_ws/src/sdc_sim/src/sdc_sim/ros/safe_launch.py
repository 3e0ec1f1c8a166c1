"""Run roslaunch without evaluating expressions in parameter files, on a master of this user.

Usage: python3 -m sdc_sim.ros.safe_launch PACKAGE FILE.launch [ARG:=VALUE ...]

ROS evaluates `!radians pi/2` and `rad(pi/2)` in YAML files as Python, so that a parameter file can
run any code. Here such a line is an error.

roslaunch joins any master that responds. Where `drive_master` has found none, another program may
start one on the same port before roslaunch does. Then this launch ends with an error.

With the environment variable SDC_LAUNCH_LOG, the lines that roslaunch prints in each drive that
goes well are written to that file, not to the terminal. Nodes inherit the terminal itself.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import sys
from typing import TextIO

import roslaunch
import rosparam  # adds the expressions to YAML's safe loader
import yaml

from sdc_common.ros.drive_master import NEW_MASTER_VARIABLE

# Names the file for what roslaunch prints in each drive.
LOG_VARIABLE = "SDC_LAUNCH_LOG"
# The texts that roslaunch prints, each in one call, in a drive that goes well.
_USUAL = re.compile(
    r"\x1b\]2;|\.\.\. logging to |Checking log directory |Done checking log file |"
    r"started roslaunch server |\nSUMMARY\n|auto-starting new master$|ROS_MASTER_URI=|"
    r"setting /run_id to |process\[[\w/-]+\]: started with pid |started core service |"
    r"=+REQUIRED process .* has died!\nprocess has finished cleanly\n|\[[\w/-]+\] killing on exit$|"
    r"(\.\.\. )?shutting down processing monitor|done$"
)
_COLOUR = re.compile(r"\x1b\[\d+m")


class QuietStream:
    """Writes the usual texts of roslaunch to a log, and all others to a stream."""

    def __init__(self, stream: TextIO, log: TextIO):
        self._stream, self._log = stream, log
        self._target = stream

    def write(self, text: str) -> int:
        """Write a text; the line end that `print` writes after it goes the same way."""
        if text != "\n":
            self._target = self._log if _USUAL.match(_COLOUR.sub("", text)) else self._stream
        with contextlib.suppress(OSError):  # a full disk must not end the drive
            self._target.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush both."""
        self._stream.flush()
        self._log.flush()


def refuse_expression(_loader: yaml.SafeLoader, node: yaml.ScalarNode) -> None:
    """Raise ConstructorError with the line of the expression."""
    what = f"the expression {node.value!r} is not evaluated; write the number"
    raise yaml.constructor.ConstructorError(None, None, what, node.start_mark)


def one_line(argument: str) -> str:
    """Return an argument without spaces and newlines at its ends.

    roslaunch ignores an argument NAME:=VALUE of several lines without a message.

    Raises:
        SystemExit: the value has several lines
    """
    argument = argument.strip()
    if "\n" in argument:
        name = argument.split(":=")[0]
        sys.exit(f"{name}: the value has several lines; write it in one line, as {{a: 1, b: 2}}")
    return argument


def main() -> None:
    """Disable expressions and run roslaunch."""
    if path := os.environ.pop(LOG_VARIABLE, ""):
        log = open(path, "w", buffering=1, encoding="utf-8")  # noqa: SIM115  open until the end
        sys.stdout, sys.stderr = QuietStream(sys.stdout, log), QuietStream(sys.stderr, log)
    # A caller that blocks Ctrl-C for itself, such as a worker of a sweep, interrupts the launch.
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    assert rosparam  # imported first, so that its constructors are replaced
    for tag in ("!radians", "!degrees"):
        yaml.SafeLoader.add_constructor(tag, refuse_expression)
    if os.environ.pop(NEW_MASTER_VARIABLE, ""):
        # roslaunch refuses a master with another id than its own, which it asks the master for.
        roslaunch.rlutil.get_or_generate_uuid = lambda *_: roslaunch.core.generate_run_id()
    roslaunch.main(["roslaunch", *map(one_line, sys.argv[1:])])


if __name__ == "__main__":
    main()
