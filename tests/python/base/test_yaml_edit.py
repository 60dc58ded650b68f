"""Edits of a YAML text change the values that they name, and nothing else: comments, order and styles stay."""

import pytest
from ruamel.yaml import YAML

from uwsim.base.texts.yaml_edit import Place, with_values

TEXT = """# A vehicle.
mass_kg: 11.2   # weighed
speed: 3

drag: [1.0, 2.0,   # ahead and across
  3.0]
added:
  - [5, 0]
  - [0, 6.5]
thrusters:
  port: {model: "t#200", gain: 1.5}
  stern:   # behind
    model: t100
"""
PLACES: dict[Place, str] = {
    ("mass_kg",): "12",
    ("speed",): "4",
    ("drag", 1): "2.5",
    ("drag", 2): "3.5",
    ("added", 1, 1): "7",
    ("thrusters", "port", "gain"): "1.6",
    ("thrusters", "port", "lag"): "0.1",
    ("thrusters", "stern", "gain"): "0.9",
}
EDITED = """# A vehicle.
mass_kg: 12   # 1, not 'weighed'
speed: 4   # 1, not ''

drag: [1.0, 2.5,   # 1, besides 'ahead and across'
  3.5]   # 1, not ''
added:
  - [5, 0]
  - [0, 7]   # 1, not ''
thrusters:
  port: {lag: 0.1, model: "t#200", gain: 1.6}   # 2, not ''
  stern:   # behind
    gain: 0.9   # 1, not ''
    model: t100
"""


def remark(places: list[Place], old: str, keeps_others: bool) -> str:
    return f"{len(places)}, {'besides' if keeps_others else 'not'} '{old}'"


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_only_the_named_values_and_their_comments_change(newline: str) -> None:
    text = TEXT.replace("\n", newline)
    if newline == "\n":
        assert with_values(text, "a.yaml", PLACES, remark) == EDITED
    expected = YAML(typ="safe").load(TEXT)
    for place, value in PLACES.items():
        part = expected
        for key in place[:-1]:
            part = part[key]
        part[place[-1]] = float(value)
    assert YAML(typ="safe").load(with_values(text, "a.yaml", PLACES, remark)) == expected
    assert with_values(text, "a.yaml", {}) == text


def test_a_value_that_an_alias_shares_is_replaced_once() -> None:
    text = "a: &a {gain: 1}\nb: *a   # the same\n"
    places: dict[Place, str] = {("a", "gain"): "2", ("b", "gain"): "2"}
    assert with_values(text, "a.yaml", places) == "a: &a {gain: 2}\nb: *a   # the same\n"


def test_a_place_that_is_not_written_is_refused() -> None:
    with pytest.raises(ValueError, match=r"a\.yaml: drag\[0\]\[1\]: is not written there"):
        with_values(TEXT, "a.yaml", {("drag", 0, 1): "2"})
