"""The latest ping of a vehicle. As with a real sonar, the travel time of sound limits the ping rate."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.channels.source import Source
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.mapping.ranging import place_deviation_m
from uwsim.simulator.simulator import Simulator

SLOT_S = 0.02
"""The ping interval is a multiple of this, so that pings coincide with poses published at 50 Hz."""


@dataclass(frozen=True, eq=False)
class TakenPing:
    """A ping, and the poses at which it was taken: odom_from_body, odom_from_sonar (4, 4).

    deviation_m: (beams,), standard deviations of the echoes' positions; None if unknown, as in geometry mode.
    """

    ping: _core.Ping
    odom_from_body: NDArray[np.float64]
    odom_from_sonar: NDArray[np.float64]
    deviation_m: NDArray[np.float32] | None = None


class Pings:
    """The pings of a vehicle's multibeam, at an interval that allows for the travel time of sound.

    interval_s: the interval, a multiple of SLOT_S.

    Readers at the same simulated time get the same ping. Without readers, no pings are computed. Sonars that ping at
    the same time do so together, on all threads. model: the sonar model at the latest ping.
    """

    def __init__(self, source: Source, sim: Simulator) -> None:
        self.source = source
        self._all: Mapping[str, Pings] = {source.name: self}
        self.model = source.of(sim).sonar.model
        self._sonar = source.of(sim).sonar
        self.interval_s = self._travel_s(sim)
        self._newest: TakenPing | None = None

    @classmethod
    def all_of(cls, sources: Iterable[Source], sim: Simulator) -> dict[str, Pings]:
        """Return the pings of each source that has a multibeam, by its name."""
        found = {source.name: cls(source, sim) for source in sources if source.has_sonar}
        for pings in found.values():
            pings._all = found
        return found

    def _travel_s(self, sim: Simulator) -> float:
        slots = math.ceil(1.0 / self.source.of(sim).sonar.ping_rate_max_hz / SLOT_S - 1e-9)
        return max(slots, 1) * SLOT_S

    @property
    def chain(self) -> PingToMap:
        """The chain from the pings to a map."""
        return self._sonar.chain

    @property
    def rate_hz(self) -> float:
        """Pings per second."""
        return 1.0 / self.interval_s

    def newest(self, sim: Simulator) -> TakenPing:
        """Return the latest ping, or a new one if a new interval has begun or simulated time has gone back."""
        now_ns, last = sim.time_ns, self._newest
        if last is None or now_ns < last.ping.time_ns or self._interval(now_ns) != self._interval(last.ping.time_ns):
            vehicle = self.source.of(sim)
            self._sonar = vehicle.sonar
            if vehicle.sonar.model is not self.model:  # its parameters have changed
                self.model, self.interval_s = vehicle.sonar.model, self._travel_s(sim)
            ping = self._pinged(sim)
            body, sonar = np.array(vehicle.pose.world_from_body), np.array(ping.world_from_sonar)
            for pose in (body, sonar):
                pose[:3, 3] += self.source.origin_m
            self._newest = last = TakenPing(ping, body, sonar, place_deviation_m(ping))
        return last

    def _pinged(self, sim: Simulator) -> _core.Ping:
        """Ping, and with it all sonars whose readers will probably ask for a ping next."""
        awaited = [each for each in self._all.values() if each is not self and each._is_awaited(sim.time_ns)]
        return sim.ping(self._sonar, *(each.source.of(sim).sonar for each in awaited))[0]

    def _is_awaited(self, now_ns: int) -> bool:
        """Return whether an interval has just begun, and the previous one had a reader."""
        last = self._newest
        return last is not None and self._interval(now_ns) == self._interval(last.ping.time_ns) + 1

    def forget(self) -> None:
        """Take a new ping at the next reading, so that later readings do not depend on earlier ones."""
        self._newest = None

    def _interval(self, time_ns: int) -> int:
        return time_ns // round(self.interval_s * 1e9)
