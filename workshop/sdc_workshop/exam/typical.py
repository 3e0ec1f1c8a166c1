"""Find typical mistakes in the text of a region, which explain why a step may be, or is, wrong."""

from __future__ import annotations

import ast
import contextlib
import re
import textwrap
from pathlib import Path

import yaml

from sdc_workshop.exam.answer import mistake
from sdc_workshop.regions import Region

_TABLE = Path(__file__).with_name("typical.yaml")


def mistakes(text: str, region: Region, solution: str) -> list:
    """Return answers about typical mistakes in the body of a region, which has this solution.

    Those with `expected` make the step wrong, the others are hints alone.
    """
    lines = [line for line in text.split("\n") if line.strip() and line.strip()[0] != "#"]
    code = re.sub(f"^{region.indent}", "", "\n".join(lines), flags=re.MULTILINE)
    found = []
    for row in yaml.safe_load(_TABLE.read_text(encoding="utf-8")):
        match = re.search(row["pattern"], f"{region.until_then or ''}\n{code}", re.MULTILINE)
        if match and re.search(row.get("solution", ""), solution):
            hint, seen = row["text"].format(*match.groups()), match[0].split("\n")[0].strip()
            found.append(mistake(row.get("expected", ""), seen, hint, region.number))
    return found + [mistake("", "", hint) for hint in _not_called(text)]


def _not_called(text: str) -> list:
    """Return a sentence for each statement that is a name: it does nothing."""
    found = []
    with contextlib.suppress(SyntaxError, ValueError, MemoryError, RecursionError):
        for node in ast.walk(ast.parse(textwrap.dedent(text))):
            if isinstance(node, ast.Expr) and isinstance(node.value, (ast.Name, ast.Attribute)):
                name = ast.unparse(node.value) if hasattr(ast, "unparse") else text.strip()
                found.append(
                    f"`{name}` does not call the function; with parentheses, `{name}()` does."
                )
    return found
