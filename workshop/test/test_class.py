"""./workshop/class: the page with the progress of a class, under pseudonyms."""

import json
import re

import pytest

from sdc_testing.chromium import check_page, headless_chromium
from sdc_workshop import progress
from sdc_workshop.classroom import main, minutes
from sdc_workshop.exam.answer import PASSED, WRONG, Answer
from sdc_workshop.steps import load_steps

STEPS = [step.id for step in load_steps()]


def keep(folder, name, right, **other):
    kept = {step_id: PASSED for step_id in STEPS[:right]}
    times = {step_id: {"first": 60 * n, "passed": 60 * n} for n, step_id in enumerate(kept)}
    package = folder / name / "sdc_ws/src/sdc_package"
    package.mkdir(parents=True)
    (package / progress.NAME).write_text(json.dumps({**kept, "times": times, **other}))


def rows(tmp_path, *options):
    """Write the page, and return the text of each row."""
    path = tmp_path / "class.html"
    assert main([str(tmp_path / "home"), "--once", "--output", str(path), *options]) == 0
    found = re.findall(r"<tr[^>]*>(.*?)</tr>", path.read_text(), re.DOTALL)
    return [" ".join(re.sub(r"<[^>]*>", " ", row).split()) for row in found]


@pytest.mark.slow(6)
def test_page_shows_who_is_where_and_keeps_pseudonyms(tmp_path, capsys):
    keep(tmp_path / "home", "ada", 3)
    keep(tmp_path / "home", "ben", 5)
    named, before = rows(tmp_path, "--names"), rows(tmp_path)
    assert named[1].startswith(f"ada 3 of {len(STEPS)} {STEPS[3]} ")
    assert next(row for row in named if row.startswith(STEPS[4])).endswith(" 1 of 2 1.0")
    keep(tmp_path / "home", "aaron", 4)
    keep(tmp_path / "home", "abe", 4, times={"camera-1": "now"})
    after = rows(tmp_path)
    assert f"{progress.NAME} is left out: it is damaged" in capsys.readouterr().err
    assert [row.split(" of ")[0] for row in after[1:4:2]] == [
        row.split(" of ")[0] for row in before[1:3]
    ]
    assert not re.search("aaron|abe|ada|ben", (tmp_path / "class.html").read_text())
    assert (tmp_path / "class.pseudonyms.json").stat().st_mode & 0o077 == 0
    with headless_chromium() as browser:
        check_page(browser, (tmp_path / "class.html").as_uri())


def test_page_shows_the_best_cars_under_pseudonyms(tmp_path):
    for name, score in (("ada", 61.5), ("ben", 74.25), ("cem", None)):
        keep(tmp_path / "home", name, 3, **({"my-car": score} if score else {}))
    cars = [row for row in rows(tmp_path, "--names") if row.endswith((" 61.5", " 74.2"))]
    assert cars == ["1 ben 74.2", "2 ada 61.5"]
    assert not any("ben" in row for row in rows(tmp_path))


def test_progress_that_is_a_link_is_left_out(tmp_path, capsys):
    for name in ("ada", "ben"):
        keep(tmp_path / "home", name, 3)
    ada, ben = (tmp_path / "home" / name / "sdc_ws/src/sdc_package" for name in ("ada", "ben"))
    (ben / progress.NAME).unlink()
    (ben / progress.NAME).symlink_to(ada / progress.NAME)
    assert not any(row.startswith("ben") for row in rows(tmp_path, "--names"))
    assert "ben: .progress.json is left out: it is not a file" in capsys.readouterr().err


def test_time_of_a_step_counts_from_the_step_before(tmp_path, monkeypatch):
    (tmp_path / "src/sdc_package").mkdir(parents=True)
    for now_s, step, status in (
        (60, 0, WRONG),
        (180, 0, PASSED),
        (480, 1, PASSED),
        (960, 0, WRONG),
        (480 + 3 * 3600, 2, PASSED),
    ):
        monkeypatch.setattr(progress.time, "time", lambda now_s=now_s: now_s)
        progress.keep(tmp_path, {STEPS[step]: Answer(status)})
    taken = minutes(progress.times(tmp_path))
    assert taken == {STEPS[0]: 2.0, STEPS[1]: 5.0, STEPS[2]: 60.0}, "who is away is at no step"
