"""Read YAML files and validate them against a JSON schema; every error names the file and line."""

from __future__ import annotations

import os
from functools import lru_cache
from typing import Any, Iterable

import yaml

from sdc_common.configuration import package_folder
from sdc_common.validation import DocumentError, is_number, suggestion

_TYPE_NAMES = {type(None): "nothing", dict: "a mapping", list: "a list"}


class YamlDocument:
    """The values of a YAML file, as plain Python types, and their lines."""

    def __init__(self, path: str, text: str, yaml_reader: Any):
        self.path = path
        self._text = text
        self._reader = yaml_reader
        self.values = yaml_reader.load(text)  # None for an empty file

    def line(self, keys: Iterable) -> int:
        """Return the line, counted from 1, of the value at a path of keys and list indices."""
        node, line = self._reader.compose(self._text), 0
        for key in keys:
            if node.id == "sequence":
                node = node.value[key]
                line = node.start_mark.line
            else:
                for name, value in node.value:
                    if name.value == str(key):
                        node, line = value, name.start_mark.line
        return line + 1

    def error(self, keys: Iterable, message: str) -> DocumentError:
        """Return the error to raise for the value at a path of keys and list indices."""
        return DocumentError(f"{self.path}, line {self.line(keys)}: {' '.join(message.split())}")


def load_yaml(path: str, fix: str) -> YamlDocument:
    """Read a YAML file without running code from it.

    Args:
        path: path of the file, may start with ~
        fix: advice for the error message if the file cannot be read

    Raises:
        DocumentError: the file cannot be read or is not valid YAML.
    """
    path = os.path.expanduser(path)
    try:
        with open(path, "rb") as file:
            return _parsed(path, file.read())
    except OSError as error:
        raise DocumentError(f"{path}: cannot be read ({error.strerror}); {fix}") from None


@lru_cache(maxsize=64)
def _parsed(path: str, content: bytes) -> YamlDocument:
    """Parse a file once: it takes longer than a second of a drive."""
    from ruamel.yaml import YAML  # Imports take 40 ms: only a drive with a scenario needs them.

    try:
        return YamlDocument(path, content.decode(), YAML(typ="safe", pure=True))
    except Exception as error:  # noqa: BLE001
        # ruamel.yaml raises many types, as for a scalar that does not fit its tag: "!!bool maybe".
        mark = getattr(error, "problem_mark", None)
        place = f"{path}, line {mark.line + 1}" if mark else path
        problem = (getattr(error, "problem", None) or str(error) or repr(error)).splitlines()[0]
        raise DocumentError(f"{place}: is not valid YAML ({problem}); correct it") from None


def load_document(path: str, schema_name: str, fix: str) -> YamlDocument:
    """Read a YAML file that is valid by a schema of config/schemas.

    Raises:
        DocumentError: the file cannot be read or is not valid
    """
    document = load_yaml(path, fix)
    validate(document, schema(schema_name))
    return document


@lru_cache(maxsize=None)
def packaged_config(name: str, folder: str = "") -> Any:
    """Return the values of a YAML file of config/ or another folder, named without its ending."""
    path = os.path.join(folder, name + ".yaml") if folder else config_path(name + ".yaml")
    with open(path, encoding="utf-8") as file:
        return yaml.safe_load(file)


def config_path(name: str) -> str:
    """Return the path of a file of config/."""
    return os.path.join(package_folder("sdc_sim"), "config", name)


def schema(name: str) -> dict:
    """Return a JSON schema (draft 7) of config/schemas."""
    return packaged_config("schemas/" + name)


def validate(document: YamlDocument, schema: dict) -> None:
    """Check the values of a document against a JSON schema (draft 7).

    The `description` in a schema completes the sentence "it must be ...".

    Raises:
        DocumentError: for the first line with a mistake.
    """
    mistakes = _mistakes(document.values, schema)
    if mistakes:
        # A misspelt key comes first: it is often the reason for other errors.
        _, keys, message = min(mistakes, key=lambda row: (row[0], document.line(row[1])))
        raise document.error(keys, message)


def check_parameter(name: str, value: Any, schema: dict) -> None:
    """Check the value of a parameter against a JSON schema (draft 7).

    Raises:
        ValueError: for a mistake; the message names the parameter
    """
    mistakes = _mistakes(value, schema)
    if mistakes:
        _, keys, message = mistakes[0]
        raise ValueError(f"{name}: {message}" if keys else message.replace("the file", name))


def _mistakes(values: Any, schema: dict) -> list[tuple[bool, list, str]]:
    """Return of each mistake: whether it is no unknown key, its path of keys, and a message."""
    return [
        (error.validator != "additionalProperties", *_describe(error))
        for error in _validator_class()(schema).iter_errors(values)
    ]


@lru_cache(maxsize=None)
def _validator_class() -> Any:
    import jsonschema  # 100 ms

    draft7 = jsonschema.Draft7Validator
    numbers = draft7.TYPE_CHECKER.redefine("number", lambda _, value: is_number(value))
    return jsonschema.validators.extend(draft7, type_checker=numbers)


def _describe(error: Any) -> tuple[list, str]:
    """Return the path of keys of a jsonschema error, and a message with the fix."""
    keys, value, rule = list(error.absolute_path), error.instance, error.validator_value
    name = _name(keys)
    if error.validator == "additionalProperties":
        known = list(error.schema["properties"])
        key = next(key for key in value if key not in known)
        return [*keys, key], f"unknown key '{key}'; {_suggestion(str(key), known, 'remove it or ')}"
    if error.validator == "required":
        key = next(key for key in rule if key not in value)
        return keys, f"key '{key}' is missing in {name}; add the line '{key}: ...'"
    if error.validator == "dependencies":
        for key, needed in rule.items():
            for needed_key in needed if key in value else ():
                if needed_key not in value:
                    fix = f"add '{needed_key}: ...' or remove '{key}'"
                    return [*keys, key], f"key '{needed_key}' is missing, '{key}' needs it; {fix}"
    found = _TYPE_NAMES.get(type(value)) or repr(value)[:40]
    if error.validator == "enum":
        known = [word if isinstance(word, str) else str(word).lower() for word in rule]
        return keys, f"{name} is {found}; {_suggestion(str(value), known)}"
    return keys, f"{name} must be {_expected(error.schema)}, got {found}"


def _expected(schema: dict) -> str:
    """Return what completes the sentence "it must be ..."."""
    kind = {
        "number": "a number",
        "integer": "a whole number",
        "boolean": "true or false",
        "object": "a mapping with lines of 'key: value'",
    }
    if "description" in schema:
        return schema["description"]
    if "maximum" in schema:
        return f"{kind[schema['type']]} from {schema['minimum']:g} to {schema['maximum']:g}"
    return kind[schema["type"]]


def _name(keys: list) -> str:
    if not keys:
        return "the file"
    if isinstance(keys[-1], int) and len(keys) > 1:
        return f"entry {keys[-1] + 1} of {_name(keys[:-1])}"
    return f"'{keys[-1]}'"


def _suggestion(word: str, known: list, other_fix: str = "") -> str:
    return suggestion(word, known, f"{other_fix}use one of {', '.join(known)}")
