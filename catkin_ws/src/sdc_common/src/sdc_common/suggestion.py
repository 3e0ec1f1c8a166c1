"""The fix in an error message about a word that is not known."""

from __future__ import annotations

import difflib
from typing import Iterable


def suggestion(word: str, known: Iterable[str], otherwise: str) -> str:
    """Return the question whether the nearest known word was meant, `otherwise` if none is near.

    Args:
        word: the unknown word
        known: all known words
        otherwise: the fix if no known word is near
    """
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean '{close[0]}'?" if close else otherwise
