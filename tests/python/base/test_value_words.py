"""Values in words."""

import math

import pytest

from uwsim.base.texts.value_words import details, with_details, words


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"kind": "current", "name": "current", "velocity_world_m_s": [0.1, 0, 0], "for_s": 5.0},
         "kind current, velocity (0.1, 0, 0) m/s, for 5 s"),
        ({"elevation_rad": -math.pi / 6, "sonar": None}, "elevation -30 deg"),
        ({"lamp": "front", "on": False}, "lamp front, off"),
        ({"changes": {"rov.mass_kg": 3, "hull": {"on": True}}}, "changes rov.mass 3 kg, hull on"),
        ({"payload": b"1", "topic": ""}, ""),
    ],
)  # fmt: skip
def test_no_unit_is_part_of_a_name_and_no_value_is_json(values, said):
    assert ", ".join(map(str, details(values))) == said


def test_a_value_that_changed_is_given_first_and_last():
    found = details({"elevation_rad": 0.0, "on": True}, {"elevation_rad": math.pi / 2, "on": True})
    assert with_details(words("set_lamp"), found) == "set lamp: elevation 0 to 90 deg, on"
