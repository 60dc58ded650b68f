"""Fixtures of several modules: programs, a MAVLink vehicle in the lagoon, and a ground station."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import forked_programs
from uwsim.live import LiveSimulator

if TYPE_CHECKING:
    from mavlink_station import Station
    from rosbridge_session import Client
    from uwsim.bridges.mavlink import MavlinkVehicle
    from uwsim.bridges.rosbridge.graph import Graph


PROGRAMS = forked_programs.Programs()


@pytest.fixture(scope="session")
def programs() -> forked_programs.Programs:
    return PROGRAMS


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """End the shared process with the last test of this folder, to which its processor time belongs."""
    if nextitem is None or nextitem.path.parent != item.path.parent:
        PROGRAMS.close()


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    from mavlink_station import lagoon  # needs pymavlink, which some installations do not have

    with lagoon() as live:
        yield live


@pytest.fixture(scope="module")
def vehicle(live: LiveSimulator) -> "Iterator[MavlinkVehicle]":
    from mavlink_station import served

    with served(live) as vehicle:
        yield vehicle


@pytest.fixture(scope="module")
def only_station(vehicle: "MavlinkVehicle") -> "Iterator[Station]":
    from mavlink_station import station_at

    station = station_at(vehicle)
    yield station
    station.close()


@pytest.fixture
def station(only_station: "Station") -> "Iterator[Station]":
    only_station.drain()
    yield only_station
    only_station.arm(False)


@pytest.fixture
def other(vehicle: "MavlinkVehicle") -> "Iterator[Station]":
    """Another ground station, of system 254."""
    from mavlink_station import station_at

    station = station_at(vehicle, 254)
    yield station
    station.close()


@pytest.fixture
def graph() -> "Graph":
    from uwsim.bridges.rosbridge.graph import Graph

    return Graph()


@pytest.fixture
def pair(graph: "Graph") -> "tuple[Client, Client]":
    """Two clients of a rosbridge's graph."""
    from rosbridge_session import Client

    return Client(graph, "/one"), Client(graph, "/two")


@pytest.fixture
def binary(tmp_path: Path) -> Path:
    """The stand-in for the program ArduSub, run by this interpreter."""
    made = tmp_path / "ardusub"
    made.write_text(f'#!/bin/sh\nexec {sys.executable} -S {Path(__file__).with_name("firmware_standin.py")} "$@"\n')
    made.chmod(0o755)
    return made
