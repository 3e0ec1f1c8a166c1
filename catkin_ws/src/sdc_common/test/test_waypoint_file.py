import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sdc_common.routes.waypoint_file import WaypointError, load_waypoints, main

GOOD = "0,0\n1,0\n2,-1\n"
ROUTE = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]])

ACCEPTED = [
    ("plain", GOOD),
    ("further columns", "0,0,90,a\n1,0,90,b\n2,-1,45,c\n"),
    ("header", "x,y,yaw\n" + GOOD),
    ("quoted header", '"X","Y"\n' + GOOD),
    ("comments", "# a route\n0,0\n1,0 # here # there\n2,-1\n"),
    ("blank lines", "\n0,0\n\n1,0\n,\n2,-1\n\n\n"),
    ("windows", GOOD.replace("\n", "\r\n")),
    ("town03", GOOD.replace("\n", "\r\r\n")),
    ("old mac", GOOD.replace("\n", "\r")),
    ("no last line end", GOOD.rstrip()),
    ("spaces", " 0 , 0 \n 1,0\n2 ,-1\n"),
    ("byte order mark", "\ufeff" + GOOD),
    ("exponents", "0e0,0\n1.0E0,0\n.2e1,-1\n"),
]

IN_METRES, DELETE = "; write it with a decimal point, in a local frame", "; delete one of them"
TWO = "at least 2; add rows of x,y in metres"
ROUND = "with a radius of 4 m, or delete the rows that lead back"
COMMA, COLUMNS = "; write x,y with a comma", "; move them to columns 1 and 2"
# Name, content, parts of the message, and its end.
REFUSED = [
    ("empty", "", ["0 waypoint(s)"], TWO),
    ("one point", "1,2\n", ["1 waypoint(s)"], TWO),
    ("header alone", "x,y\n", ["0 waypoint(s)"], TWO),
    ("word", "0,0\n1,zero\n2,0\n", ["row 2", "y is 'zero'", "not a number"], IN_METRES),
    ("word in the first row", "0,zero\n1,0\n", ["row 1", "y is 'zero'"], IN_METRES),
    ("second header", "x,y\nx,y\n0,0\n1,0\n", ["row 2", "x is 'x'"], IN_METRES),
    ("header below a point", "0,0\nx,y\n1,0\n", ["row 2", "x is 'x'"], IN_METRES),
    ("empty field", "0,0\n1,\n2,0\n", ["row 2", "y is ''"], IN_METRES),
    ("NaN", "0,0\nnan,0\n2,0\n", ["row 2", "x is 'nan'"], IN_METRES),
    ("infinity", "0,0\n0,-inf\n", ["row 2", "y is '-inf'"], IN_METRES),
    ("one column", "0,0\n1\n2,0\n", ["row 2", "one column ('1')"], COMMA),
    ("semicolons", "0;0\n1;0\n", ["row 2", "one column ('1;0')"], COMMA),
    ("repeated point", "0,0\n\n1,1\n1,1\n2,2\n", ["row 4", "point of row 3"], DELETE),
    ("late repeated point", "0,0\n1,0\n2,0\n\n2,0\n", ["row 5", "point of row 3"], DELETE),
    ("turned back", "0,0\n5,0\n10,0\n6,1\n", ["row 3", "by 166 degrees within 4 m"], ROUND),
    ("rows led back", "0,0\n1,0\n2,0\n3,0\n1,0\n2,0\n3,0\n", ["row 4", "by 180 degrees"], ROUND),
    ("swapped header", "y,x\n0,0\n1,0\n", ["row 1", "x in column 2 and y in column 1"], COLUMNS),
    ("quoted swapped header", '"Y","X"\n0,0\n1,0\n', ["row 1", "x in column 2"], COLUMNS),
    ("time in front", "time,x,y\n0,0,0\n1,0,1\n", ["x in column 2 and y in column 3"], COLUMNS),
    ("road network", '<?xml version="1.0"?>\n<OpenDRIVE>', ["not a route"], "CSV file of x,y"),
    ("far away", "0,0\n1e30,0\n", ["row 2", "metres up to 100000"], IN_METRES),
    ("row counted over town03 ends", "0,0\r\r\n1,0\r\r\nword,0\r\r\n", ["row 3"], IN_METRES),
]


@pytest.fixture
def write(tmp_path):
    def write_file(text):
        path = tmp_path / "route.csv"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return str(path)

    return write_file


@pytest.mark.parametrize("text", [row[1] for row in ACCEPTED], ids=[row[0] for row in ACCEPTED])
def test_well_formed_file_is_accepted(write, text):
    np.testing.assert_array_equal(load_waypoints(write(text)), ROUTE)


@pytest.mark.parametrize(
    ("text", "parts", "end"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED]
)
def test_bad_file_is_refused_in_one_line_that_names_file_and_row(write, text, parts, end):
    path = write(text)
    with pytest.raises(WaypointError) as caught:
        load_waypoints(path)
    message = str(caught.value)
    assert "\n" not in message
    for part in [path, *parts]:
        assert part in message
    assert message.endswith(end)


@pytest.mark.parametrize(
    ("name", "reason"), [("none.csv", "No such file or directory"), ("", "Is a directory")]
)
def test_file_that_cannot_be_read_is_refused(tmp_path, name, reason):
    path = tmp_path / name
    with pytest.raises(WaypointError) as caught:
        load_waypoints(str(path))
    assert str(caught.value).startswith(f"{path}: the file cannot be read ({reason}); ")
    assert str(caught.value).endswith("set waypoints_path to a readable CSV file")


def test_missing_name_is_refused():
    with pytest.raises(WaypointError, match="^waypoints_path is empty; .* a CSV file of x,y$"):
        load_waypoints("")


def test_binary_file_is_refused(write):
    with pytest.raises(WaypointError, match="not text .byte 0"):
        load_waypoints(write(b"\x89PNG\r\n\x1a\n\xff\xfe"))


def test_command_line_prints_the_length_of_a_route(write, monkeypatch, capsys):
    path = write("0,0\n3,4\n6,8\n6,20\n")
    monkeypatch.setattr(sys, "argv", ["waypoint_file", path])
    assert main() == 0
    assert capsys.readouterr() == (f"{path}: 4 waypoints, 22.0 m\n", "")


@pytest.mark.parametrize(
    ("arguments", "start"), [([], "waypoints_path is empty"), (["none.csv"], "none.csv: the file")]
)
def test_command_line_prints_the_mistake_and_returns_1(monkeypatch, capsys, arguments, start):
    monkeypatch.setattr(sys, "argv", ["waypoint_file", *arguments])
    assert main() == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith(start)
    assert printed.err.count("\n") == 1


NUMBERS = (
    st.floats().map(repr)
    | st.floats(-1e4, 1e4).map("{:.3f}".format)
    | st.sampled_from(["", "nan", "-inf", "1e400", "0x10", "1_0", "x", "٣"])
)
ROWS = st.lists(NUMBERS, max_size=4).map(",".join)
FILES = (
    st.binary(max_size=200)
    | st.text('0123456789.,-+einfax#\r\n "', max_size=200).map(str.encode)
    | st.lists(ROWS, max_size=12).map("\n".join).map(str.encode)
)


@pytest.mark.slow(3)
@settings(max_examples=max(200, settings.default.max_examples))
@given(FILES)
def test_fuzz_any_bytes_are_a_route_or_one_clear_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "fuzz.csv"
    path.write_bytes(content)
    try:
        route = load_waypoints(str(path))
    except WaypointError as error:
        assert str(path) in str(error)
        assert "\n" not in str(error)
    else:
        assert route.ndim == 2
        assert route.shape[1] == 2
        assert len(route) >= 2
        assert np.isfinite(route).all()
        assert (np.hypot(*np.diff(route, axis=0).T) > 0.0).all()
