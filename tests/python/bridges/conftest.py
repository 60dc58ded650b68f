"""Fixtures of several modules: a MAVLink vehicle in the lagoon, and a ground station, for modules without their own."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from uwsim.live import LiveSimulator

if TYPE_CHECKING:
    from mavlink_station import Station
    from uwsim.bridges.mavlink import MavlinkVehicle


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
def binary(tmp_path: Path) -> Path:
    """The stand-in for the program ArduSub, run by this interpreter."""
    made = tmp_path / "ardusub"
    made.write_text(f'#!/bin/sh\nexec {sys.executable} -S {Path(__file__).with_name("firmware_standin.py")} "$@"\n')
    made.chmod(0o755)
    return made
