"""Tests of YAML documents: the lines of their values, and the one-line error of each mistake."""

import re

import pytest

from sdc_common.validation import DocumentError
from sdc_sim.yaml_document import load_yaml, validate

NOT_UTF_8 = "can't decode byte 0x89 in position 0: invalid start byte"
OPEN_LIST = "expected ',' or ']', but got '<stream end>'"
PAIRS = ("speed", "start"), ("start", "speed")
NEEDS = "2: key '{1}' is missing, '{0}' needs it; add '{1}: ...' or remove '{0}'"
NO_NUMBER = "'points' must be a number from 0, got"
KNOWN = "remove it or use one of speed, start, kind, points, stop"
NUMBER = {"type": "number", "minimum": 0.0, "description": "a number from 0"}
NUMBERS = {"type": "array", "description": "a list", "items": NUMBER}
SCHEMA = {
    "type": "object",
    "description": "a mapping",
    "additionalProperties": False,
    "properties": {
        "speed": NUMBER,
        "start": NUMBER,
        "kind": {"enum": ["car", "van"]},
        "points": {"type": "array", "description": "a list of lists", "items": NUMBERS},
        "stop": {"type": "object", "required": ["at", "by"], "description": "a stop"},
    },
    "dependencies": {"speed": ["start"], "start": ["speed"]},
}


def load(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return load_yaml(str(path), "name another file")


def refused(path, message):
    return pytest.raises(DocumentError, match=f"^{re.escape(str(path) + message)}$")


def test_values_are_plain_types_of_python(tmp_path):
    values = load(tmp_path, "a: [1, 2.5, true, ü, null]\nb: {c: 0x10}").values
    assert values == {"a": [1, 2.5, True, "ü", None], "b": {"c": 16}}
    kinds = [type(value) for value in values["a"]]
    assert kinds == [int, float, bool, str, type(None)]
    assert (type(values), type(values["a"]), type(values["b"]["c"])) == (dict, list, int)
    assert load(tmp_path, "").values is None


def test_path_may_start_with_the_home_folder(tmp_path, monkeypatch):
    (tmp_path / "mine.yaml").write_text("a: 1")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert load_yaml("~/mine.yaml", "").path == str(tmp_path / "mine.yaml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"\x89PNG\xff\xfe", f": is not valid YAML ('utf-8' codec {NOT_UTF_8})"),
        ("a: " * 2 + "1", ", line 1: is not valid YAML (mapping values are not allowed here)"),
        ("a: 1\nb: [2", f", line 2: is not valid YAML ({OPEN_LIST})"),
        ("a: !!int seven", ": is not valid YAML (invalid literal for int() with base 10: 'seven')"),
        ("[" * 1000, ": is not valid YAML (maximum recursion depth exceeded)"),
    ],
    ids=["picture", "two colons", "open list", "tag", "nested"],
)
def test_file_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, message):
    with refused(tmp_path / "mine.yaml", message + "; correct it"):
        load(tmp_path, text)


def test_missing_file_is_refused_with_its_fix():
    with refused("/no/where.yaml", ": cannot be read (No such file or directory); name another"):
        load_yaml("/no/where.yaml", "name another")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- 1", "1: the file must be a mapping, got a list"),
        ("kind: car\n3: 1", f"2: unknown key '3'; {KNOWN}"),
        ("kind: car\nspede: 1", "2: unknown key 'spede'; did you mean 'speed'?"),
        ("kind: car\nxyz: 1", f"2: unknown key 'xyz'; {KNOWN}"),
        ("kind: cra", "1: 'kind' is 'cra'; did you mean 'car'?"),
        ("kind: xyz", "1: 'kind' is 'xyz'; use one of car, van"),
        ("kind: {}", "1: 'kind' is a mapping; use one of car, van"),
        ("stop: {at: 1}", "1: key 'by' is missing in 'stop'; add the line 'by: ...'"),
        *((f"kind: car\n{a}: 1", NEEDS.format(a, b)) for a, b in PAIRS),
        ("points: 7", "1: 'points' must be a list of lists, got 7"),
        ("points:", "1: 'points' must be a list of lists, got nothing"),
        ("points:\n- [1]\n- [2, x]", f"3: entry 2 of entry 2 of {NO_NUMBER} 'x'"),
        ("points:\n- [.nan]", f"2: entry 1 of entry 1 of {NO_NUMBER} nan"),
        ("points: [[true]]", f"1: entry 1 of entry 1 of {NO_NUMBER} True"),
        (f"points: {'x' * 60}", f"1: 'points' must be a list of lists, got '{'x' * 39}"),
        ("points: 7\nkind: 8", "1: 'points' must be a list of lists, got 7"),
        ("points: 7\nspeedy: 8", "2: unknown key 'speedy'; did you mean 'speed'?"),
    ],
)
def test_mistake_is_refused_with_line_name_and_fix(tmp_path, text, message):
    document = load(tmp_path, text)
    with refused(tmp_path / "mine.yaml", f", line {message}"):
        validate(document, SCHEMA)
