"""Find typical mistakes in the text of a region, which explain why a step may be, or is, wrong."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import yaml

from sdc_workshop.exam.answer import listed, mistake
from sdc_workshop.regions import Region

_TABLE = Path(__file__).with_name("typical.yaml")


def mistakes(text: str, region: Region, solution: str) -> list:
    """Return answers about typical mistakes in the body of a region, which has this solution.

    Those with `expected` make the step wrong, the others are hints alone.
    """
    lines = [line for line in text.split("\n") if line.strip() and line.strip()[0] != "#"]
    code = re.sub(f"^{region.indent}", "", "\n".join(lines), flags=re.MULTILINE)
    code = f"{region.until_then or ''}\n{code}"
    found = []
    for row in yaml.safe_load(_TABLE.read_text(encoding="utf-8")):
        for match in re.finditer(row["pattern"], code, re.MULTILINE):
            if re.search(row.get("solution", "").format(*match.groups()), solution):
                hint, seen = row["text"].format(*match.groups()), match[0].split("\n")[-1].strip()
                found.append(mistake(row.get("expected", ""), seen, hint, region.number))
                break
    for name in dict.fromkeys(re.findall(r"\bself\.[\w.]+(?=\()", solution)):
        method = name.split(".")[-1]
        is_called = re.search(rf"\.{method} *(\(|$)", code, re.MULTILINE)
        # There are other ways to do what a list or an array does.
        is_own = f"def {method}(" in solution
        if not (is_called or is_own or hasattr(list, method) or hasattr(np.ndarray, method)):
            found.append(listed("not_called", todo=region.number, name=name))
    return found
