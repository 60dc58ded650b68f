"""`--dvl-a50`: a vehicle's DVL by Water Linked's protocol."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from uwsim.base.options import Options, option
from uwsim.bridges.doors.door import EVERYONE, OWN, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened

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


class A50Plug(BridgePlug[A50Options]):
    """The DVLs. Raises ValueError for a wrong address."""

    options = A50Options
    needs_live = True
    crosses_link = False
    doors = (
        Door("`--dvl-a50`", "TCP", 1, OWN, "Water Linked's DVL protocol",
             f"{EVERYONE}; no web page; it sets the DVL alone", ("--dvl-a50", "0"), speaks_first=True),
    )  # fmt: skip

    def __init__(self, options: A50Options) -> None:
        super().__init__(options)
        from uwsim.bridges.doors.hosts import checked_host

        self._addresses: list[tuple[str, str, int]] = []
        for text in options.dvl_a50:
            instrument, _, where = text.rpartition("=")
            found = re.fullmatch(r"(?:([^:=\s]+):)?(\d{1,5})", where)
            if found is None or int(found[2]) > 65535 or ("=" in text and not instrument):
                raise ValueError(f"dvl_a50 = '{text[:80]}': must be [INSTRUMENT=][HOST:]PORT, such as {PORT}")
            host = checked_host(found[1] or "127.0.0.1", f"dvl_a50 = '{text[:80]}'")
            self._addresses.append((instrument, host, int(found[2])))

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Send until the `with` statement ends. Raises OSError, or ValueError for an instrument that does not fit."""
        from contextlib import ExitStack

        from uwsim.bridges.a50.dvl import A50, logger
        from uwsim.bridges.aboard.instrument import instrument
        from uwsim.bridges.doors.admission import warn_beyond_loopback
        from uwsim.bridges.doors.line_server import LineServer
        from uwsim.channels import require_live

        live = require_live(context.live)
        with ExitStack() as stack:
            where = []
            for given, host, port in self._addresses:
                vehicle, name = instrument(
                    "dvl_a50", given, live.simulator,
                    lambda vehicle: [key for key, sensor in vehicle.sensors.items() if sensor.kind == "dvl"],
                    "a sensor of kind dvl",
                )  # fmt: skip
                warn_beyond_loopback(host, None, tls=False)
                server = LineServer(host, port, f"DVL A50 {host}:{port}", logger)
                stack.enter_context(A50(live, vehicle, name, server))
                where.append(f"{host}:{server.port}")
            yield Opened(f"DVL A50 at {', '.join(where)}", where)
