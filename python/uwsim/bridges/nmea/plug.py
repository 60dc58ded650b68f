"""`--nmea`: the first vehicle's navigation as NMEA 0183 sentences."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from uwsim.base.options import Options, option
from uwsim.bridges.doors.door import EVERYONE, OWN, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened


@dataclass(frozen=True)
class NmeaOptions(Options):
    """The options of the NMEA sentences."""

    switch = "nmea"

    nmea: str | None = option(
        None,
        "Send NMEA 0183 by udp (to an address) or tcp (listens), with [:HOST]:PORT; see docs/connections/nmea.md.",
    )
    nmea_rate: float = option(1.0, "NMEA: groups of sentences per simulated second.", bounds=(0.1, 20, "Hz"))


class NmeaPlug(BridgePlug[NmeaOptions]):
    """The NMEA sentences. Raises ValueError for a wrong address."""

    options = NmeaOptions
    needs_live = True
    crosses_link = False
    doors = (
        Door("`--nmea tcp`", "TCP", 1, OWN, "NMEA 0183", f"{EVERYONE}; nothing is read from it", ("--nmea", "tcp:0"),
             speaks_first=True),
        Door("`--nmea udp`", "UDP", 1, "127.0.0.1 if the target is local", "NMEA 0183", "no program: nothing is read",
             ("--nmea", "udp")),
    )  # fmt: skip

    def __init__(self, options: NmeaOptions) -> None:
        super().__init__(options)
        from uwsim.bridges.nmea.wire import FORM

        self._target = FORM.parse(options.nmea or "")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Send until the `with` statement ends. Raises OSError, or MissingExtraError without rasterio."""
        import logging
        from contextlib import closing
        from datetime import UTC, datetime, timedelta

        from uwsim.bridges.nmea.readings import read
        from uwsim.bridges.nmea.wire import Wire
        from uwsim.channels import require_live
        from uwsim.scenario.georeference import georeference

        live = require_live(context.live)
        name, place = live.simulator.rov.name, georeference(live.simulator.scenario)
        if place.crs is None:
            logging.getLogger("uwsim.nmea").warning(
                "--nmea: no position is sent, as the scenario has no place on Earth: give it the key earth"
            )
        start = datetime.now(UTC) - timedelta(seconds=live.simulator.time_s)
        with closing(Wire(self._target)) as wire:
            subscription = live.every(
                1.0 / self.given.nmea_rate,
                lambda sim: read(sim.vehicles[name], place, lambda at: start + timedelta(seconds=at), sim.time_s),
                wire.send,
            )
            try:
                yield Opened(f"NMEA at {wire.target}", wire)
            finally:
                subscription.cancel()
