"""A page chooses arguments of ./drive from a fixed list."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_cockpit.drive_arguments import drive_arguments, form_fields

SCENARIOS = ["oval", "town"]
VALUES = st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=20)
VALUES |= st.sampled_from(["stanley", "$(eval 1)", "my_module:MySteering", "1 --screen"])
VALUES |= st.lists(st.integers(), max_size=2)
NAMES = st.sampled_from([*form_fields(), "stack"])


def test_chosen_values_become_arguments():
    values = {"sync": True, "camera": False, "steering_method": "lqr", "planned_speed_mps": 7.5}
    values.update(friction=0.6, seed=7)
    words = "scenario:=oval sync:=true camera:=false steering_method:=lqr planned_speed_mps:=7.5"
    expected = [*words.split(), "seed:=7", 'sim_options:={"friction": 0.6}']
    assert drive_arguments("oval", values, SCENARIOS) == expected
    assert drive_arguments("", {}, SCENARIOS) == []


@pytest.mark.parametrize(
    ("scenario", "values", "expected"),
    [
        ("../town", {}, "'scenario' is '../town'; .*(use one of oval, town|town)"),
        ("", {"stack": "/tmp/evil.launch"}, "unknown key 'stack'"),
        ("", {"steering_method": "my_module:MySteering"}, "'steering_method' is 'my_module"),
        ("", {"sync": "true"}, "'sync' must be true or false"),
        ("", {"friction": 0}, "'friction' must be a number from 0.05 to 2"),
        ("", {"planned_speed_mps": "$(eval 1)"}, "'planned_speed_mps' must be a number"),
        ("", {"seed": 1.5}, "'seed' must be a whole number"),
    ],
)
def test_value_that_is_not_on_the_list_is_refused(scenario, values, expected):
    with pytest.raises(ValueError, match=expected):
        drive_arguments(scenario, values, SCENARIOS)


@given(st.sampled_from(["", "town"]) | st.text(max_size=8), st.dictionaries(NAMES, VALUES))
def test_fuzz_arguments_have_no_character_that_roslaunch_evaluates(scenario, values):
    try:
        arguments = drive_arguments(scenario, values, SCENARIOS)
    except ValueError as error:
        assert str(error)
        return
    for argument in arguments:
        name, separator, value = argument.partition(":=")
        assert name.isidentifier() and separator
        assert not set(value) & set("$()!;&|\n")
