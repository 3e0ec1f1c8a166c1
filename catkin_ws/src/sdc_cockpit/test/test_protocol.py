"""Messages of the page, and the arguments of ./drive in them: all values are checked."""

import contextlib
import json
import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from page_messages import read_picture

from sdc_cockpit import protocol
from sdc_cockpit.drive_arguments import drive_arguments, form_fields
from sdc_cockpit.protocol import read_message
from sdc_sim.manual_control import keyboard

MESSAGES = protocol.page_schemas()["messages"]
VALID = [
    *(f'{{"type":"{name}"}}' for name, fields in MESSAGES.items() if not fields),
    '{"type":"keys","held":["w","space","left"]}',
    '{"type":"pedals","throttle":0.5,"steer":-1,"brake":0}',
    '{"type":"obstacle","x":3,"y":-2.5}',
    '{"type":"goal","x":3,"y":-2.5}',
    '{"type":"drawn","picture":7}',
    '{"type":"show","mask":true}',
    '{"type":"set","name":"/sim/friction","value":0.5}',
    '{"type":"start","scenario":"oval","arguments":{"sync":true,"friction":0.6}}',
]
PIECES = [*'{}[]",:.-0123456789eE', "NaN", "Infinity", "1e999", "null", "true", "\\ud800", "\x00"]
PIECES.append("[" * 50)
MESSAGES_PER_EXAMPLE = 1000


def check(text):
    """Read a message; it is valid, or refused with a text."""
    try:
        message = read_message(text)
    except ValueError as error:
        assert str(error)
        return
    for value in message.values.values():
        if isinstance(value, float):
            assert math.isfinite(value)
    if message.kind == "start":
        with contextlib.suppress(ValueError):
            drive_arguments(*message.values.values(), ["oval"])


def damaged(chance):
    """Return a valid message with some of its characters replaced, removed or added."""
    text = chance.choice(VALID)
    for _ in range(chance.randint(1, 4)):
        start = chance.randint(0, len(text))
        end = min(len(text), start + chance.randint(0, 6))
        text = text[:start] + chance.choice(["", *PIECES, chance.choice(VALID)]) + text[end:]
    return text.encode() if chance.random() < 0.05 else text


@settings(max_examples=10)
@given(st.integers(0, 2**32))
def test_fuzz_ten_thousand_damaged_messages_are_valid_or_refused(seed):
    chance = random.Random(seed)
    for _ in range(MESSAGES_PER_EXAMPLE):
        check(damaged(chance))


@pytest.mark.parametrize("text", VALID)
def test_messages_are_read(text):
    kind, values = read_message(text)
    assert {"type": kind, **values} == json.loads(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"type":"exec","code":"1"}', "unknown type 'exec'"),
        ('{"type":"drive","viewer":2}', "unknown key 'viewer'"),
        ('{"type":"obstacle","x":1}', "key 'y' is missing"),
        ('{"type":"obstacle","x":1,"y":1e300}', "'y' must be a number from"),
        ('{"type":"obstacle","x":NaN,"y":1}', "'x' must be a number from"),
        ('{"type":"keys","held":["__import__"]}', "entry 1 of 'held' is '__import__'; use one of"),
        ('{"type":"pedals","throttle":2,"steer":0,"brake":0}', "'throttle' must be a number from"),
        ('{"type":"drawn","picture":true}', "'picture' must be a whole number"),
        ('{"type":"set","name":1,"value":1}', "'name' must be the name of a parameter"),
        ('{"type":"set","name":"/sim/friction","value":"1"}', "'value' must be a number"),
        ('{"type":"start","scenario":1,"arguments":{}}', "'scenario' must be a name"),
        ('{"type":"start","scenario":"","arguments":[]}', "'arguments' must be a mapping"),
        *(("[]", "a message is a JSON object"), (b"{}", "a page sends text"), ("[" * 4000, "")),
        (" " * 5000, "at most 4096 characters"),
    ],
)
def test_wrong_message_is_refused(text, expected):
    with pytest.raises(ValueError, match=expected.replace("(", r"\(")):
        read_message(text)


def test_picture_keeps_its_values():
    message = protocol.picture_message(protocol.CAMERA, 5, 1.25, 9.5, b"file")
    assert read_picture(message) == (protocol.CAMERA, 5, 1.25, 9.5, b"file")


def test_json_without_a_finite_number_is_an_error():
    with pytest.raises(ValueError, match="JSON compliant"):
        protocol.json_message("state", speed=math.nan)


def test_text_with_half_of_a_character_is_sent():
    assert b"?" in protocol.json_message("log", text="\udcff")


def test_page_may_hold_the_keys_that_drive():
    actions = "throttle", "brake", "left", "right", "hand_brake"
    driving = {key for key, action in keyboard.ACTIONS.items() if action in actions}
    assert set(MESSAGES["keys"]["held"]["items"]["enum"]) == driving


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
