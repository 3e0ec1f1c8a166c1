"""Tests of the record of what was around the car."""

import pytest

from sdc_sim.evaluation.scene_record import INTERVAL_S, LIGHTS, PATH, SceneRecord


def record(keep=True):
    record = SceneRecord(keep)
    record.add(PATH, 10.0, "first")
    return record


@pytest.mark.parametrize(
    ("time_s", "due"),
    [(10.0, False), (10.0 + INTERVAL_S - 0.01, False), (10.0 + INTERVAL_S, True), (9.99, True)],
)
def test_an_entry_is_due_after_the_interval_or_when_time_goes_back(time_s, due):
    assert record().is_due(PATH, time_s) is due


def test_the_first_entry_of_each_kind_is_due_and_new():
    assert (record().is_due(LIGHTS, 10.0), record().is_new(LIGHTS, "first")) == (True, True)


def test_only_other_content_than_that_of_the_last_entry_is_new():
    found = record()
    assert (found.is_new(PATH, "first"), found.is_new(PATH, "second")) == (False, True)
    found.add(PATH, 11.0, "second")
    assert (found.is_new(PATH, "first"), found.is_new(PATH, "second")) == (True, False)


@pytest.mark.parametrize(
    ("keep", "entries"), [(True, [(10.0, "first"), (11.0, "second")]), (False, [(11.0, "second")])]
)
def test_entries_before_the_last_are_kept_only_on_request(keep, entries):
    found = record(keep)
    found.add(PATH, 11.0, "second")
    assert found.entries == {PATH: entries}
