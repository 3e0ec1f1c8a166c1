import html.parser
import math
import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from referee_rules import RULES, TICK_NS

from sdc_sim.evaluation.drive_evaluation import COLUMNS
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.metrics import COEFFICIENTS
from sdc_sim.report.html_page import MEANINGS, write_html
from sdc_sim.report.plots import PANELS, write_png
from sdc_testing.street_maps import needs_maps, town

pytestmark = pytest.mark.slow(12)
NAN = math.nan


def driven(ticks, commands=True, rules=RULES):
    evaluator = Evaluator(rules)
    angle = np.linspace(0.0, 1.5, 80)
    evaluator.set_route(np.column_stack([60.0 * np.sin(angle), 60.0 - 60.0 * np.cos(angle)]))
    for tick in range(ticks):
        turned = 0.25 * tick / 60.0
        x, y = 60.1 * np.sin(turned), 60.0 - 60.1 * np.cos(turned)
        evaluator.add("odometry", tick * TICK_NS, x, y, turned, 5.0)
        evaluator.add("planned", 5.2)
        if commands:
            evaluator.add("command", tick * TICK_NS, 0.3, 0.0, -0.1)
    return evaluator


def page_of(result, folder):
    write_html(str(folder / "report.html"), result)
    return (folder / "report.html").read_text(encoding="utf-8")


class TagChecker(html.parser.HTMLParser):
    """Asserts that every tag is closed in order."""

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_page_needs_no_other_file(tmp_path):
    evaluator = driven(200)
    evaluator.drive.progress.add_infraction("red_light")
    evaluator.add("collision", 0, 0)
    evaluator.add("snapshot", 1.0, 25.0, "anBlZw==")
    text = page_of(evaluator.result(), tmp_path)
    check = TagChecker()
    check.feed(text)
    assert check.open == []
    links = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert [link for link in links if not link.startswith(("#", "data:"))] == []
    assert "url(http" not in text
    assert "@import" not in text
    ids = re.findall(r' id="([^"]*)"', text)
    assert len(ids) == len(set(ids)), "the ids of the two drawings differ"
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)
    parts = "ran a red light", "hit an object", "cross_track_p95_m", "<h2>Camera</h2>"
    for part in (*parts, "25 % of the route"):
        assert part in text


def test_page_escapes_text_from_the_metrics(tmp_path):
    result = driven(20).result()
    text = "<script>alert('x')</script> & more"
    result.progress.rules = result.progress.rules._replace(assumed=[text])
    text = page_of(result, tmp_path)
    assert "<script>" not in text
    assert "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; more" in text


def test_page_shows_every_metric_with_its_meaning(tmp_path):
    result = driven(20).result()
    text = page_of(result, tmp_path)
    assert [name for name in result.metrics if f"<tr><td>{name}</td>" not in text] == []
    assert [name for name in result.metrics if name not in MEANINGS] == []


@pytest.mark.parametrize("ticks", [1, 2, 100])
def test_short_drives_are_drawn(tmp_path, ticks):
    result = driven(ticks).result()
    write_png(str(tmp_path / "report.png"), result)
    assert len(page_of(result, tmp_path)) > 20_000
    assert imread(tmp_path / "report.png").shape == (900, 1600, 4)


@pytest.mark.parametrize("command", [(NAN, NAN, NAN), (0.5, 0.0, NAN), (0.5, 0.0, -math.inf)])
def test_drive_whose_commands_were_all_refused_has_a_page_that_says_so(tmp_path, command):
    evaluator = driven(20, commands=False)
    for tick in range(20):
        evaluator.add("command", tick * TICK_NS, *command)
    result = evaluator.result()
    write_png(str(tmp_path / "report.png"), result)
    assert "20 commands were refused" in page_of(result, tmp_path)
    assert "were refused" not in page_of(driven(20).result(), tmp_path)


@pytest.mark.parametrize(
    ("title", "line", "value"),
    [
        ("speed [m/s]", -1, 5.0),
        ("cross-track error [m], left is positive", -1, -0.1),
        ("steer, right is positive", -1, -0.1),
        ("lateral acceleration [m/s²], left is positive", 0, 5.0 * 0.25 / 60.0 / 0.05),
    ],
)
def test_panels_show_the_drive_with_its_signs(title, line, value):
    """The car turns left outside of the circle, so right of the route."""
    evaluator = driven(100)
    for sample in evaluator.drive.progress.samples:
        assert (sample.cross_track_m, sample.speed_mps) == (pytest.approx(-0.1, abs=0.02), 5.0)
    result = evaluator.result()
    axes = Figure().add_subplot()
    PANELS[title][1](axes, result, dict(zip(COLUMNS, result.rows.T)))
    np.testing.assert_allclose(axes.lines[line].get_ydata(), value, rtol=0.2)


@needs_maps
def test_drive_on_a_map_shows_its_lanes_and_names_every_infraction(tmp_path):
    plain = page_of(driven(40).result(), tmp_path)
    evaluator = driven(40, rules=RULES._replace(map=town(tmp_path)))
    for name in COEFFICIENTS:
        evaluator.drive.progress.add_infraction(name)
    page = page_of(evaluator.result(), tmp_path)
    assert page.count("<path") > plain.count("<path") + 30
    for text in ("near miss", "speeding", "took the right of way", "blocked a junction"):
        assert text in page
