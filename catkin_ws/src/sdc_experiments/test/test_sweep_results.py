"""The results of a sweep: what outlives a kill, and their tables, heat maps and page."""

import csv
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_experiments.sweep.cell_drive import code_version, drive_cell
from sdc_experiments.sweep.heat_maps import heat_maps
from sdc_experiments.sweep.page import write_page
from sdc_experiments.sweep.results import Results, ResultsError, table, write_csv
from sdc_experiments.sweep.statistics import combinations, estimate
from sdc_experiments.sweep.study import Study, load_study
from sdc_testing.chromium import check_page, headless_chromium

PACKAGE = Path(__file__).resolve().parents[1]
DOCUMENT = PACKAGE.parents[2] / "docs" / "sweeps.md"
IDENTITY = {"factors": {"k": [1, 2]}, "files": {}, "code": "a"}


def row(key, status="completed", rms=0.1, scenario="town", seed=1, **settings):
    metrics = {"cross_track_rms_m": rms, "driving_score": 90.0, "infractions": {"stop": 2}}
    found = {"key": key, "scenario": scenario, "settings": settings, "seed": seed}
    return {**found, "status": status, "metrics": metrics, "trace_sha256": "12"}


def test_rows_outlive_a_kill_and_a_torn_line_is_dropped(tmp_path):
    results = Results(tmp_path, IDENTITY)
    results.add(row("a"))
    results.add(row("b", "failed"), "the log")
    with open(tmp_path / "drives.jsonl", "ab") as file:
        file.write(b'{"key": "c", "status": "comp')
    results.close()
    again = Results(tmp_path, IDENTITY)
    assert (list(again.rows), again.finished) == (["a", "b"], {"a"})
    assert (tmp_path / again.failed[0]["log"]).read_text() == "the log"
    again.add(row("b"))
    again.close()
    lines = (tmp_path / "drives.jsonl").read_text().splitlines()
    assert [json.loads(line)["key"] for line in lines] == ["a", "b", "b"]
    assert Results(tmp_path, IDENTITY).finished == {"a", "b"}


@pytest.mark.parametrize(
    "change, named",
    [({"factors": {"k": [1]}}, "'factors' changed"), ({"code": "b"}, "the code, a configuration")],
)
def test_results_of_another_study_are_not_continued(tmp_path, change, named):
    results = Results(tmp_path, IDENTITY)
    results.close()
    Results(tmp_path, {**IDENTITY, **change}).close()  # There is no result yet.
    results = Results(tmp_path, IDENTITY)
    results.add(row("a"))
    results.close()
    with pytest.raises(ResultsError, match=named) as error:
        Results(tmp_path, {**IDENTITY, **change})
    assert "\n" not in str(error.value)


def test_table_has_a_column_for_each_setting_and_each_metric(tmp_path):
    rows = table([row("a", k=1.5, noise={"x": 1}), row("b", "failed", None, k=2.0)])
    write_csv(tmp_path / "results.csv", rows)
    with open(tmp_path / "results.csv", encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    found = [(one["k"], one["noise"], one["infractions_stop"]) for one in read]
    assert found == [("1.5", "{x: 1}", "2"), ("2.0", "", "2")]
    assert (read[1]["status"], read[1]["cross_track_rms_m"]) == ("failed", "")


def test_confidence_interval_is_that_of_students_t():
    # t(0.975, 4) = 2.776; the standard deviation of these values is sqrt(2.5).
    found = estimate([1.0, 2.0, 3.0, 4.0, 5.0])
    assert found == pytest.approx((3.0, 2.776 * math.sqrt(2.5 / 5.0)), rel=1e-3)
    assert math.isnan(estimate([7.0]).half_width)
    assert math.isnan(estimate([]).mean)


def test_errors_of_drives_that_were_not_completed_are_left_out():
    rows = [
        *(row("a", rms=0.1, k=1.0), row("b", "off_route", rms=9.0, seed=2, k=1.0)),
        *(row("c", "failed", rms=None, seed=3, k=1.0), row("d", rms=0.3, k=2.0)),
    ]
    first, second = combinations(rows, ["k"], ["cross_track_rms_m", "driving_score"])
    assert (first.drives, first.completed, first.failed) == (2, 1, 1)
    assert first.metrics["cross_track_rms_m"].mean == pytest.approx(0.1)
    assert first.metrics["driving_score"] == pytest.approx((90.0, 0.0))
    assert (second.values, second.metrics["cross_track_rms_m"].mean) == ({"k": 2.0}, 0.3)


def grid():
    return [
        row(f"{k}{v}{n}", rms=k + 10.0 * v + 100.0 * n, **{"x/k": k, "v": v, "one": 5, "y/n": n})
        for k in (1.0, 2.0)
        for v in (3.0, 4.0, 5.0)
        for n in (0.0, 1.0)
    ]


def test_heat_map_has_a_panel_for_each_value_of_the_third_factor():
    found = combinations(grid(), ["x/k", "v", "one", "y/n"], ["cross_track_rms_m"])
    maps = heat_maps(found, "cross_track_rms_m")
    assert (maps.y, maps.x) == (("x/k", [1.0, 2.0]), ("v", [3.0, 4.0, 5.0]))
    assert [panel.title for panel in maps.panels] == ["y/n 0", "y/n 1"]
    wanted = [[131.0, 141.0, 151.0], [132.0, 142.0, 152.0]]
    assert np.array_equal(maps.panels[1].means, wanted)
    assert heat_maps(found[:2], "cross_track_rms_m") is None, "only one factor varies"


@pytest.mark.slow(6)
def test_page_needs_no_other_file_and_shows_failures(tmp_path):
    study = Study(
        "gain.yaml", "About <b>", "in_process", ("town",), {}, {"x/k": (1.0, 2.0), "v": (3.0, 4.0)},
        (1,), ("cross_track_rms_m",), 300.0,
    )  # fmt: skip
    rows = [
        row(f"{k}{v}", "failed" if k == v - 1.0 else "completed", k + v, **{"x/k": k, "v": v})
        for k in (1.0, 2.0)
        for v in (3.0, 4.0)
    ]
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "a.log").write_text("ValueError: k is <bad>")
    for one in rows:
        one["log"] = "logs/a.log"
    page = write_page(tmp_path, study, rows, 1).read_text(encoding="utf-8")
    line = "<tr><td>town</td><td>2</td><td>4</td><td>1 of 1</td><td>6</td></tr>"
    for part in ("About &lt;b&gt;", "image/png;base64,", "k is &lt;bad&gt;", "logs/a.log", line):
        assert part in page
    assert 'src="http' not in page
    assert (tmp_path / "heat_map_cross_track_rms_m.png").stat().st_size > 5000
    with headless_chromium() as browser:
        check_page(browser, (tmp_path / "study.html").as_uri())


@pytest.mark.slow(4)
def test_document_shows_the_error_of_the_default_gain():
    study = load_study(str(PACKAGE / "studies" / "stanley_gain.yaml"))
    wanted = {2.5, 10.0, 0.05}
    cells = [cell for cell in study.cells() if wanted <= set(cell.settings.values())]
    driven = [drive_cell(tuple(cell), study.stack, 1.0, code_version())[0] for cell in cells]
    mean, half_width = estimate([one["metrics"]["true_cross_track_rms_m"] for one in driven])
    (row,) = re.findall(r"^\| 0.05 m \| 10 m/s .*$", DOCUMENT.read_text(), re.MULTILINE)
    assert f"{1e3 * mean:.1f} ± {1e3 * half_width:.1f}" == row.split("|")[5].strip()
    default = node_config("sdc_package", "simple_controller")["stanley_compensated"]["k"]
    assert f"**The default gain should stay {default:g}.**" in DOCUMENT.read_text()
