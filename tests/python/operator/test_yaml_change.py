"""Changes of a YAML text: only the lines of what changes differ, and the text then holds what was asked for."""

from __future__ import annotations

import pytest

from uwsim.base.texts.yaml_parser import plain_values
from uwsim.operator.station.editor.yaml_change import flow, with_value, without

TEXT = """\
a: 1                # one
list:
  # above the first
  - kind: x         # of a kind
    size: [1, 2]
  - {kind: y}
  - - 1
flat: {b: [1, 2], c: null}
empty: []
text: >-
  folded
  lines
none:
# the end
"""


@pytest.mark.parametrize(
    ("place", "value", "expected"),
    [
        (("a",), 2.5, "a: 2.5                # one\n"),
        (("list", 0, "size", 1), -3, "    size: [1, -3]\n"),
        (("list", 0, "size"), [1, 2, 3], "    size: [1, 2, 3]\n"),
        (("list", 0, "colour"), {"r": 1.0}, "    size: [1, 2]\n    colour: {r: 1}\n  - {kind: y}\n"),
        (("list", 1, "on"), True, "  - {kind: y, on: true}\n"),
        (("list", 3), {"kind": "z", "at": [1e-7]}, "  - - 1\n  - kind: z\n    at: [1.0e-07]\nflat:"),
        (("flat", "b"), [], "flat: {b: [], c: null}\n"),
        (("flat", "d", "e"), "x: y", 'flat: {b: [1, 2], c: null, d: {e: "x: y"}}\n'),
        (("flat", "f"), "long " * 16 + "text", f"flat:\n  b: [1, 2]\n  c: null\n  f: {'long ' * 16}text\nempty"),
        (("empty", 0), {"k": "v"}, "empty:\n  - k: v\n"),
        (("none",), "off", 'none: "off"\n'),
        (("new", "deep", 0), {"k": {"l": {"m": 1}}}, "new:\n  deep:\n    - k:\n        l: {m: 1}\n# the end\n"),
    ],
)
def test_a_value_is_set_and_all_else_stays(place, value, expected) -> None:
    changed = with_value(TEXT, "t", place, value)
    assert expected in changed
    found = plain_values(changed, "t")
    for key in place:
        found = found[key]
    assert found == value
    kept = [line for line in TEXT.splitlines() if line in changed.splitlines()]
    assert len(kept) >= len(TEXT.splitlines()) - 1
    for newline in ("\r\n", "\n"):
        text = with_value(TEXT.replace("\n", newline), "t", place, value)
        assert text == changed.replace("\n", newline)


def test_a_value_is_removed_with_its_lines() -> None:
    for place, gone in (
        (("a",), ["a: 1                # one"]),
        (("list", 0), ["  - kind: x         # of a kind", "    size: [1, 2]"]),
        (("list", 0, "size"), ["    size: [1, 2]"]),
        (("list", 1), ["  - {kind: y}"]),
        (("list", 1, "kind"), ["  - {kind: y}"]),
        (("list", 2, 0), ["  - - 1"]),
        (("text",), ["text: >-", "  folded", "  lines"]),
        (("none",), ["none:"]),
    ):
        assert [line for line in TEXT.splitlines() if line not in gone] == without(TEXT, "t", place).splitlines()


def test_what_cannot_be_changed_alone_is_refused() -> None:
    for text, place in (
        ("a: &x {k: 1}\nb: *x\n", ("b", "k")),
        ("a: &x {k: 1}\nb:\n  <<: *x\n", ("b", "k")),
        ("a: 1\n", ("a", "b", "c")),
        ("a: [1]\n", ("a", 5)),
        ("a: text\n", ("a", 0)),
    ):
        with pytest.raises(ValueError, match=r"^t: [ab]"):
            with_value(text, "t", place, 2)
    with pytest.raises(ValueError, match=r"^t: a\[0\]: is not written there"):
        without("a: text\nb: 1\n", "t", ("a", 0))
    assert without("a: 1\n? b\n: 2\n", "t", ("b",)) == "a: 1\n"


def test_flow_text_reads_back() -> None:
    for value in (None, True, 0, -1.5, 1e300, "no", "1", "a b", "", "~", "ä", [[]], {"a": [{"b": None}]}):
        assert plain_values(f"v: {flow(value)}", "t")["v"] == value
