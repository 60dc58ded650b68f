"""`--ping1d` and `--ping360`: a vehicle's echo sounder and scanning sonar by Blue Robotics' ping protocol."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, option
from uwsim.bridges.aboard.instrument import InstrumentPlug
from uwsim.bridges.doors.door import EVERYONE, OWN, Door
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm

if TYPE_CHECKING:
    from uwsim.bridges.ping_protocol.ping1d import Ping1D
    from uwsim.bridges.ping_protocol.ping360 import Ping360
    from uwsim.live import LiveSimulator
    from uwsim.simulator.vehicle import Vehicle

_FORM = "[INSTRUMENT=]udp[:HOST][:PORT] or [INSTRUMENT=]pty"
METAVAR = "[INSTRUMENT=]udp[:HOST]:PORT|pty"
_ADMITS = f"{EVERYONE}; the last that sent a message is answered; it steers nothing"


@dataclass(frozen=True)
class Ping1dOptions(Options):
    """The options of the Ping1D."""

    switch = "ping1d"

    ping1d: tuple[str, ...] = option(
        (), "Be a Ping1D: the altimeter for ping-python; see docs/connections/makers.md.", metavar=METAVAR
    )


@dataclass(frozen=True)
class Ping360Options(Options):
    """The options of the Ping360."""

    switch = "ping360"

    ping360: tuple[str, ...] = option(
        (), "Be a Ping360: the scanning sonar for ping-python; see docs/connections/makers.md.", metavar=METAVAR
    )


class Ping1dPlug(InstrumentPlug[Ping1dOptions]):
    """The Ping1Ds."""

    options = Ping1dOptions
    title, needed = "Ping1D", "a sensor of kind altitude"
    form, module = EndpointForm("ping1d", _FORM, {"udp": 9090, "pty": 0}, bare=("pty",)), "brping"
    doors = (Door("`--ping1d udp`", "UDP", 1, OWN, "ping protocol: a Ping1D", _ADMITS, ("--ping1d", "udp:0")),)

    def fitting(self, vehicle: Vehicle) -> list[str]:
        """Return the altimeters."""
        return [name for name, sensor in vehicle.sensors.items() if sensor.kind == "altitude"]

    def device(self, live: LiveSimulator, vehicle: str, name: str, address: Endpoint) -> Ping1D:
        """See InstrumentPlug."""
        from uwsim.bridges.ping_protocol.line import Line
        from uwsim.bridges.ping_protocol.ping1d import Ping1D

        return Ping1D(live, vehicle, name, Line(address))


class Ping360Plug(InstrumentPlug[Ping360Options]):
    """The Ping360s."""

    options = Ping360Options
    title = "Ping360"
    form, module = EndpointForm("ping360", _FORM, {"udp": 9092, "pty": 0}, bare=("pty",)), "brping"
    needed = "an imaging sonar of kind forward_looking with field_of_view_deg: 360, as bluerov2_heavy_outfit has"
    doors = (
        Door("`--ping360 udp`", "UDP", 1, OWN, "ping protocol: a Ping360", _ADMITS,
             ("--ping360", "udp:0", "--vehicle-model", "bluerov2_heavy_outfit")),
    )  # fmt: skip

    def fitting(self, vehicle: Vehicle) -> list[str]:
        """Return the scanning sonars: those whose picture is a whole turn."""
        sonars = vehicle.imaging_sonars.items()
        return [name for name, sonar in sonars if getattr(sonar.model, "field_of_view_rad", 0.0) > 6.28]

    def device(self, live: LiveSimulator, vehicle: str, name: str, address: Endpoint) -> Ping360:
        """See InstrumentPlug."""
        from uwsim.bridges.ping_protocol.line import Line
        from uwsim.bridges.ping_protocol.ping360 import Ping360

        return Ping360(live, vehicle, name, Line(address))
