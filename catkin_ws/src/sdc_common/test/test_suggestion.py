import pytest

from sdc_common.validation import suggestion

KNOWN = ("stanley", "pure_pursuit", "lqr")


@pytest.mark.parametrize(
    ("word", "meant"), [("stanly", "stanley"), ("pure pursuit", "pure_pursuit"), ("lqt", "lqr")]
)
def test_nearest_known_word_is_suggested(word, meant):
    assert suggestion(word, iter(KNOWN), "remove it") == f"did you mean '{meant}'?"


@pytest.mark.parametrize("known", [KNOWN, ()])
def test_other_fix_is_named_if_no_known_word_is_near(known):
    assert suggestion("quadratic", known, "remove it") == "remove it"
