import html.parser
import os
import re

import numpy as np
import pytest
import yaml
from matplotlib.image import imread

from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.report.camera_snapshots import CameraSnapshot
from sdc_sim.report.html_page import page, write_html, write_png
from sdc_sim.report.plots import thinned

with open(
    os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "referee.yaml"),
    encoding="utf-8",
) as config:
    RULES = EvaluationRules.read(yaml.safe_load(config).get)


def driven(ticks, commands=True):
    watch = Evaluator(RULES)
    angle = np.linspace(0.0, 1.5, 80)
    watch.mission(np.column_stack([60.0 * np.sin(angle), 60.0 - 60.0 * np.cos(angle)]))
    for tick in range(ticks):
        turned = 0.25 * tick / 60.0
        watch.odometry(
            tick * 50_000_000, 60.1 * np.sin(turned), 60.0 - 60.1 * np.cos(turned), turned, 5.0
        )
        watch.planned(5.2)
        if commands:
            watch.command(tick * 50_000_000, 0.3, 0.0, -0.1)
    return watch


class Check(html.parser.HTMLParser):
    """Every tag is closed in order."""

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_one_file_that_needs_nothing_else():
    watch = driven(200)
    watch.infraction("red_light")
    watch.collision(0, 0)
    text = page(watch.result(), [CameraSnapshot(1.0, 25.0, b"jpeg")])
    check = Check()
    check.feed(text)
    assert check.open == []
    links = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert [link for link in links if not link.startswith(("#", "data:"))] == []
    assert "url(http" not in text
    assert "@import" not in text
    ids = re.findall(r' id="([^"]*)"', text)
    assert len(ids) == len(set(ids)), "the two drawings do not get in each other's way"
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)
    for part in (
        "ran a red light",
        "hit a thing",
        "cross_track_p95_m",
        "What the camera saw",
        "25 % of the route",
    ):
        assert part in text


def test_what_is_not_known_is_left_out():
    text = page(driven(100, commands=False).result(), [])
    assert "What the camera saw" not in text
    assert "What happened" not in text
    assert "aborted" in text


@pytest.mark.parametrize("ticks", [1, 2, 7, 100])
def test_the_shortest_drives_are_drawn(tmp_path, ticks):
    result = driven(ticks).result()
    write_png(str(tmp_path / "report.png"), result)
    write_html(str(tmp_path / "report.html"), result, [])
    assert imread(tmp_path / "report.png").shape == (900, 1600, 4)
    assert (tmp_path / "report.html").stat().st_size > 20_000


def test_the_same_drive_gives_the_same_page():
    assert page(driven(100).result(), []) == page(driven(100).result(), [])


def test_thinning_keeps_the_extremes():
    x = np.arange(100_000.0)
    y = np.zeros_like(x)
    y[54_321], y[77_777] = 9.0, -7.0
    few_x, few_y = thinned(x, y)
    assert len(few_x) <= 4000
    assert (few_y.max(), few_y.min()) == (9.0, -7.0)
    assert (np.diff(few_x) > 0.0).all()


def test_a_long_drive_makes_no_heavy_page():
    watch = driven(1)
    for tick in range(1, 20_000):
        turned = 0.25 * tick / 60.0 * 0.017
        watch.odometry(
            tick * 50_000_000,
            60.0 * np.sin(turned) + 0.01 * (tick % 7),
            60.0 - 60.0 * np.cos(turned),
            turned,
            5.0,
        )
    assert len(page(watch.result(), [])) < 1_500_000


def test_unwritable(tmp_path):
    with pytest.raises(OSError, match="gone"):
        write_html(str(tmp_path / "gone" / "report.html"), driven(20).result(), [])
    with pytest.raises(OSError, match="gone"):
        write_png(str(tmp_path / "gone" / "report.png"), driven(20).result())
