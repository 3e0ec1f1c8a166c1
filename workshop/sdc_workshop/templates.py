"""Write workshop/templates from the solution.

From the project's folder: PYTHONPATH=workshop python3 -m sdc_workshop.templates
"""

from __future__ import annotations

import shutil

from sdc_workshop.workspace import TEMPLATES, derived_templates


def stale() -> list:
    """Return the templates that differ from the solution: changed, missing, or left over."""
    derived = derived_templates()
    there = {
        str(path.relative_to(TEMPLATES)): path.read_text(encoding="utf-8")
        for path in TEMPLATES.rglob("*")
        if path.is_file()
    }
    return sorted(name for name in {*derived, *there} if derived.get(name) != there.get(name))


def main() -> None:
    """Write all templates."""
    shutil.rmtree(TEMPLATES, ignore_errors=True)
    for name, text in derived_templates().items():
        path = TEMPLATES / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
