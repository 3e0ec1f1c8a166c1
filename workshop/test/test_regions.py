"""Regions of a file are found, replaced, and refused with line and fix where broken."""

import pytest

from sdc_workshop.regions import RegionError, body, is_written, regions, replaced, template

RULE = "# ----------------\n"
PYTHON = (
    f"#!/usr/bin/env python3\n# TODO 1 (line 1): the interpreter\n{RULE}def f(x):\n"
    f"    # TODO 2.1: twice x (until then: return 0)\n    return 2 * x\n    {RULE}"
    f"    # TODO 3: more\n    x = 1\n    y = 2\n    {RULE}"
)
XML = "<a>\n  <!-- TODO 1: a node -->\n  <node/>\n  <!-- - - - - - - - -->\n</a>\n"


def test_regions_are_found_in_the_order_of_the_file():
    found = regions(PYTHON)
    assert [(region.number, region.title, region.line) for region in found.values()] == [
        ("1", "the interpreter", 1),
        ("2.1", "twice x", 6),
        ("3", "more", 9),
    ]
    assert found["2.1"].until_then == "return 0"
    assert regions(XML)["1"].title == "a node"


def test_body_is_what_a_region_contains():
    assert body(PYTHON, "1") == "#!/usr/bin/env python3\n"
    assert body(PYTHON, "3") == "    x = 1\n    y = 2\n"
    assert body(XML, "1") == "  <node/>\n"


def test_template_is_unsolved_and_becomes_the_solution_again():
    for text in (PYTHON, XML):
        empty = template(text)
        assert template(empty) == empty
        for number in regions(text):
            assert not is_written(empty, number)
            assert is_written(text, number)
            empty = replaced(empty, number, body(text, number))
        assert empty == text
    assert template(PYTHON).startswith("\n# TODO 1")
    assert "    return 0\n" in template(PYTHON)
    assert "x = 1" not in template(PYTHON)


def test_given_region_keeps_its_lines_in_the_template_and_can_be_emptied():
    given = PYTHON.replace("TODO 3:", "TODO 3 (given):")
    assert body(template(given), "3") == body(PYTHON, "3")
    assert is_written(template(given), "3")
    assert not is_written(replaced(given, "3", "\n    # x = 1\n"), "3")


def test_comments_and_blank_lines_do_not_count_as_written():
    empty = template(PYTHON)
    assert not is_written(replaced(empty, "3", "\n    # hm\n"), "3")
    assert is_written(replaced(empty, "3", "    pass\n"), "3")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"# TODO 1: a\n# TODO 2: b\n{RULE}", "line 2: TODO 2 begins before TODO 1 is closed"),
        ("x\n# TODO 1: a\nx\n", "line 2: TODO 1 is not closed"),
        (f"x\n{RULE}", "line 2: this rule closes no TODO"),
        (f"# TODO 1: a\n{RULE}# TODO 1: a\n{RULE}", "line 3: TODO 1 is there twice"),
    ],
)
def test_broken_regions_are_refused_with_their_line(text, message):
    with pytest.raises(RegionError, match=message):
        regions(text)


def test_unknown_region_is_refused():
    with pytest.raises(RegionError, match="there is no 'TODO 4'"):
        body(PYTHON, "4")
