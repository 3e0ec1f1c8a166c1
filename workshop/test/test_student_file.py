"""What is no text for Python and ROS is one named problem, in each command that reads it."""

import py_compile
import shutil

import pytest

from sdc_workshop import check, start
from sdc_workshop.exam.examination import Examination, check_of
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.exam.variant import make as variant
from sdc_workshop.grading.copies import written_tokens
from sdc_workshop.steps import find_step
from sdc_workshop.workspace import make, solve

CAMERA = "sdc_package/scripts/camera.py"
PID = "sdc_package/src/sdc_package/pid.py"
LATIN = "        # für die Größe\n"


def after_todo(data, line, encoding="utf-8"):
    """Return a file with a line more in the region of its second TODO."""
    start = data.index(b"TODO 2")
    place = data.index(b"\n", start) + 1
    return data[:place] + line.encode(encoding) + data[place:]


def recoded(encoding):
    return lambda data: data.decode().replace("\n", "\r\n").encode(encoding)


def merged(data):
    """Return a file with both versions of a region, as git leaves them."""
    return after_todo(
        data, "<<<<<<< HEAD\n        a = 1\n=======\n        a = 2\n>>>>>>> partner\n"
    )


# What is done to a file, and words of the one problem that is named.
BROKEN = {
    "latin-1": (lambda data: after_todo(data, LATIN, "cp1252"), ["not UTF-8 (byte 0xfc)", "iconv"]),
    "utf-16": (recoded("utf-16"), ["is in UTF-16;", "iconv -f UTF-16 -t UTF-8"]),
    "utf-16 big-endian without a mark": (recoded("utf-16-be"), ["is in UTF-16BE"]),
    "utf-32": (recoded("utf-32"), ["is in UTF-32"]),
    "half a character": (lambda data: data + "# ü".encode()[:-1], ["not UTF-8 (byte 0xc3)"]),
    "nul": (lambda data: after_todo(data, "        # \0\n"), ["an invisible NUL", "sed -i"]),
    "byte order mark": (lambda data: b"\xef\xbb\xbf" + data, ["byte order mark", "without BOM"]),
    "windows": (lambda data: data.replace(b"\n", b"\r\n"), ["as on Windows", "LF, not CRLF"]),
    "old mac": (lambda data: data.replace(b"\n", b"\r"), ["as on Windows"]),
    "code page 437": (lambda data: after_todo(data, LATIN, "cp437"), ["ISO-8859-1 -t UTF-8"]),
    "end of nul": (lambda data: data + bytes(3 * len(data)), ["an invisible NUL", "sed -i"]),
    "rest of a merge": (lambda data: after_todo(data, ">>>>>>> main\n"), ["an unfinished merge"]),
    "merge": (merged, ["an unfinished merge", "keep one of the two"]),
    "very large": (lambda data: data + b"#" * 1_000_000, ["more than 1000000 bytes"]),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "ws"
    make(folder)
    solve(folder, find_step("camera-1"))
    solve(folder, find_step("camera-2"))
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    folder = shutil.copytree(made, tmp_path / "ws", symlinks=True)
    monkeypatch.setenv("PWD", str(folder))
    return folder


@pytest.mark.parametrize("name", BROKEN)
def test_each_command_names_what_is_wrong_with_a_file(folder, name, capsys):
    change, words = BROKEN[name]
    path = folder / "src" / CAMERA
    path.write_bytes(change(path.read_bytes()))
    before = path.read_bytes()
    with Stage(Student(folder)) as stage:
        steps = [find_step("camera-1"), find_step("camera-2")]
        answers = Examination(Student(folder), stage).judge(steps)
    first, second = answers.values()
    assert (first.status, second.status, first.file) == ("wrong", "waiting", f"src/{CAMERA}")
    assert [word for word in words if word not in f"{first.seen}; {first.hint}"] == []
    for command, arguments in (
        (start, ["--update", str(folder)]),
        (check, ["--solution", "camera-2"]),
    ):
        assert command.main(arguments) in (1, 2)
        error = capsys.readouterr().err
        assert error.count("\n") == 1 and [word for word in words if word not in error] == []
    assert path.read_bytes() == before
    assert written_tokens(folder / "src"), "the search for copies reads every encoding"


def test_python_refuses_what_an_encoding_comment_makes_of_a_file(folder):
    """The text compiles; Python reads the file by its comment, and refuses it."""
    path = folder / "src" / CAMERA
    text = path.read_text().replace("\n", "\n# coding: no-such-encoding\n", 1)
    path.write_text(text)
    with pytest.raises(py_compile.PyCompileError):
        py_compile.compile(str(path), cfile=str(folder / "x.pyc"), doraise=True)
    problem = check_of(find_step("camera-2")).syntax_problem(variant(CAMERA, text, ("2",)))
    assert problem is not None and "encoding" in problem.seen


def test_windows_lines_and_other_text_of_a_module_that_python_reads_stay_right(folder):
    path = folder / "src" / PID
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert "\r" not in Student(folder).text(PID)
    (folder / ".workshop").write_bytes(b"\xff\xfe\xfc")
    assert start.main(["--update", str(folder)]) == 0
