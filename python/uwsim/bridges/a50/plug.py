"""`--dvl-a50`: a vehicle's DVL by Water Linked's protocol."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, option
from uwsim.bridges.aboard.instrument import InstrumentPlug
from uwsim.bridges.doors.door import EVERYONE, OWN, Door
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm

if TYPE_CHECKING:
    from uwsim.bridges.a50.dvl import A50
    from uwsim.live import LiveSimulator
    from uwsim.simulator.vehicle import Vehicle


@dataclass(frozen=True)
class A50Options(Options):
    """The options of the DVL A50."""

    switch = "dvl_a50"

    dvl_a50: tuple[str, ...] = option(
        (),
        "Be a Water Linked DVL A50: the vehicle's DVL as JSON; see docs/connections/makers.md.",
        metavar="[INSTRUMENT=][HOST:]PORT",
    )


class A50Plug(InstrumentPlug[A50Options]):
    """The DVLs."""

    options = A50Options
    title, needed = "DVL A50", "a sensor of kind dvl"
    form = EndpointForm("dvl_a50", "[INSTRUMENT=][HOST:]PORT", {"": None})
    doors = (
        Door("`--dvl-a50`", "TCP", 1, OWN, "Water Linked's DVL protocol",
             f"{EVERYONE}; no web page; it sets the DVL alone", ("--dvl-a50", "0"), speaks_first=True),
    )  # fmt: skip

    def fitting(self, vehicle: Vehicle) -> list[str]:
        """Return the DVLs."""
        return [name for name, sensor in vehicle.sensors.items() if sensor.kind == "dvl"]

    def device(self, live: LiveSimulator, vehicle: str, name: str, address: Endpoint) -> A50:
        """See InstrumentPlug."""
        from uwsim.bridges.a50.dvl import A50, logger
        from uwsim.bridges.doors.admission import warn_beyond_loopback
        from uwsim.bridges.doors.streams import LineServer

        host, port, *_ = address
        warn_beyond_loopback(host, None, tls=False)
        server = LineServer((host, port), f"DVL A50 {host}:{port}", logger)
        return A50(live, vehicle, name, server, f"{host}:{server.port}")
