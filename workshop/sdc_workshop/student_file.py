"""The one reader of a student's files: what is no text that Python and ROS can read is named."""

from __future__ import annotations

import codecs
import contextlib
import re
from pathlib import Path

import yaml

from sdc_workshop.regions import RegionError

MAX_BYTES = 1_000_000
# UTF-32 first: its mark in little endian begins with that of UTF-16.
_MARKS = (
    *((codecs.BOM_UTF32_LE, "UTF-32"), (codecs.BOM_UTF32_BE, "UTF-32")),
    *((codecs.BOM_UTF16_LE, "UTF-16"), (codecs.BOM_UTF16_BE, "UTF-16")),
)
# Of the lines that git writes; of those that a student has deleted, one may be left.
_MERGE = re.compile(r"^(?:<{7}|>{7})(?: .*)?$", re.MULTILINE)


class FileError(RegionError):
    """A file that Python or ROS cannot read: what was seen, and how to fix it."""

    def __init__(self, seen: str, fix: str, line: int | None = None):
        super().__init__(f"{seen}; {fix}", line)
        self.seen, self.fix = seen, fix


def encoding_of(data: bytes) -> str:
    """Return the name of the encoding in which a text was most probably saved."""
    for mark, name in _MARKS:
        if data.startswith(mark):
            return name
    # Most texts are Latin letters, of which UTF-16 writes every other byte as 0.
    for start, name in ((1, "UTF-16LE"), (0, "UTF-16BE")):
        if 4 * (data[start::2].count(0) - data[1 - start :: 2].count(0)) > len(data):
            return name
    for name in ("UTF-8", "WINDOWS-1252"):
        with contextlib.suppress(UnicodeDecodeError):
            data.decode(name)
            return name
    return "ISO-8859-1"  # each byte is a character


def read(src: Path, file: str) -> str:
    """Return the text of a file in a src folder; its lines end with a line feed.

    Raises:
        FileError: it is no text in UTF-8, or an unfinished merge
        OSError: the file cannot be read
    """
    path, name = src / file, f"src/{file}"
    if path.stat().st_size > MAX_BYTES:
        raise FileError(f"it has more than {MAX_BYTES} bytes", "delete what no person has written")
    data = path.read_bytes()
    encoding = encoding_of(data)
    convert = f"iconv -f {encoding} -t UTF-8 {name} >new && cat new >{name}"
    if encoding.startswith("UTF-") and encoding != "UTF-8":
        raise FileError(f"the file is in {encoding}", f"save it as UTF-8: `{convert}`")
    if data.startswith(codecs.BOM_UTF8):
        fix = f"save it as UTF-8 without BOM: `sed -i '1s/^\\xEF\\xBB\\xBF//' {name}`"
        raise FileError("its first character is an invisible byte order mark", fix, 1)
    if b"\0" in data:
        fix = f"`sed -i 's/\\x00//g' {name}` removes it"
        raise FileError("an invisible NUL character", fix, _line(data, data.index(b"\0")))
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        seen = f"it is not UTF-8 (byte {data[error.start]:#04x})"
        fix = f"save the file as UTF-8: `{convert}`"
        raise FileError(seen, fix, _line(data, error.start)) from None
    if data.startswith(b"#!") and b"\r" in data.partition(b"\n")[0]:
        fix = (
            "save the file with Unix line ends (LF, not CRLF), because Linux takes the invisible "
            "character for a part of the interpreter's name: "
            f"`sed -i 's/\\r$//; s/\\r/\\n/g' {name}`"
        )
        raise FileError("its lines end as on Windows", fix, 1)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    merge = _MERGE.search(text)
    if merge:
        fix = "keep one of the two versions, and delete the lines <<<<<<<, ======= and >>>>>>>"
        raise FileError("an unfinished merge of git", fix, text.count("\n", 0, merge.start()) + 1)
    return text


def read_anyway(path: Path) -> str:
    """Return the beginning of a text in any encoding, as a person reads it."""
    with path.open("rb") as file:
        data = file.read(MAX_BYTES)
    text = data.decode(encoding_of(data), "replace").replace("\0", "")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def values(text: str) -> dict:
    """Return the content of a file of YAML or JSON; {} where it is none."""
    try:
        found = yaml.safe_load(text)
    except Exception:  # noqa: BLE001  such as RecursionError: a student has written it
        return {}
    return found if isinstance(found, dict) else {}


def _line(data: bytes, place: int) -> int:
    """Return the number of the line that contains a byte, from 1."""
    return data.count(b"\n", 0, place) + 1
