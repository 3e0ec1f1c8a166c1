"""Tests of the messages for RViz."""

import numpy as np
import pytest
from visualization_msgs.msg import Marker

from sdc_sim.road.road import Road
from sdc_sim.road.road_markings import road_markings
from sdc_sim.ros.rviz_markers import car_markers, path_marker, road_markers, route_path

STRAIGHT = np.column_stack([np.arange(0.0, 101.0), np.zeros(101)])


def test_route_path_has_all_points_in_the_map_frame():
    path = route_path(STRAIGHT)
    assert path.header.frame_id == "map"
    assert [pose.pose.position.x for pose in path.poses] == STRAIGHT[:, 0].tolist()
    assert {pose.pose.orientation.w for pose in path.poses} == {1.0}


def test_local_path_is_coloured_by_speed():
    marker = path_marker([(0.0, 1.0, 10.0), (1.0, 1.0, 5.0), (2.0, 1.0, 0.0)], 10.0)
    assert (marker.header.frame_id, marker.type, marker.action) == (
        "map",
        Marker.LINE_STRIP,
        Marker.ADD,
    )
    assert [(point.x, point.y) for point in marker.points] == [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0)]
    assert len(marker.colors) == 3
    assert marker.colors[0].g > marker.colors[0].r and marker.colors[2].r > marker.colors[2].g


def test_road_consists_of_triangles_and_lines():
    markings = road_markings(Road(STRAIGHT))
    grass, asphalt, lines = road_markers(markings).markers
    assert len(grass.points) == 6 and min(point.x for point in grass.points) < -100.0
    assert grass.points[0].z < asphalt.points[0].z < lines.points[0].z
    assert asphalt.type == Marker.TRIANGLE_LIST and len(asphalt.points) == 6 * len(
        markings.surface
    ) == 3 * len(asphalt.colors)
    assert lines.type == Marker.LINE_LIST and len(lines.points) == 2 * (
        len(markings.edges) + len(markings.dashes)
    )


def test_car_has_real_size_and_is_locked_to_its_frame():
    markers = car_markers().markers
    assert len({(marker.ns, marker.id) for marker in markers}) == len(markers)
    assert {(marker.header.frame_id, marker.frame_locked) for marker in markers} == {
        ("ego_vehicle", True)
    }
    ends = [
        (
            marker.pose.position.x - 0.5 * marker.scale.x,
            marker.pose.position.x + 0.5 * marker.scale.x,
        )
        for marker in markers
    ]
    assert max(end for _, end in ends) - min(start for start, _ in ends) == pytest.approx(
        4.72, abs=0.05
    )
    assert all(0.0 <= marker.pose.position.z < 1.5 for marker in markers)
