"""Translations of pages and hints: a folder a language beside the English texts.

A section of a page and a hint keep a hash of the English text from which they were made.
`python3 -m sdc_workshop.languages` lists those whose English text has changed since; with
`--update FILE`, after the translation was changed, their hashes become those of today.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from sdc_workshop.steps import FOLDER, hints, language

# The pages of the guide in their order: the first one, and one for each phase.
GUIDE = ("guide.md", *(f"phase-{number}.md" for number in (1, 2, 3, 4)))
_FROM = re.compile(r"^<!-- from: (.*), (\w+) -->\n", re.MULTILINE)


def english_page(path: Path) -> Path:
    """Return the English page of a translated one: of the guide, or of docs/."""
    name = path.relative_to(FOLDER).relative_to(path.relative_to(FOLDER).parts[0])
    return FOLDER / name if (FOLDER / name).is_file() else FOLDER.parent / "docs" / name


def sections(page: str) -> dict:
    """Return the sections of a page by their titles, each from its heading to the next one."""
    found: dict = {}
    title, in_code = "", False
    for line in page.splitlines(keepends=True):
        in_code ^= line.startswith("```")
        if re.match("#+ ", line) and not in_code:
            title = line.lstrip("#").strip()
        found[title] = found.get(title, "") + line
    return found


def translated_sections(page: str) -> dict:
    """Return (text, hash) of each section of a translated page, by its English title."""
    marks = ((_FROM.search(text), text) for text in sections(page).values())
    return {mark[1]: (_FROM.sub("", text), mark[2]) for mark, text in marks if mark}


def page(name: str) -> str:
    """Return a page of the workshop: each section in the language of the environment, or English.

    Links are relative to the folder of the English page.
    """
    text = (FOLDER / name).read_text(encoding="utf-8")
    path = FOLDER / language() / name
    if not language() or not path.is_file():
        return text
    own = translated_sections(path.read_text(encoding="utf-8").replace("](../", "]("))
    return "".join(own.get(title, (body,))[0] for title, body in sections(text).items())


def entries(path: Path) -> list:
    """Return (name, hash that is kept, hash of today) of each section or hint of a translation."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".yaml":
        english, own = hints(), hints(path.parent.name)
        rows = {name: row["from"] for name, row in own.items()}
    else:
        english = sections(english_page(path).read_text(encoding="utf-8"))
        rows = {name: row[1] for name, row in translated_sections(text).items()}
    return [(name, str(old), _hash(english.get(name))) for name, old in rows.items()]


def _hash(text: object) -> str:
    """Return the hash of a text; lines that are only wrapped in another way do not change it."""
    return hashlib.sha256(" ".join(str(text).split()).encode()).hexdigest()[:8]


def stale() -> list:
    """Return a line with file, section and fix for each translation that is not of this English."""
    fix = "change it, then PYTHONPATH=workshop python3 -m sdc_workshop.languages --update"
    folders = [path.parent for path in sorted(FOLDER.glob("??/hints.yaml"))]
    paths = [path for folder in folders for path in sorted(folder.rglob("*.*"))]
    return [
        f"{path}: '{name}' was made from another English text: {fix} {path}"
        for path in paths
        for name, old, now in entries(path)
        if old != now
    ]


def update(path: Path) -> None:
    """Write the hashes of today into a translation."""
    text = path.read_text(encoding="utf-8")
    for name, _, now in entries(path):
        escaped = re.escape(name)
        text = re.sub(rf"(?m)^(<!-- from: {escaped}, )\w+", rf"\g<1>{now}", text)
        text = re.sub(rf"(?m)^({escaped}:\n  from: ).*", rf'\g<1>"{now}"', text)
    path.write_text(text, encoding="utf-8")


def main(arguments: Sequence[str]) -> int:
    """List stale translations, or update the hashes of files; return the exit status."""
    for name in arguments[1:] if arguments[:1] == ["--update"] else ():
        update(Path(name).resolve())
    hints.cache_clear()
    lines = stale()
    print("\n".join(lines) or "All translations are of the English texts of today.")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
