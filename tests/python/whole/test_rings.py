"""The heart imports no add-on, an add-on only those that it needs, and modules import each other in one direction."""

import tomllib
from functools import cache
from itertools import pairwise

import pytest
from tools import module_graph
from tools.assets.make_architecture_picture import PICTURE, picture
from tools.changed_rings import folders, reached
from tools.module_graph import HEART, ROOT, circles, imported_by, imports, modules, packages_around, rings

ring_of = cache(module_graph.ring_of)
CIRCLES_OF_TYPES = 3
"""Groups of modules of which one imports another for type checkers alone. The number may only decrease."""


def test_each_room_is_in_one_ring() -> None:
    rooms = [room for ring in rings().values() for room in ring.rooms]
    assert len(rooms) == len(set(rooms))
    assert set(rooms) <= modules().keys()
    assert {module for module in modules() if ring_of(module) is None} == {"uwsim", "uwsim.__main__"}


def test_a_ring_imports_only_the_heart_and_what_it_needs() -> None:
    wrong = [
        f"{each.module} ({start}) imports {each.imported} ({end})"
        for each in sorted(imports())
        if (start := ring_of(each.module)) and (end := ring_of(each.imported))
        if end not in {start, HEART} | rings()[start].needs
    ]
    assert wrong == []


def test_needs_are_complete_and_used() -> None:
    for name, ring in rings().items():
        assert ring.needs == {need for other in ring.needs for need in rings()[other].needs | {other}}
        used = {ring_of(each.imported) for each in imports() if ring_of(each.module) == name}
        assert used - {name, HEART, None} == ring.needs


def test_the_floors_have_the_heart_below_the_add_ons() -> None:
    """Except for the examples, which are programs that nothing imports; and learning, which imports no other add-on."""
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]
    floors = [{name.strip(" ()") for name in floor.split("|")} for floor in contract["layers"]]
    is_heart = [{ring_of(f"uwsim.{name}") == HEART for name in floor - {"bench", "examples"}} for floor in floors[1:]]
    assert all(len(kinds) == 1 for kinds in is_heart)
    assert sum(upper != lower for upper, lower in pairwise(is_heart)) == 1
    assert is_heart[-1] == {True}


def test_the_architectures_picture_shows_them() -> None:
    assert PICTURE.read_text() == picture(), f"draw it again: tools/pictures {PICTURE.name}"


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Neither as they are loaded, with the packages around them, nor later in their functions."""
    running = [each for each in imports() if each.when != "types"]
    around = [(each.module, package) for each in running for package in packages_around(each.imported, each.module)]
    assert circles([*((each.module, each.imported) for each in running), *around]) == []


def test_few_modules_import_each_other_for_type_checkers() -> None:
    assert len(circles((each.module, each.imported) for each in imports())) <= CIRCLES_OF_TYPES


def test_a_circle_is_found() -> None:
    assert circles([("a", "b"), ("b", "c"), ("c", "a"), ("d", "a"), ("d", "d2")]) == [{"a", "b", "c"}]
    assert circles([("a", "b"), ("b", "c"), ("a", "c")]) == []


@pytest.mark.parametrize(
    ("text", "when"),
    [
        ("import uwsim.mapping.merge", "always"),
        ("from uwsim.mapping import merge", "always"),
        ("try:\n    from uwsim.mapping.merge import merge_files\nexcept OSError: ...", "always"),
        ("class A:\n    def f(self):\n        from uwsim.mapping import merge", "later"),
        ("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from uwsim.mapping import merge", "types"),
    ],
)
def test_an_import_is_found_wherever_it_stands(text: str, when: str) -> None:
    assert list(imported_by(text)) == [("uwsim.mapping.merge", when)]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("python/uwsim/learning/episodes.py", {HEART, "learning"}),
        ("tests/python/exercises/test_goals.py", {HEART, "station", "evidence", "league"}),  # which need the station
        ("python/uwsim/bridges/mavlink/plan.py", {HEART, "autopilots"}),
        ("python/uwsim/simulator/helm.py", set(rings())),
        ("cpp/uwsim/sim/simulation.cpp", set(rings())),
        ("docs/guides/live.md", {HEART}),
    ],
)
def test_a_change_reaches_the_rings_that_import_it(name: str, expected: set[str]) -> None:
    assert reached([name]) == expected
    tried = folders(expected)
    assert {"tests/python/simulator", "tests/python/whole"} <= set(tried)
    assert ("tests/python/learning" in tried) == ("learning" in expected)
