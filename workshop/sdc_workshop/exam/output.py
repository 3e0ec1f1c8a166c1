"""Reads what a student's program said when it broke: the line in the student's file, and what the error means."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_TRACEBACK = re.compile(
    r"Traceback \(most recent call last\):\n(?P<frames>(?:[ \t].*\n|\n)*?)(?P<error>[A-Za-z_][\w.]*(?::.*|$))",
    re.MULTILINE,
)
_FRAME = re.compile(r'^\s*File "(?P<file>[^"]+)", line (?P<line>\d+)', re.MULTILINE)
_SYNTAX = re.compile(
    r'^\s*File "(?P<file>[^"]+)", line (?P<line>\d+)\n(?P<shown>(?:[ \t].*\n)*)(?P<error>(?:Syntax|Indentation|Tab)Error: .*)',
    re.MULTILINE,
)
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LOGGED = re.compile(r"^\[(?:FATAL|ERROR|WARN)\] \[[^\]]*\]:? ?(?P<text>.*)", re.MULTILINE)


@dataclass(frozen=True)
class Crash:
    """An error that a program did not catch. `line` counts from 1 in the file that was run; None when none of its lines took part."""

    error: str
    line: int | None
    library_line: str | None = None

    @property
    def kind(self) -> str:
        return self.error.partition(":")[0].rpartition(".")[2]

    @property
    def text(self) -> str:
        return self.error.partition(":")[2].strip()


def plain(output: str) -> str:
    """Without colours."""
    return _COLOUR.sub("", output)


def crash(output: str, path: Path) -> Crash | None:
    """The first error of a program that was run from `path`; None when there is none."""
    output = plain(output) + "\n"
    syntax = _SYNTAX.search(output)
    if syntax:
        return Crash(syntax["error"], int(syntax["line"]) if syntax["file"] == str(path) else None)
    found = _TRACEBACK.search(output)
    if not found:
        return None
    frames = [(frame["file"], int(frame["line"])) for frame in _FRAME.finditer(found["frames"])]
    own = [line for file, line in frames if file == str(path)]
    last = frames[-1] if frames else None
    beyond = f"{Path(last[0]).name}, line {last[1]}" if last and last[0] != str(path) else None
    return Crash(found["error"].strip(), own[-1] if own else None, beyond)


def last_words(output: str) -> str:
    """The last thing that it said, on one line."""
    logged = _LOGGED.findall(plain(output))
    lines = logged or [line.strip() for line in plain(output).splitlines() if line.strip()]
    return lines[-1] if lines else "nothing at all"


def warnings(output: str) -> list:
    """All warnings and errors that it logged."""
    return _LOGGED.findall(plain(output))


def meaning(crash: Crash) -> str:
    """What an error means, and how to mend it, for somebody who has seen few of them."""
    for kind, pattern, text in _MEANINGS:
        match = re.search(pattern, crash.text)
        if crash.kind == kind and match:
            return text.format(*match.groups())
    return "Read the error's last line first; the line of your file that is named above is where it happened."


_MEANINGS = (
    (
        "NameError",
        r"name 'rospy' is not defined",
        "`rospy` is not known in this file: write `import rospy` at its top.",
    ),
    (
        "NameError",
        r"name '(\w+)' is not defined",
        "Python does not know `{0}` here: is it misspelt, or was it to be imported or given a value before? A word that is meant as "
        'text stands in quotes: "{0}".',
    ),
    (
        "UnboundLocalError",
        r"variable '(\w+)'",
        "`{0}` is used before it has got a value: assign it first, under this very name.",
    ),
    (
        "ModuleNotFoundError",
        r"No module named 'sdc_package\.msg'",
        "The messages are not built: run `catkin_make` in the workspace, then `source devel/setup.bash`.",
    ),
    (
        "ModuleNotFoundError",
        r"No module named 'sdc_package\.(\w+)'",
        "The package has no module `{0}`: messages are imported from `sdc_package.msg`.",
    ),
    (
        "ModuleNotFoundError",
        r"No module named '([\w.]+)'",
        "There is no module `{0}`: is its name misspelt?",
    ),
    (
        "ImportError",
        r"cannot import name '(\w+)' from 'sdc_package\.msg'",
        "There is no message `{0}` in what was built: is the name misspelt, or is its file missing in CMakeLists.txt, or was "
        "`catkin_make` not run since?",
    ),
    (
        "ImportError",
        r"cannot import name '(\w+)' from '([\w.]+)'",
        "`{1}` has no `{0}`: is the name misspelt, or does it come from somewhere else?",
    ),
    (
        "AttributeError",
        r"'Subscriber' object has no attribute 'publish'",
        "A subscriber cannot publish: rospy.Subscriber listens, rospy.Publisher speaks.",
    ),
    (
        "AttributeError",
        r"'(\w+)' object has no attribute '(\w+)'",
        "A {0} has no `{1}`: is the name misspelt, or is this another kind of thing than you think?",
    ),
    (
        "AttributeError",
        r"has no attribute '(\w+)'",
        "There is no `{0}` in it: is the name misspelt?",
    ),
    (
        "TypeError",
        r"missing \d+ required positional arguments?: '(\w+)'",
        "A function is called without `{0}`. To hand a function over, as a callback, write its name without parentheses; to call it, "
        "give it all it asks for.",
    ),
    (
        "TypeError",
        r"takes \d+ positional arguments? but \d+ were given",
        "A function gets more values than it takes: count them.",
    ),
    (
        "TypeError",
        r"'(\w+)' object is not callable",
        "This is a {0} and no function: parentheses after it call it, and that it cannot be.",
    ),
    (
        "TypeError",
        r"Invalid number of arguments",
        "The message is given another number of fields than it has: see `rosmsg show`.",
    ),
    (
        "TypeError",
        r"got an unexpected keyword argument '(\w+)'",
        "There is no parameter `{0}`: is its name misspelt?",
    ),
    (
        "ValueError",
        r"is not a message data class",
        "The second argument is the class of the messages: one that was imported from a package's msg, such as `from sensor_msgs.msg "
        "import Image`.",
    ),
    (
        "ROSException",
        r"time is not initialized",
        "ROS is used before the node is registered: `rospy.init_node` comes first.",
    ),
    (
        "ROSInitException",
        r"",
        "ROS is used before the node is registered: `rospy.init_node` comes first.",
    ),
    (
        "IndentationError",
        r"",
        "The line begins at the wrong column: inside a region all lines begin below one another, with spaces as in the lines around it.",
    ),
    ("TabError", r"", "Tabs and spaces are mixed: use spaces only."),
    ("SyntaxError", r"was never closed", "A bracket is opened and never closed."),
    (
        "SyntaxError",
        r"unterminated string",
        "A text is not closed: it begins and ends with the same quotes.",
    ),
    (
        "SyntaxError",
        r"",
        "Python cannot read this line: look for a missing bracket, comma, colon or quote, in it and in the line before.",
    ),
)
