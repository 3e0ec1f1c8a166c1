"""Follow docs/first-steps.md word for word, in an empty home, with real terminals and a display."""

import itertools
import re

import pytest
from guide_blocks import read
from guide_student import Student

from sdc_common.processes import wait_until
from sdc_testing.virtual_display import VirtualDisplay
from sdc_workshop.workspace import PROJECT

LESSON = PROJECT / "docs" / "first-steps.md"
LIMIT_S = 60.0
POINTS = 30  # of the ellipse

pytestmark = [pytest.mark.nightly, pytest.mark.slow(100)]


class Reader(Student):
    """A reader of the lesson, whose files are in packages of their own."""

    def run(self, block):
        if "/check.py " not in block.text:
            super().run(block)
            return
        command = block.text.strip()  # it fails while a node is still starting
        wait_until(lambda: self.terminal("work").run(command)[0] == 0, LIMIT_S, command)

    def write(self, block):
        path = self.workspace / "src" / block.file
        mode = path.stat().st_mode if path.exists() else 0o644
        path.write_text(block.text, encoding="utf-8")
        path.chmod(mode)


@pytest.fixture
def reader(tmp_path):
    with VirtualDisplay(1200, 760) as display, Reader(tmp_path, display, LESSON) as reader:
        reader.workspace = tmp_path / "first_steps_ws"
        yield reader


def test_lesson_leads_to_a_car_that_drives_laps(reader):
    # What is before the first chapter starts the finished packages.
    introduction, *chapters = re.split(r"^(?=## )", LESSON.read_text(encoding="utf-8"), flags=re.M)
    above = introduction.count("\n")
    for block in read("".join(chapters)):
        reader.follow(block._replace(line=block.line + above))
    _, output = reader.terminal("work").run("timeout 45 rostopic echo /target_waypoint/idx")
    targets = [int(idx) for idx in re.findall(r"^(\d+)$", output, re.M)]
    assert {8, 9, 10} <= set(targets), "the points where the direction is near pi"
    steps = {(after - before) % POINTS for before, after in zip(targets, targets[1:])}
    assert steps == {0, 1}, "the target moves to the next point, never back"
    stays = [len(list(same)) for _, same in itertools.groupby(targets)]
    assert max(stays[1:]) < 30, "no loop: a loop takes 43 ticks, a point 13"
