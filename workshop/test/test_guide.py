"""Follow the guide word for word, in an empty home, with real terminals and a virtual display."""

import re
import time

import pytest
from finished_workspace import differences, is_given
from guide_blocks import edited, read
from guide_student import GUIDE, Student

from sdc_testing.virtual_display import VirtualDisplay
from sdc_workshop.steps import LABS, WORKSHOP, load_steps
from sdc_workshop.workspace import PROJECT, solution, solution_body


@pytest.fixture
def student(tmp_path):
    with VirtualDisplay() as display, Student(tmp_path, display) as student:
        yield student


@pytest.mark.nightly
@pytest.mark.slow(250)
def test_guide_leads_to_a_car_that_drives(student):
    times = []
    for page in GUIDE:
        student.page = page
        for block in read(page.read_text(encoding="utf-8")):
            start = time.monotonic()
            student.follow(block)
            times.append((time.monotonic() - start, page.name, block.line))
    assert differences(student.workspace) == [], "these files differ from the solution"
    steps = load_steps(optional=True)
    assert [step.id for step in steps if step.id not in student.steps_seen] == [], (
        "the guide lacks these steps"
    )
    print(
        "slowest blocks (s, page, line):",
        [(round(seconds, 1), *place) for seconds, *place in sorted(times, reverse=True)[:12]],
    )


@pytest.mark.parametrize("lab", (WORKSHOP, *LABS))
def test_each_snippet_equals_the_solution(lab):
    """The long tests find the same at their end; this one names the snippet at once."""
    written = {}
    for page in [PROJECT / "docs" / "labs" / f"{lab}.md"] if lab else GUIDE:
        for block in read(page.read_text(encoding="utf-8")):
            if block.does == "write":
                written[block.file, block.todo] = (page, block)
    for step in filter(lambda step: step.file and not is_given(step), load_steps(lab)):
        page, block = written[step.file, step.todo]
        assert block.text == solution_body(step), (
            f"{page}, line {block.line}: differs from the solution of {step.place}"
        )


def test_at_least_a_third_of_the_regions_is_written_alone():
    """Their lines are behind a fold."""
    guide = "".join(page.read_text(encoding="utf-8") for page in GUIDE)
    folds = re.findall(r"^<details.*?^</details>", guide, re.M | re.S)
    alone = {(block.file, block.todo) for block in read("\n".join(folds)) if block.does == "write"}
    steps = [(step.file, step.todo) for step in load_steps() if step.file]
    assert alone <= set(steps)
    assert 3 * len(alone) >= len(steps), f"{len(alone)} of {len(steps)}"


def test_each_edit_of_an_experiment_fits_and_is_taken_back():
    texts = {}
    blocks = [block for page in GUIDE for block in read(page.read_text(encoding="utf-8"))]
    for block in blocks:
        if block.does == "edit":
            own = solution(block.file).read_text(encoding="utf-8")
            texts[block.file] = edited(texts.get(block.file, own), block)
    for file, text in texts.items():
        assert text == solution(file).read_text(encoding="utf-8"), f"{file} stays changed"
