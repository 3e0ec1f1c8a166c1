"""Find typical mistakes in the text of a region; they explain why a step may be wrong."""

from __future__ import annotations

import ast
import re
import textwrap

from sdc_workshop.regions import Region

_DEGREES = re.compile(r"\b(?:degrees|rad2deg|180(?:\.0*)?|57\.2\d*)\b")


def mistakes(text: str, region: Region, solution: str) -> list:
    """Return sentences about typical mistakes in the body of a region, which has this solution."""
    return [
        *_left_over(text, region, "return" in solution),
        *_in_syntax(text, "spin" in solution),
        *_degrees(text),
    ]


def _left_over(text: str, region: Region, returns: bool) -> list:
    given = region.until_then
    if given is None:
        return []
    full = [line for line in text.split("\n") if line.strip() and line.strip()[0] != "#"]
    lines = [line.strip() for line in full]
    if len(lines) > 1 and lines[0] == given and given.startswith("return"):
        return [
            f"The line `{given}` of the template is still the first line of the region: the lines "
            "after it never run. Delete it."
        ]
    if (
        given.startswith("return ")
        and returns
        and not any(re.match(r".*\breturn\b", line) for line in lines)
    ):
        return ["The word `return` is missing: a function without it returns None."]
    # Deeper in a block, such as an `except`, it is the student's own.
    if len(lines) > 1 and full[-1] == region.indent + given and "=" in given:
        return [
            f"The line `{given}` of the template is still the last line of the region and "
            "overwrites your result. Delete it."
        ]
    return []


def _in_syntax(text: str, waits: bool) -> list:
    try:
        tree = ast.parse(textwrap.dedent(text))
    except SyntaxError:
        return []
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, (ast.Name, ast.Attribute)):
            name = ast.unparse(node.value) if hasattr(ast, "unparse") else text.strip()
            found.append(f"`{name}` does not call the function; with parentheses, `{name}()` does.")
        if isinstance(node, ast.Call) and _last_name(node.func) == "sleep" and not waits:
            found.append("A callback must not sleep: messages wait, or are lost, until it returns.")
        if isinstance(node, ast.Call) and _last_name(node.func) == "Subscriber":
            found += map(_called, _called_callbacks(node))
    return found


def _called_callbacks(call: ast.Call) -> list:
    """Return the names of callbacks that an argument of a call calls."""
    arguments = (*call.args, *(keyword.value for keyword in call.keywords))
    names = [_last_name(value.func) for value in arguments if isinstance(value, ast.Call)]
    return [name for name in names if name and name.startswith("on_")]


def _called(name: str) -> str:
    return (
        f"A callback is passed without parentheses: `self.{name}`. "
        f"`self.{name}()` calls it at once."
    )


def _degrees(text: str) -> list:
    if _DEGREES.search(text):
        return [
            "All angles are in radians: remove the degrees; `math.atan2` and the car's library "
            "use radians."
        ]
    return []


def _last_name(node: ast.expr) -> str | None:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else None
