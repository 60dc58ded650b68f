"""Another package's attachment takes part in a flight, and its errors cost a warning and not the flight."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import uwsim
from plugin_package import add_package
from uwsim.base import sockets
from uwsim.base.options import OptionError, option
from uwsim.flight.attachment import Attachment, AttachmentOptions, Departure
from uwsim.missions import wait

PLACES = ("attach", "start", "flying", "on_ping", "observe", "commanded", "ended", "try_close")


class Mine(Attachment):
    """Notes where it takes part, and raises an error at one place."""

    def __init__(self, breaks_at: str) -> None:
        self.breaks_at, self.noted, self.due_tick = breaks_at, set(), 1
        self.on_ping = lambda *ping: self.at("on_ping")
        self.at("attach")

    def at(self, place: str, result: Any = None) -> Any:
        self.noted.add(place)
        if place == self.breaks_at:
            raise LookupError("lost")
        return result

    def start(self) -> None:
        self.at("start")

    @contextmanager
    def flying(self):
        self.at("flying")
        try:
            yield
        finally:
            self.noted.add("landed")

    @property
    def observer(self):
        return self

    def observe(self) -> None:
        self.due_tick += 10
        self.at("observe")

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        self.at("commanded")

    def ended(self, flown):
        return self.at("ended", flown)

    def try_close(self) -> None:
        self.at("try_close")


def mission(vehicle):
    yield wait(0.2)
    vehicle.set_effort(surge=0.2)
    yield wait(0.3)


@dataclass(frozen=True)
class Asked(AttachmentOptions):
    """Options of an attachment that is asked for. mine: 13 raises an error."""

    switch = "mine"

    mine: int | None = option(None, "Take part.")
    mine_word: str = option("a", "A word.")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mine == 13:
            raise LookupError("lost")

    def attach(self, flight: Departure) -> Attachment:
        noted.append((self.mine, self.mine_word))
        return Attachment()


noted: list[tuple[int | None, str]] = []


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The module of an installed package, of whose class Options the attachment is."""
    found = ModuleType("mine_of_others")
    monkeypatch.setitem(sys.modules, "mine_of_others", found)
    monkeypatch.syspath_prepend(add_package(tmp_path, "others", "uwsim.attachments", "mine = mine_of_others:Options"))
    caches = (sockets._installed, sockets.registered, sockets._loaded, sockets.load_all)
    for cache in caches:
        cache.cache_clear()
    yield found
    for cache in caches:
        cache.cache_clear()


@pytest.fixture
def fly_with(module: ModuleType):
    """Return a function that flies with what is attached to every flight."""

    def fly(attach) -> tuple[Any, list[str]]:
        if attach is not None:
            module.Options = type("Always", (AttachmentOptions,), {"attach": lambda self, flight: attach(flight)})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            flown = uwsim.fly(mission, "pool", map=True)
        return flown, [str(each.message) for each in caught if each.category is sockets.SocketWarning]

    return fly


def test_it_takes_part_everywhere(fly_with) -> None:
    made = []
    flown, warned = fly_with(lambda flight: made.append(Mine("")) or made[0])
    assert warned == [] and made[0].noted == {*PLACES, "landed"}
    assert flown.simulated_s == pytest.approx(0.5)


@pytest.mark.parametrize("place", PLACES)
def test_an_error_names_package_entry_and_place_and_the_flight_goes_on(fly_with, place: str) -> None:
    made: list[Mine] = []

    def attach(flight):
        mine = Mine.__new__(Mine)
        made.append(mine)
        mine.__init__(place)
        return mine

    flown, warned = fly_with(attach)
    where = "uwsim.attachments: 'mine' of others (mine_of_others:Options)"
    assert warned == [f"{where}: {place}: LookupError: lost; the flight goes on without it"]
    assert flown.simulated_s == pytest.approx(0.5)
    assert place in made[0].noted and ("try_close" in made[0].noted) == (place != "attach")  # it may hold files open
    assert ("landed" in made[0].noted) == (place not in PLACES[:3])


@pytest.mark.parametrize(
    ("attach", "why"),
    [
        (None, "cannot be used: AttributeError: module 'mine_of_others' has no attribute 'Options'"),
        (
            lambda flight: SimpleNamespace(),
            "attach: TypeError: SimpleNamespace: must be an Attachment or None; the flight goes on without it",
        ),
        (lambda flight: sys.exit(3), "attach: SystemExit: 3; the flight goes on without it"),
    ],
)
def test_what_is_no_attachment_costs_a_warning(fly_with, attach, why: str) -> None:
    flown, (warned,) = fly_with(attach)
    assert warned == f"uwsim.attachments: 'mine' of others (mine_of_others:Options): {why}"
    assert flown.simulated_s == pytest.approx(0.5)


def test_its_options_are_keywords_of_fly(module: ModuleType) -> None:
    module.Options = Asked
    noted.clear()
    uwsim.fly(mission, "pool")
    uwsim.fly(mission, "pool", mine=3, mine_word="b")
    assert noted == [(3, "b")]
    with pytest.raises(OptionError, match="--mine-word: needs --mine"):
        uwsim.fly(mission, "pool", mine_word="b")
    with pytest.raises(TypeError, match="mine_wrd: nothing that is registered has this option"):
        uwsim.fly(mission, "pool", mine_wrd="b")


def test_options_that_raise_an_error_end_only_what_asks_for_them(module: ModuleType) -> None:
    module.Options = Asked
    where = r"uwsim.attachments: 'mine' of others \(mine_of_others:Options\): options: LookupError: lost"
    with pytest.raises(sockets.EntryError, match=where):
        uwsim.fly(mission, "pool", mine=13)
    module.Options = type("Broken", (Asked,), {"__post_init__": lambda self: {}["lost"]})
    for cache in (sockets._loaded, sockets.load_all):
        cache.cache_clear()
    with pytest.warns(sockets.SocketWarning, match="options: KeyError: 'lost'"):
        uwsim.fly(mission, "pool")
