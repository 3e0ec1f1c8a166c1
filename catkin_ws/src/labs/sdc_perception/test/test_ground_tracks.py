"""Tracks of what is on the ground."""

import pytest

from sdc_perception.ground_tracks import GroundTracks, TrackSettings
from sdc_perception.light_detection import SeenLight

SETTINGS = TrackSettings(confirm=2, lost_s=0.5, drift_m=0.0, acceleration_mps2=2.0, start_mps=4.0)
STILL = (0.0, 0.0, 0.0)


@pytest.fixture
def tracks():
    return GroundTracks(SETTINGS)


def sighting(x_m, y_m, state=0):
    return SeenLight(state, x_m, y_m, 0.2, (), None)


def test_track_counts_from_the_second_sighting_on(tracks):
    assert tracks.update([sighting(10.0, 0.0)], STILL, 0.0) == []
    assert len(tracks.update([sighting(10.0, 0.0)], STILL, 0.05)) == 1


def test_track_ends_when_it_is_not_seen(tracks):
    for time_s in (0.0, 0.05, 0.1):
        tracks.update([sighting(10.0, 0.0)], STILL, time_s)
    assert len(tracks.update([], STILL, 0.5)) == 1
    assert tracks.update([], STILL, 0.7) == []


def test_two_things_next_to_each_other_keep_their_tracks(tracks):
    for number in range(20):
        seen = [sighting(12.0, 1.5, 1), sighting(12.0, -1.5, 2)]
        found = tracks.update(seen[:: -1 if number % 2 else 1], STILL, 0.05 * number)
    assert sorted((round(track.state[1], 1), track.seen.state) for track in found) == [
        (-1.5, 2),
        (1.5, 1),
    ]


def test_tracks_begin_again_with_the_clock(tracks):
    for time_s in (10.0, 10.05):
        tracks.update([sighting(10.0, 0.0)], STILL, time_s)
    assert tracks.update([sighting(10.0, 0.0)], STILL, 0.0) == []
