"""The texts of the project are written in plain technical English."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ENDINGS = (".py", ".md", ".yaml", ".launch", ".xml", ".txt", ".sh", ".msg", ".test")
GENERATED = {
    *(".git", ".tools", ".browser", ".learning", ".highway"),
    *("build", "devel", "world_ws", "report", "grades"),
}
SCRIPTS = ("drive", "test", "docker/prepare", "docker/environment")
# Metaphors and old-fashioned words, which readers with English as a second language have to decode.
WORDS = re.compile(
    r"\b(anew|once more|heed(s|ed)?|unheeded|mend(s|ed|ing)?|nobody|somebody|whoever|shall"
    r"|hears|heard|unheard|is gone on with|is laid over|falls? silent"
    r"|fallen silent|stands beside|reckon(s|ed)?)\b",
    re.IGNORECASE,
)


def texts():
    for path in sorted(ROOT.rglob("*")):
        name = str(path.relative_to(ROOT))
        generated = GENERATED & set(path.parts)
        if not generated and path.is_file() and (name.endswith(ENDINGS) or name in SCRIPTS):
            yield path


@pytest.mark.parametrize("folder", ["catkin_ws", "workshop", "docs", "."])
def test_no_text_uses_a_word_that_must_be_decoded(folder):
    found = []
    for path in texts():
        parts = path.relative_to(ROOT).parts
        if (parts[0] if parts[0] in ("catkin_ws", "workshop", "docs") else ".") != folder:
            continue
        if path.name == "test_language.py":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            found += [
                f"{path.relative_to(ROOT)}:{number}: {match[0]}" for match in WORDS.finditer(line)
            ]
    assert found == []
