"""Another package's attachment takes part in a flight, and its errors cost a warning and not the flight."""

import sys
import warnings
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import uwsim
from plugin_package import add_package
from uwsim.base import sockets
from uwsim.flight.attachment import Attachment
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
        yield

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


@pytest.fixture
def fly_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Return a function that flies with an attachment of an installed package."""
    module = ModuleType("mine_of_others")
    monkeypatch.setitem(sys.modules, "mine_of_others", module)
    monkeypatch.syspath_prepend(add_package(tmp_path, "others", "uwsim.attachments", "mine = mine_of_others:attach"))
    caches = (sockets._installed, sockets.registered, sockets._loaded)
    for cache in caches:
        cache.cache_clear()

    def fly(attach) -> tuple[Any, list[str]]:
        if attach is not None:
            module.attach = attach
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            flown = uwsim.fly(mission, "pool", map=True)
        return flown, [str(each.message) for each in caught if each.category is sockets.SocketWarning]

    yield fly
    for cache in caches:
        cache.cache_clear()


def test_it_takes_part_everywhere(fly_with) -> None:
    made = []
    flown, warned = fly_with(lambda flight: made.append(Mine("")) or made[0])
    assert warned == [] and made[0].noted == set(PLACES)
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
    where = "uwsim.attachments: 'mine' of others (mine_of_others:attach)"
    assert warned == [f"{where}: {place}: LookupError: lost; the flight goes on without it"]
    assert flown.simulated_s == pytest.approx(0.5)
    assert place in made[0].noted and "try_close" not in made[0].noted - {place}


@pytest.mark.parametrize(
    ("attach", "why"),
    [
        (None, ": cannot be used: AttributeError: module 'mine_of_others' has no attribute 'attach'"),
        (lambda flight: SimpleNamespace(), ": attach: TypeError: SimpleNamespace: must be an Attachment or None"),
        (lambda flight: sys.exit(3), ": attach: SystemExit: 3"),
    ],
)
def test_what_is_no_attachment_costs_a_warning(fly_with, attach, why: str) -> None:
    flown, (warned,) = fly_with(attach)
    assert f"(mine_of_others:attach){why}; the flight goes on without it" in warned
    assert flown.simulated_s == pytest.approx(0.5)
