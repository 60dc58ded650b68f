"""`--ping1d` and `--ping360`: a vehicle's echo sounder and scanning sonar by Blue Robotics' ping protocol."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Options, option
from uwsim.bridges.doors.door import EVERYONE, OWN, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.bridges.ping.device import Device
    from uwsim.bridges.ping.line import Address
    from uwsim.simulator.vehicle import Vehicle

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


class Ping1dPlug(BridgePlug[Ping1dOptions]):
    """The Ping1Ds. Raises ValueError for a wrong address."""

    options = Ping1dOptions
    needs_live = True
    crosses_link = False
    doors = (Door("`--ping1d udp`", "UDP", 1, OWN, "ping protocol: a Ping1D", _ADMITS, ("--ping1d", "udp:0")),)

    def __init__(self, options: Ping1dOptions) -> None:
        super().__init__(options)
        self._addresses = _parsed("ping1d", options.ping1d, 9090)

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Answer until the `with` statement ends. Raises OSError, or ValueError for an instrument that does not fit."""
        from uwsim.bridges.ping.ping1d import Ping1D

        def altimeters(vehicle: Vehicle) -> list[str]:
            return [name for name, sensor in vehicle.sensors.items() if sensor.kind == "altitude"]

        with _devices("ping1d", self._addresses, context, Ping1D, altimeters, "a sensor of kind altitude") as devices:
            yield Opened(f"Ping1D at {', '.join(each.line.address for each in devices)}", devices)


class Ping360Plug(BridgePlug[Ping360Options]):
    """The Ping360s. Raises ValueError for a wrong address."""

    options = Ping360Options
    needs_live = True
    crosses_link = False
    doors = (
        Door("`--ping360 udp`", "UDP", 1, OWN, "ping protocol: a Ping360", _ADMITS,
             ("--ping360", "udp:0", "--vehicle-model", "bluerov2_heavy_outfit")),
    )  # fmt: skip

    def __init__(self, options: Ping360Options) -> None:
        super().__init__(options)
        self._addresses = _parsed("ping360", options.ping360, 9092)

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Answer until the `with` statement ends. Raises OSError, or ValueError for an instrument that does not fit."""
        from uwsim.bridges.ping.ping360 import Ping360

        def scanning(vehicle: Vehicle) -> list[str]:
            """Return the scanning sonars: those whose picture is a whole turn."""
            return [
                name
                for name, sonar in vehicle.imaging_sonars.items()
                if getattr(sonar.model, "field_of_view_rad", 0.0) > 6.28
            ]

        needed = "an imaging sonar of kind forward_looking with field_of_view_deg: 360, as bluerov2_heavy_outfit has"
        with _devices("ping360", self._addresses, context, Ping360, scanning, needed) as devices:
            yield Opened(f"Ping360 at {', '.join(each.line.address for each in devices)}", devices)


def _parsed(switch: str, texts: tuple[str, ...], port: int) -> list[Address]:
    from uwsim.bridges.ping.line import Address

    return [Address.parse(switch, text, port) for text in texts]


@contextmanager
def _devices(
    switch: str, addresses: list[Address], context: Context, make: Callable[..., Device],
    fitting: Callable[[Vehicle], list[str]], needed: str,
) -> Iterator[list[Device]]:  # fmt: skip
    """Open a device for each address. fitting: returns the names of a vehicle's instruments that it can be."""
    from uwsim.bridges.aboard.instrument import instrument
    from uwsim.bridges.ping.line import opened
    from uwsim.channels import require_live

    live = require_live(context.live)
    with ExitStack() as stack:
        devices: list[Any] = []
        for address in addresses:
            vehicle, name = instrument(switch, address.instrument, live.simulator, fitting, needed)
            device = make(live, vehicle, name, opened(address))
            devices.append(stack.enter_context(device))
        yield devices
