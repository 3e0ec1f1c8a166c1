"""The texts of the project are written in plain technical English."""

import os
import re
from functools import lru_cache
from pathlib import Path

import pytest

from sdc_testing.project import GENERATED

ROOT = Path(__file__).resolve().parents[1]
ENDINGS = (".py", ".md", ".yaml", ".launch", ".xml", ".txt", ".sh", ".msg", ".test")
SCRIPTS = ("drive", "test", "cockpit", "scenarios", "docker/prepare", "docker/environment")
# Words that readers with English as a second language have to decode: what to write in their place.
WORDS = {
    r"anew|once more": "again",
    r"hears?|heard|unheard|heed(s|ed)?|unheeded": "receive, subscribe to",
    r"mend(s|ed|ing)?": "fix",
    r"nobody|somebody|whoever": "no node, another node, the subscriber",
    r"shall": "must",
    r"reckon(s|ed)?": "measure, compute",
    r"falls? silent|fallen silent": "time out",
    r"stands (in|beside)|is laid over": "is in, is next to, overlays",
    r"is gone on with|lets it pass": "resumes, allows",
}


@lru_cache(maxsize=1)
def texts():
    """Return the lines of each text file of the project by its name."""
    lines = {}
    for folder, folders, files in os.walk(ROOT):
        folders[:] = sorted(set(folders) - GENERATED)
        for path in map(Path(folder).joinpath, sorted(files)):
            name = str(path.relative_to(ROOT))
            is_text = name.endswith(ENDINGS) or name in SCRIPTS
            if is_text and path.is_file() and path.name != "test_language.py":
                lines[name] = path.read_text(encoding="utf-8").splitlines()
    return lines


@pytest.mark.parametrize(("words", "instead"), WORDS.items())
def test_no_text_uses_a_word_that_must_be_decoded(words, instead):
    pattern = re.compile(rf"\b({words})\b", re.IGNORECASE)
    found = [
        f"{name}:{number}: '{match[0]}', write: {instead}"
        for name, lines in texts().items()
        for number, line in enumerate(lines, start=1)
        for match in pattern.finditer(line)
    ]
    assert found == []
