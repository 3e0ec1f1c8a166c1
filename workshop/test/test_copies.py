"""Copies are found under other names and layout; templates and the guide do not count."""

import tracemalloc

import pytest

from sdc_workshop.grading.copies import copies, written_tokens
from sdc_workshop.steps import find_step, load_steps
from sdc_workshop.workspace import make, solve, write

OWN = """    total = 0.0
    for part in (velocity.x, velocity.y):  # squares
        total = total + part ** 2
    return math.sqrt(total)
"""
RENAMED = """    s2=0.0
    for c in ( velocity.x,
               velocity.y ):
        s2 = s2 + c**2

    return math.sqrt( s2 )
"""


@pytest.mark.slow(2)
def test_renamed_copy_is_first_and_templates_have_no_tokens(tmp_path):
    tokens = {}
    for name, body in (("template", None), ("guide", ""), ("own", OWN), ("copy", RENAMED)):
        make(tmp_path / name)
        for step in load_steps() if body is not None else []:
            solve(tmp_path / name, step)
        if body:
            write(tmp_path / name, find_step("controller-2.5"), body)
        tokens[name] = written_tokens(tmp_path / name / "src")
    assert tokens["template"] == [] and tokens["own"] == tokens["copy"]
    first, *others = copies(tokens)
    assert (first.first, first.second, first.equal_percent) == ("own", "copy", 100.0)
    assert first.own_equal_tokens > 10
    assert [(pair.own_equal_tokens, 90 < pair.equal_percent < 100) for pair in others] == [
        (0, True),
        (0, True),
    ]


def test_other_files_do_not_push_out_what_a_student_has_written(tmp_path):
    make(tmp_path / "ws")
    write(tmp_path / "ws", find_step("controller-2.5"), OWN)
    found = written_tokens(tmp_path / "ws" / "src")
    for number in range(100):
        (tmp_path / "ws/src/sdc_package" / f"a{number}.py").write_text("+ - " * 120_000)
    tracemalloc.start()
    flooded = written_tokens(tmp_path / "ws" / "src")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert flooded[: len(found)] == found and peak < 20_000_000
