"""Read a program's output: the error that ended it, its line in the student's file, its meaning."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_TRACEBACK = re.compile(
    r"Traceback \(most recent call last\):\n(?P<frames>(?:[ \t].*\n|\n)*?)"
    r"(?P<error>[A-Za-z_][\w.]*(?::.*|$))",
    re.MULTILINE,
)
_FRAME = re.compile(r'^\s*File "(?P<file>[^"]+)", line (?P<line>\d+)', re.MULTILINE)
_SYNTAX = re.compile(
    r'^\s*File "(?P<file>[^"]+)", line (?P<line>\d+)\n(?P<shown>(?:[ \t].*\n)*)'
    r"(?P<error>(?:Syntax|Indentation|Tab)Error: .*)",
    re.MULTILINE,
)
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LOGGED = re.compile(r"^\[(?:FATAL|ERROR|WARN)\] \[[^\]]*\]:? ?(?P<text>.*)", re.MULTILINE)


@dataclass(frozen=True)
class Crash:
    """An exception that a program did not catch.

    Attributes:
        error: its type and text
        line: the last line of the program's own file in the traceback, from 1, or None
        library_line: file and line that raised it, where that is another file
    """

    error: str
    line: int | None
    library_line: str | None = None

    @property
    def kind(self) -> str:
        """Name of the exception's class."""
        return self.error.partition(":")[0].rpartition(".")[2]

    @property
    def text(self) -> str:
        """Text of the exception."""
        return self.error.partition(":")[2].strip()


def plain(output: str) -> str:
    """Return the output without colours."""
    return _COLOUR.sub("", output)


def crash(output: str, path: Path) -> Crash | None:
    """Return the first uncaught exception of the program in the file `path`, or None."""
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


def last_line(output: str) -> str:
    """Return the last warning or error that was logged; without one, the last line."""
    logged = _LOGGED.findall(plain(output))
    lines = logged or [line.strip() for line in plain(output).splitlines() if line.strip()]
    return lines[-1] if lines else "no output"


def warnings(output: str) -> list:
    """Return all warnings and errors that were logged."""
    return _LOGGED.findall(plain(output))


def meaning(crash: Crash) -> str:
    """Return what an exception means and how to fix it, for a beginner."""
    for kind, pattern, text in _MEANINGS:
        match = re.search(pattern, crash.text)
        if crash.kind == kind and match:
            return text.format(*match.groups())
    return (
        "Read the last line of the error first; it happened in the line of your file that is named "
        "above."
    )


_INIT_FIRST = "ROS is used before the node is registered: call `rospy.init_node` first."
# (class of the exception, pattern of its text, what it means); the first match counts.
_MEANINGS = (
    (
        "NameError",
        r"name 'rospy' is not defined",
        "`rospy` is not imported: write `import rospy` at the top of the file.",
    ),
    (
        "NameError",
        r"name '(\w+)' is not defined",
        "Python does not know `{0}` here: is it misspelt, or must it be imported or assigned "
        'before? Text needs quotes: "{0}".',
    ),
    (
        "UnboundLocalError",
        r"variable '(\w+)'",
        "`{0}` is used before it has a value: assign it first, with exactly this name.",
    ),
    (
        "ModuleNotFoundError",
        r"No module named 'sdc_package\.msg'",
        "The messages are not built: run `catkin_make` in the workspace, then "
        "`source devel/setup.bash`.",
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
        "There is no message `{0}` in the built package: is its name misspelt, is its file missing "
        "in CMakeLists.txt, or was `catkin_make` not run since?",
    ),
    (
        "ImportError",
        r"cannot import name '(\w+)' from '([\w.]+)'",
        "`{1}` has no `{0}`: is the name misspelt, or is it defined in another module?",
    ),
    (
        "AttributeError",
        r"'Subscriber' object has no attribute 'publish'",
        "A subscriber cannot publish: rospy.Subscriber receives, rospy.Publisher sends.",
    ),
    (
        "AttributeError",
        r"'(\w+)' object has no attribute '(\w+)'",
        "A {0} has no `{1}`: is the name misspelt, or is the object of another class than you "
        "expect?",
    ),
    (
        "AttributeError",
        r"has no attribute '(\w+)'",
        "There is no `{0}` in it: is the name misspelt?",
    ),
    (
        "TypeError",
        r"missing \d+ required positional arguments?: '(\w+)'",
        "A function is called without `{0}`. To pass a function as a callback, write its name "
        "without parentheses; to call it, pass all its arguments.",
    ),
    (
        "TypeError",
        r"takes \d+ positional arguments? but \d+ were given",
        "A function gets more arguments than it takes: count them.",
    ),
    (
        "TypeError",
        r"'(\w+)' object is not callable",
        "Parentheses call a function, and this is a {0}.",
    ),
    (
        "TypeError",
        r"Invalid number of arguments",
        "The message gets another number of fields than it has: see `rosmsg show`.",
    ),
    (
        "TypeError",
        r"got an unexpected keyword argument '(\w+)'",
        "There is no parameter `{0}`: is its name misspelt?",
    ),
    (
        "ValueError",
        r"is not a message data class",
        "The second argument is the class of the messages, imported from a package's msg module, "
        "such as `from sensor_msgs.msg import Image`.",
    ),
    ("ROSException", r"time is not initialized", _INIT_FIRST),
    ("ROSInitException", r"", _INIT_FIRST),
    (
        "IndentationError",
        r"",
        "The line begins at the wrong column: all lines of a region begin at the same column as "
        "the lines around it, with spaces.",
    ),
    ("TabError", r"", "Tabs and spaces are mixed: use spaces only."),
    ("SyntaxError", r"was never closed", "A bracket is opened and never closed."),
    (
        "SyntaxError",
        r"unterminated string",
        "A string is not closed: it begins and ends with the same quotes.",
    ),
    (
        "SyntaxError",
        r"",
        "Python cannot parse this line: look for a missing bracket, comma, colon or quote, in it "
        "and in the line before.",
    ),
)
