"""Reads YAML that people write by hand: every mistake is refused in one line that names file, line, key and mend."""

from __future__ import annotations

import difflib
import math
import os

import yaml


class ScenarioError(ValueError):
    """A scenario that no world should be made of; the message names the file, the line, the key and the mend."""


def read_text(path: str, mend: str) -> str:
    """The text of a file. Raises ScenarioError, which tells to `mend` it."""
    try:
        with open(os.path.expanduser(path), encoding="utf-8") as file:
            return file.read()
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}; {mend}") from None
    except (UnicodeDecodeError, ValueError):
        raise ScenarioError(f"{path}: is no text; {mend}") from None


class YamlReader:
    """Takes the nodes of one YAML file apart. Nodes, not values: they know their lines, and nothing in them can run code."""

    def __init__(self, path: str):
        self.path = os.path.expanduser(path)

    def refuse(self, node, message: str):
        """Raise ScenarioError for this node's line."""
        raise ScenarioError(
            f"{self.path}, line {node.start_mark.line + 1}: {' '.join(message.splitlines())}"
        )

    def compose(self, text: str):
        """The root node of the text, None where it is empty. Raises ScenarioError."""
        try:
            return yaml.compose(text, yaml.SafeLoader)
        except yaml.YAMLError as error:
            mark = getattr(error, "problem_mark", None)
            place = f"{self.path}, line {mark.line + 1}" if mark else self.path
            problem = " ".join(str(getattr(error, "problem", None) or error).split())
            raise ScenarioError(
                f"{place}: is no YAML ({problem}); write 'key: value' and lists as '- '"
            ) from None
        except (RecursionError, ValueError) as error:
            raise ScenarioError(
                f"{self.path}: is no YAML ({type(error).__name__}); write 'key: value' and lists as '- '"
            ) from None

    def mapping(self, node, known, what: str) -> dict:
        """The values (nodes) of a mapping by their keys, all of them among the known."""
        if not isinstance(node, yaml.MappingNode):
            self.refuse(node, f"{what} is no mapping; write lines of 'key: value'")
        entries = {}
        for key_node, value_node in node.value:
            key = str(key_node.value)
            if key not in known:
                close = difflib.get_close_matches(key, known, n=1)
                mend = (
                    f"did you mean '{close[0]}'?" if close else f"the keys are {', '.join(known)}"
                )
                self.refuse(key_node, f"unknown key '{key}'; {mend}")
            if key in entries:
                self.refuse(key_node, f"key '{key}' stands here twice; remove one of them")
            entries[key] = value_node
        return entries

    def sequence(self, node, key: str, example: str) -> list:
        """The nodes of a list."""
        if not isinstance(node, yaml.SequenceNode):
            self.refuse(node, f"'{key}' is no list; write each as '- {example}'")
        return node.value

    def text(self, node, key: str) -> str:
        """A word or a line of words."""
        if not isinstance(node, yaml.ScalarNode) or not str(node.value).strip():
            self.refuse(node, f"'{key}' must be a word; write it behind the colon")
        return str(node.value)

    def word(self, node, key: str, known) -> str:
        """One of the known words."""
        word = str(node.value) if isinstance(node, yaml.ScalarNode) else "a list"
        if word not in known:
            close = difflib.get_close_matches(word, known, n=1)
            mend = f"did you mean '{close[0]}'?" if close else f"write one of {', '.join(known)}"
            self.refuse(node, f"'{key}' is {word!r}; {mend}")
        return word

    def number(self, node, key: str, low: float, high: float) -> float:
        """A number in this range, both ends included."""
        try:
            if not isinstance(node, yaml.ScalarNode):
                raise ValueError("a list")
            value = float(node.value)
        except ValueError:
            found = repr(node.value) if isinstance(node, yaml.ScalarNode) else "a list"
            self.refuse(node, f"'{key}' is {found}; give a number")
        if not (math.isfinite(value) and low <= value <= high):
            self.refuse(node, f"'{key}' is {node.value}; give a number from {low:g} to {high:g}")
        return value

    def numbers(self, node, key: str, count: int, low: float, high: float) -> list:
        """A list of so many numbers."""
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != count:
            self.refuse(
                node,
                f"'{key}' must be a list of {count} numbers, such as [{', '.join(['1.0'] * count)}]",
            )
        return [self.number(entry, key, low, high) for entry in node.value]
