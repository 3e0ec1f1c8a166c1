"""What check.py prints and draws."""

import sys

import pytest

from sdc_map import map_report
from sdc_testing.street_maps import lane, needs_maps, opendrive, town, write

pytestmark = needs_maps


def check(monkeypatch, capsys, *words):
    """Return the exit status of check.py, its output and its errors as lines."""
    monkeypatch.setattr(sys, "argv", ["check.py", *map(str, words)])
    status, output = map_report.main(), capsys.readouterr()
    return status, output.out.splitlines(), output.err.splitlines()


def test_what_is_in_a_network_is_printed(tmp_path, monkeypatch, capsys):
    status, lines, errors = check(monkeypatch, capsys, town(tmp_path))
    assert (status, errors) == (0, [])
    assert lines == [
        "town: 45 lanes for cars, 2.2 km; 12 sidewalks, 0 other lanes",
        "junctions: 2 (1 traffic_light, 1 priority)",
        "junctions with lights: 1; 4 stop lines, 6 give way lines, 5 crosswalks",
        "limits: 29 to 50 km/h",
        "traffic: on the right",
        "heights: 0.0 m",
        "size: x from -150 to 260 m, y from -120 to 120 m",
    ]


def test_side_heights_and_what_is_left_out_are_printed_and_drawn(tmp_path, monkeypatch, capsys):
    hill = '<elevationProfile><elevation s="0" a="0" b="0.1" c="0" d="0"/></elevationProfile>'
    text = opendrive("<line/>", 80, lane(-1) + lane(-2, kind="parking"))
    text = text.replace("</planView>", "</planView>" + hill).replace("<road ", '<road rule="LHT" ')
    picture = tmp_path / "map.png"
    status, lines, _ = check(monkeypatch, capsys, write(tmp_path, text), "--picture", picture)
    assert status == 0 and picture.read_bytes().startswith(b"\x89PNG")
    assert "traffic: on the left" in lines and "heights: 0.0 to 8.0 m" in lines
    assert lines[-1] == (
        "other than in the file: lanes of the type parking (1, the first: road 7 at 0 m)"
    )


@pytest.mark.slow(1)
@pytest.mark.parametrize("words", [("none.osm",), ("town", "--picture", "/none/a.png")])
def test_file_that_cannot_be_used_is_one_line(monkeypatch, capsys, words):
    status, _, errors = check(monkeypatch, capsys, *words)
    assert status == 2 and len(errors) == 1 and errors[0].startswith("check: ")
