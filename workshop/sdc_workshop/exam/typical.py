"""Mistakes that everybody makes once, seen in the text of a region. They never make a step wrong: they say why it may be."""

from __future__ import annotations

import ast
import re
import textwrap

from sdc_workshop.regions import Region

_DEGREES = re.compile(r"\b(?:degrees|rad2deg|180(?:\.0*)?|57\.2\d*)\b")


def mistakes(text: str, region: Region) -> list:
    """Sentences about what is typical in the body of a region."""
    return [*_left_over(text, region), *_in_syntax(text), *_degrees(text)]


def _left_over(text: str, region: Region) -> list:
    if region.until_then is None:
        return []
    lines = [
        line.strip()
        for line in text.split("\n")
        if line.strip() and not line.strip().startswith("#")
    ]
    if (
        lines
        and lines[0] == region.until_then
        and region.until_then.startswith("return")
        and len(lines) > 1
    ):
        return [
            f"The line `{region.until_then}` of the template still stands first in the region: what follows it is never reached. Delete it."
        ]
    if region.until_then.startswith("return ") and not any(
        re.match(r".*\breturn\b", line) for line in lines
    ):
        return ["The word `return` is missing: a function that returns nothing gives back None."]
    if len(lines) > 1 and lines[-1] == region.until_then and "=" in region.until_then:
        return [
            f"The line `{region.until_then}` of the template still stands last in the region and undoes yours. Delete it."
        ]
    return []


def _in_syntax(text: str) -> list:
    try:
        tree = ast.parse(textwrap.dedent(text))
    except SyntaxError:
        return []
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, (ast.Name, ast.Attribute)):
            named = ast.unparse(node.value) if hasattr(ast, "unparse") else text.strip()
            found.append(
                f"`{named}` only names the function; with parentheses, `{named}()`, it is called."
            )
        if isinstance(node, ast.Call) and _last_name(node.func) == "Subscriber":
            for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
                if isinstance(argument, ast.Call) and (_last_name(argument.func) or "").startswith(
                    "on_"
                ):
                    name = _last_name(argument.func)
                    found.append(
                        f"The callback is handed over without parentheses: `self.{name}`. With them, `self.{name}()`, it is called at once."
                    )
    return found


def _degrees(text: str) -> list:
    if _DEGREES.search(text):
        return [
            "All angles here are in radians: leave degrees out, `math.atan2` and the car's library know radians only."
        ]
    return []


def _last_name(node) -> str | None:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else None
