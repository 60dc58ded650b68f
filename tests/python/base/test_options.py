"""Options: one dataclass is flags, help, rules and the error for an option without effect; and values in words."""

import math
import re
from dataclasses import dataclass

import pytest

from uwsim.base.options import Flag, OptionError, Options, WithoutEffectError, option
from uwsim.base.texts.value_words import details, with_details, words


@dataclass(frozen=True)
class Rig(Options):
    switch = "rig"

    rig: bool = option(False, "Carry a rig.")
    rig_mass: float | None = option(None, "Its mass [kg].", bounds=(0.1, 10, "kg"))
    rig_colour: str | None = option(None, "Its colour.", choices=("red", "blue"))
    rig_part: tuple[str, ...] = option((), "A part; may be repeated.", metavar="PART", choices=("arm", "leg"))
    rig_count: int = option(1, "How many.")


def test_each_field_is_a_flag() -> None:
    part = Flag(tuple[str, ...], (), "A part; may be repeated.", ("arm", "leg"), None, "PART")
    assert list(Rig.flags()) == ["rig", "rig_mass", "rig_colour", "rig_part", "rig_count"]
    assert Rig.flags()["rig_mass"] == Flag(float | None, None, "Its mass [kg].", bounds=(0.1, 10, "kg"))
    assert Rig.flags()["rig_part"] == part
    given = Rig(rig=True, rig_count=0).given()
    assert [name for name, is_given in given.items() if is_given] == ["rig", "rig_count"]


def test_a_value_that_breaks_its_rule_is_refused() -> None:
    for values, message in (
        ({"rig_mass": 11.0}, "--rig-mass = 11.0 kg: must be in [0.1, 10] kg"),
        ({"rig_mass": float("nan")}, "--rig-mass = nan kg"),
        ({"rig_colour": "rod"}, "--rig-colour = 'rod': must be one of red, blue; did you mean 'red'?"),
        ({"rig_part": ("arm", "tail")}, "--rig-part = 'tail': must be one of arm, leg"),
    ):
        with pytest.raises(OptionError, match=re.escape(message)):
            Rig(rig=True, **values)  # type: ignore[arg-type]


def test_an_option_without_its_switch_is_refused() -> None:
    assert not Rig().is_requested and Rig(rig=True, rig_count=2).is_requested
    with pytest.raises(WithoutEffectError, match="--rig-mass, --rig-count: need --rig"):
        Rig(rig_mass=1.0, rig_count=2)
    with pytest.raises(WithoutEffectError, match="--rig-count: needs --rig"):
        Rig(rig_count=0)
    with pytest.raises(WithoutEffectError, match="--rig-part: needs --rig"):
        Rig(rig_part=("arm",))


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
