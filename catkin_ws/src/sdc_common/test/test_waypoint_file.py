import math
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
    ("semicolons", GOOD.replace(",", ";")),
    ("tabs", "x\ty\n" + GOOD.replace(",", "\t")),
    ("blanks", "0 0  7\n 1  0 7\n2 -1 7\n"),
    ("decimal commas", "x;y\r\n0,0;0,0\r\n1,0;0\r\n2;-1,0\r\n"),
    ("quoted numbers", '"0","0"\n"1","0"\n"2","-1"\n'),
    ("comma in a quoted text", '"0","0","a, b"\n1,0,c\n2,-1,d\n'),
    ("swapped header", "y,x\n0,0\n0,1\n-1,2\n"),
    ("time in front", "time [s],X [m],Y [m]\n0,0,0\n5,1,0\n7,2,-1\n"),
    ("PlotJuggler", "__time,/odom/pose/position/x,/odom/pose/position/y\n0,0,0\n5,1,0\n7,2,-1\n"),
    ("raceline", "# 1f0a\n# s_m; x_m; y_m; v_mps\n0; 0; 0; 8\n1; 1; 0; 8\n2.4; 2; -1; 8\n"),
    ("centre line", "# x_m,y_m,w_tr_right_m,w_tr_left_m\n0,0,1,1\n1,0,1,1\n2,-1,1,1\n"),
    ("header in blanks", "# x z y\n0,9,0\n1,9,0\n2,9,-1\n"),
    (
        "rostopic echo -p",
        "%time,field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.orientation.x\n"
        "17,0,0,0\n18,1,0,0\n19,2,-1,0\n",
    ),
    ("degrees beside metres", "lat,lon,posX,posY\n58.1,26.1,0,0\n58.1,26.1,1,0\n58.1,26.1,2,-1\n"),
    ("prose with commas", "# right is y, forward is x\n" + GOOD),
    ("height in the second column", "x,height,y\n0,5,0\n1,5,0\n2,5,-1\n"),
    ("distance in the third column", "0,0,0\n1,0,1\n2,-1,2.4142\n"),
]

IN_METRES, DELETE = "; write it with a decimal point, in a local frame", "; delete one of them"
TWO = "at least 2; add rows of x,y in metres"
ROUND = "; check the order of rows and columns, or round the turn with a radius of 4 m"
COMMA = "; write x,y with a comma"
DECIMALS = "a decimal point and without thousands separators"
LOCAL = "convert them to metres in a local frame"
CONVERT = "; convert them to metres in a local frame, y to the right of x"
NAME_THEM = "; name them, in metres, y to the right of x"
FIRST_LINE = "; name the columns in the first line, in this way or as x,y,z"
CIRCLE = [(20.0 * math.sin(0.2 * i), 20.0 * math.cos(0.2 * i)) for i in range(30)]
HEIGHTS = "".join(f"{x},{1.0 + 0.1 * (i % 5)},{y}\n" for i, (x, y) in enumerate(CIRCLE))
DISTANCES = "".join(f"{3.9933 * i:.3f};{x:.3f};{y:.3f}\n" for i, (x, y) in enumerate(CIRCLE))
NUMBERS = "".join(f"{i},{x:.3f},{y:.3f}\n" for i, (x, y) in enumerate(CIRCLE))
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
    ("repeated point", "0,0\n\n1,1\n1,1\n2,2\n", ["row 4", "point of row 3"], DELETE),
    ("late repeated point", "0,0\n1,0\n2,0\n\n2,0\n", ["row 5", "point of row 3"], DELETE),
    ("turned back", "0,0\n5,0\n10,0\n6,1\n", ["row 3", "by 166 degrees within 4 m"], ROUND),
    ("rows led back", "0,0\n1,0\n2,0\n3,0\n1,0\n2,0\n3,0\n", ["row 4", "by 180 degrees"], ROUND),
    (
        "decimal commas",
        "0,50,1,05\n1,75,1,10\n",
        ["'1,05' is a number with a decimal comma"],
        DECIMALS,
    ),
    ("two names, four columns", "x,y\n0,5,1,5\n1,5,1,5\n", ["row 2", "2 are expected"], DECIMALS),
    ("thousands", "1,001.5,2,000.5\n999.5,2,000.5\n", ["row 2", "4 are expected"], DECIMALS),
    ("quoted thousands", '"1,201","2"\n"999","2"\n', ["row 1", "x is '1,201'"], IN_METRES),
    ("commas and points", "1,001;2\n999.5;2\n", ["commas and points"], DECIMALS),
    ("GPS", "lat,lon\n58.1,26.1\n58.2,26.1\n", ["row 1", "'lat' and 'lon' are degrees"], CONVERT),
    ("exported GPS", '"time";"Longitude";"Latitude";"ele"\n1;26,1;58,1;9\n', ["row 1"], CONVERT),
    ("degrees in a comment", "# gps_lat gps_lon\n58.1 26.1\n58.2 26.1\n", ["row 1"], CONVERT),
    ("degrees without header", "58.10,26.1\n58.11,26.1\n58.11,26.1\n", ["within 1 m"], LOCAL),
    ("centimetres", "x_cm,y_cm\n0,0\n100,0\n", ["row 1", "'x_cm' and 'y_cm'"], CONVERT),
    ("other columns", "time,speed\n0,0\n1,0\n", ["row 1", "'time, speed'"], NAME_THEM),
    ("two lines", "x1,y1,x2,y2\n0,0,0,5\n1,0,1,5\n", ["row 1"], NAME_THEM),
    ("height of a flat road", "0,0,0\n1,0,0\n2,0,-1\n", ["0.0 in all", "as in x,z,y"], FIRST_LINE),
    ("height of a hilly road", HEIGHTS, ["column 2 varies by 0.4", "as in x,z,y"], FIRST_LINE),
    ("distance in the first column", DISTANCES, ["as in s,x,y"], FIRST_LINE),
    ("number of the row in the first column", NUMBERS, ["as in s,x,y or t,x,y"], FIRST_LINE),
    ("GPX", '<?xml version="1.0"?>\n<gpx>', ["XML or JSON, not a route"], "CSV file of x,y"),
    ("road network", '<?xml version="1.0"?>\n<OpenDRIVE>', ["(OpenDRIVE)"], "CSV file of x,y"),
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


def test_binary_file_is_refused(write):
    with pytest.raises(WaypointError, match="not text .byte 0"):
        load_waypoints(write(b"\x89PNG\r\n\x1a\n\xff\xfe"))


def test_command_line_prints_the_length_of_a_route(write, monkeypatch, capsys):
    path = write("0,0\n3,4\n6,8\n6,20\n")
    monkeypatch.setattr(sys, "argv", ["waypoint_file", path])
    assert main() == 0
    assert capsys.readouterr() == (f"{path}: 4 waypoints, 22.0 m\n", "")


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        ([], "waypoints_path is empty; set it to a CSV file of x,y"),
        (["no.csv"], "no.csv: the file"),
    ],
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
