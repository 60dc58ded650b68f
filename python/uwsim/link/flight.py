"""The link of a flight: carries messages to the station, which builds a map from the pings that arrive."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from uwsim.channels import Table
from uwsim.channels.families.scans import PLACED
from uwsim.flight.attachment import Attachment, Departure
from uwsim.flight.pinging import SURVEYED, ping_steps
from uwsim.flight.record import FlightRecord
from uwsim.link import Carrier
from uwsim.link.ashore import placed_points
from uwsim.link.carried import carried_channels
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.simulator.link_traffic import LinkRow, link_rows
from uwsim.simulator.network import STATION
from uwsim.simulator.simulator import Simulator


class Ashore:
    """Collects a vehicle's pings as they arrive, as an Observer of the simulator's journal.

    table: the simulator's channels. only: name endings of the channels that the vehicle sends, unless the scenario
    selects what its link carries; if None, all channels that the link can carry. steps: simulator steps between
    collections. Nothing on board depends on the link.
    """

    def __init__(self, sim: Simulator, table: Table, vehicle: str, steps: int, *, only: tuple[str, ...] | None) -> None:
        assert sim.link is not None
        self._sim, self._network, self._steps = sim, sim.link, steps
        carried = carried_channels(table.channels, sim)
        named = {one.channel.name: one for one in carried if one.vehicle == vehicle}
        self._ping = next((one for name, one in named.items() if name.endswith(PLACED.name)), None)
        self._reach_m = sim.vehicles[vehicle].sonar.model.range_max_m
        self._pings: list[bytes] = []
        self._looked_ns, self.due_tick = sim.time_ns, sim.tick + steps
        self._carrier = Carrier(sim, table, only=only)
        self._seen = [one for one in self._carrier.channels if one.name.endswith(SURVEYED)]
        self._carrier.start()

    def observe(self) -> None:
        """Collect the pings that have arrived since the last call, since the link does not keep them."""
        self.due_tick = self._sim.tick + self._steps
        for channel in self._seen:
            channel.read(self._sim)  # over a cable, a channel is sent only if something reads it
        for got in self._network.received(STATION, 1e-9 * self._looked_ns):
            if self._ping is not None and got.topic == self._ping.channel.name:
                self._pings.append(got.payload)
        self._looked_ns = self._sim.time_ns

    def close(self) -> None:
        """Stop sending messages over the link."""
        self._carrier.close()

    @property
    def ping_count(self) -> int:
        """Number of pings that have arrived."""
        return len(self._pings)

    def table(self) -> list[LinkRow]:
        """Return the numbers of messages sent, delivered, lost and late, by topic."""
        return link_rows(self._sim)

    def made_map(self, resolution_m: float, engine: MapEngine) -> OccupancyMap:
        """Return a map built from the pings that have arrived."""
        made = OccupancyMap(resolution_m=resolution_m, engine=engine)
        for payload in self._pings:
            assert self._ping is not None
            points, origin = placed_points(self._ping.packing.unpack(payload, self._ping.channel))
            made.insert_scan(points, origin, self._reach_m)
        return made


class LinkAttachment(Attachment):
    """Carries a flight's messages over the scenario's link; of a mapping flight, the first vehicle's pings."""

    def __init__(self, flight: Departure) -> None:
        self._flight = flight
        tables = [other.table for other in flight.others.values() if other.table is not None]
        self.table = tables[0] if tables else None
        self._ashore: Ashore | None = None

    @contextmanager
    def flying(self) -> Iterator[None]:
        """Carry messages while the mission is flown."""
        sim, name = self._flight.sim, self._flight.names[0]
        table = self.table or Table(sim)  # shared with a recorder
        if not self._flight.has_map:
            with Carrier(sim, table):
                yield
            return
        self._ashore = Ashore(sim, table, name, ping_steps(sim, name), only=self._flight.carried)
        try:
            yield
        finally:
            self._ashore.close()

    @property
    def observer(self) -> Ashore | None:
        """The station's end."""
        return self._ashore

    def ended(self, flown: FlightRecord) -> FlightRecord:
        """Return the record with the station's end."""
        return replace(flown, ashore=self._ashore)
