"""Drives in traffic with the solution, and with drivers who lack a part of it."""

import numpy as np
import pytest

from sdc_behaviour import driver
from sdc_behaviour.drives import SCENES, drive_scene
from sdc_behaviour.manoeuvre import LaneProposal
from sdc_behaviour.rss import Rss
from sdc_behaviour.study.experiments import crashes, flow_per_h, lines, polite

# What the check of behaviour-8 demands [m/s].
LEAST_MPS = {"lorry": 9.0, "brake": 5.0, "crossing": 5.0}


@pytest.mark.slow(4)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("seed", (1, 2, 9500))
def test_drive_is_safe_and_not_too_slow(name, seed):
    driven = drive_scene(name, seed)
    assert (driven.collisions, driven.taken) == (0, 0)
    assert driven.mean_mps > LEAST_MPS[name]
    assert driven.pushed_mps2 < 4.0


@pytest.mark.slow(2)
def test_drive_is_repeatable():
    assert np.array_equal(drive_scene("lorry", 2).rows, drive_scene("lorry", 2).rows)


def test_driver_who_looks_at_no_one_takes_the_right_of_way(monkeypatch):
    monkeypatch.setattr(driver, "may_enter", lambda *_: True)
    drives = [drive_scene("crossing", seed) for seed in (4, 5, 6)]
    assert all(one.taken + one.collisions for one in drives)


def test_driver_who_never_overtakes_is_slow():
    assert drive_scene("lorry", 1, lambda scene: LaneProposal(0, 14.0)).mean_mps < 9.0


def test_driver_who_sees_no_one_ahead_collides():
    blind = Rss(0.0, 1.8, 1e6, 1e-6)
    assert drive_scene("brake", 1, lambda scene: LaneProposal(0, 30.0), rss=blind).collisions == 1


@pytest.mark.nightly
def test_rude_lane_changes_make_others_brake():
    means_mps, hardest_mps2 = zip(*map(polite, (0.0, 4.0)))
    assert means_mps[0] > 1.03 * means_mps[1]
    assert hardest_mps2[0] > hardest_mps2[1] + 2.0


def test_late_drivers_crash_at_a_distance_that_is_safe_for_others():
    assert [crashes(late_s, Rss()) for late_s in (0.3, 0.5, 1.0)] == [0, 1, 9]
    assert crashes(1.0, Rss(response_s=1.0)) == 0
    assert flow_per_h(14.0, Rss()) > 1.7 * flow_per_h(14.0, Rss(response_s=1.0))
    assert len(list(lines("late"))) == 6
