"""`--dvl-a50`: a vehicle's DVL by Water Linked's protocol."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from uwsim.base.options import Options, option
from uwsim.bridges.aboard.instrument import InstrumentPlug
from uwsim.bridges.doors.door import EVERYONE, OWN, Door

if TYPE_CHECKING:
    from uwsim.bridges.a50.dvl import A50
    from uwsim.live import LiveSimulator
    from uwsim.simulator.vehicle import Vehicle

PORT = 16171


@dataclass(frozen=True)
class A50Options(Options):
    """The options of the DVL A50."""

    switch = "dvl_a50"

    dvl_a50: tuple[str, ...] = option(
        (),
        "Be a Water Linked DVL A50: the vehicle's DVL as JSON; see docs/connections/makers.md.",
        metavar="[INSTRUMENT=][HOST:]PORT",
    )


class Address(NamedTuple):
    """Where the DVL listens, and which instrument it is: its name, "VEHICLE/NAME", or "" for the first one."""

    instrument: str
    host: str
    port: int


class A50Plug(InstrumentPlug[A50Options]):
    """The DVLs."""

    options = A50Options
    title, needed = "DVL A50", "a sensor of kind dvl"
    doors = (
        Door("`--dvl-a50`", "TCP", 1, OWN, "Water Linked's DVL protocol",
             f"{EVERYONE}; no web page; it sets the DVL alone", ("--dvl-a50", "0"), speaks_first=True),
    )  # fmt: skip

    def parsed(self, text: str) -> Address:
        """See InstrumentPlug."""
        from uwsim.bridges.doors.hosts import checked_host

        instrument, _, where = text.rpartition("=")
        found = re.fullmatch(r"(?:([^:=\s]+):)?(\d{1,5})", where)
        if found is None or int(found[2]) > 65535 or ("=" in text and not instrument):
            raise ValueError(f"dvl_a50 = '{text[:80]}': must be [INSTRUMENT=][HOST:]PORT, such as {PORT}")
        return Address(instrument, checked_host(found[1] or "127.0.0.1", f"dvl_a50 = '{text[:80]}'"), int(found[2]))

    def fitting(self, vehicle: Vehicle) -> list[str]:
        """Return the DVLs."""
        return [name for name, sensor in vehicle.sensors.items() if sensor.kind == "dvl"]

    def device(self, live: LiveSimulator, vehicle: str, name: str, address: Address) -> A50:
        """See InstrumentPlug."""
        from uwsim.bridges.a50.dvl import A50, logger
        from uwsim.bridges.doors.admission import warn_beyond_loopback
        from uwsim.bridges.doors.line_server import LineServer

        _, host, port = address
        warn_beyond_loopback(host, None, tls=False)
        server = LineServer(host, port, f"DVL A50 {host}:{port}", logger)
        return A50(live, vehicle, name, server, f"{host}:{server.port}")
