import json
import os
import subprocess
import sys

import pytest

from sdc_sim.report.comparison import ReportReadError, differences, load_report

pytestmark = pytest.mark.slow(5)

COMPARE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts", "compare.py")
METRICS = {"status": "completed", "route_length_m": 100.0, "route_completion_percent": 100.0}
METRICS.update(duration_s=20.0, cross_track_rms_m=0.02, cross_track_max_m=0.1)
METRICS.update(infractions={"stop": 0}, comfortable=True)
TRACE = (
    "time_s,x_m,y_m,yaw_rad,speed_mps,s_m,cross_track_m,heading_error_rad,throttle,brake,steer\n"
    + "".join(
        f"{tick * 0.05},{tick * 0.5},0.1,0.0,10.0,{tick * 0.5},0.1,0.0,0.5,0.0,"
        f"{'' if tick == 3 else 0.1}\n"
        for tick in range(200)
    )
)


@pytest.fixture
def two(tmp_path):
    for name, changes in (
        ("a", {}),
        ("b", {"cross_track_rms_m": 0.03, "status": "aborted", "infractions": {"stop": 2}}),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "report.json").write_text(json.dumps({**METRICS, **changes}))
        (tmp_path / name / "report.csv").write_text(TRACE)
    return tmp_path


def compare(folder, *arguments):
    command = [sys.executable, COMPARE, *arguments]
    return subprocess.run(command, cwd=folder, text=True, capture_output=True, check=False)


def test_equal_metrics_have_no_difference(two):
    a, b = load_report(str(two / "a")), load_report(str(two / "b" / "report.json"))
    changed = {name: change for name, _, _, change in differences(a.metrics, b.metrics) if change}
    expected = {"cross_track_rms_m": "+0.01 (+50.0 %)", "status": "differs"}
    assert changed == {**expected, "infractions.stop": "+2"}


def test_command_prints_a_table_and_draws_both_drives(two):
    done = compare(two, "a", "b", "--plot", "both.png")
    assert done.returncode == 0, done.stderr
    assert "cross_track_rms_m" in done.stdout
    assert "both drives: both.png" in done.stdout
    assert (two / "both.png").stat().st_size > 10_000


def test_without_a_trace_no_picture_is_drawn(two):
    (two / "a" / "report.csv").unlink()
    done = compare(two, "a", "b")
    assert done.returncode == 0
    assert "no picture" in done.stdout


@pytest.mark.parametrize(
    ("text", "part"), [("{}", "no status"), ("[1", "not a report"), (None, "No such file")]
)
def test_error_names_a_file_that_is_not_a_report(two, text, part):
    path = two / "a" / "report.json"
    path.unlink()
    if text is not None:
        path.write_text(text)
    with pytest.raises(ReportReadError, match=part) as error:
        load_report(str(two / "a"))
    assert "\n" not in str(error.value)
