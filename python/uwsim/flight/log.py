"""The logs of a flight: one line of JSON per event, written to disk immediately, and a vehicle's pings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import IO

import numpy as np
import orjson
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import mark, remove_own_file, require_own
from uwsim.base.polygon import inside
from uwsim.missions.own_vehicle import Event

LOG = "log.jsonl"


class MissionLog:
    """The events of a flight, in order; if there is an output folder, also written to a new file as they occur.

    If the disk is full, the flight continues with the events in memory.
    """

    def __init__(self, out: Path | None) -> None:
        self.events: list[Event] = []
        self._path = None if out is None else out / LOG
        self._file: IO[bytes] | None = None
        if self._path is not None:
            require_own(self._path)
            self._file = self._path.open("wb", buffering=0)
            mark(self._path, unfinished=True)

    def add(self, event: Event) -> None:
        """Add an event."""
        self.events.append(event)
        if self._file is None or self._path is None:
            return
        try:
            self._file.write(_line(event))
        except OSError:
            self.close()
            remove_own_file(self._path)  # no incomplete file is left behind; see rewrite_if_lost

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
            assert self._path is not None
            mark(self._path)


def rewrite_if_lost(out: Path, events: Iterable[Event]) -> None:
    """Rewrite the events if their file is missing because its folder was deleted or the disk was full.

    Raises OSError.
    """
    if not (out / LOG).exists():
        write_atomically(out / LOG, b"".join(map(_line, events)))


def _line(event: Event) -> bytes:
    line = {"time_s": round(event.time_s, 6), "vehicle": event.vehicle, "event": event.name, **_values(event)}
    return orjson.dumps(line, option=orjson.OPT_APPEND_NEWLINE)


def _values(event: Event) -> dict[str, object]:
    return {"values": event.values} if event.values else {}


PINGS_PER_CANDIDATE = 50  # one ping in 50 is a candidate for the sample
PANEL_WARNINGS = ("range", "proximity", "collision")
"""The warnings on the vehicle's panel, fields `range_warning` and so on of its telemetry."""
lit = attrgetter(*(f"{name}_warning" for name in PANEL_WARNINGS))
"""Returns whether each of PANEL_WARNINGS is lit on a panel."""


@dataclass(frozen=True, eq=False)
class PingSample:
    """A ping stored for the report's picture of the sonar fan.

    ranges_m: (beams,), inf if there is no echo. angles_rad: (beams,), in the sonar's x-y plane, positive to port.
    world_from_sonar: (4, 4). points_world_m: (echoes, 3).
    """

    ranges_m: NDArray[np.floating]
    angles_rad: NDArray[np.floating]
    world_from_sonar: Floats
    points_world_m: NDArray[np.floating]


@dataclass
class PingLog:
    """The position at each ping, the number of echoes, and a sample: the ping with the most distinct labels.

    area_world_m: polygon in which the sample must have been taken; None: anywhere. positions_m: true sonar positions.
    mapped_m: sonar positions used for the map. pings_with_warning: the number of pings during which each of
    PANEL_WARNINGS was on.
    """

    area_world_m: Floats | None = None
    positions_m: list[list[float]] = field(default_factory=list)
    mapped_m: list[list[float]] = field(default_factory=list)
    echo_count: int = 0
    sample: PingSample | None = None
    sample_score: float = -1.0
    pings_with_warning: dict[str, int] = field(default_factory=lambda: dict.fromkeys(PANEL_WARNINGS, 0))

    def add(
        self,
        ping: _core.Ping,
        points_world_m: NDArray[np.float32],
        panel: _core.Telemetry,
        world_from_sonar: Floats,
        mapped_from_m: Floats | None = None,
    ) -> None:
        """Log the position, echoes and warnings of a ping; one ping in PINGS_PER_CANDIDATE may replace the sample.

        world_from_sonar: the pose of the sonar. mapped_from_m: the sonar position (3,) used for the map, if it differs
        from the true one.
        """
        if True in (are_lit := lit(panel)):
            for name, is_lit in zip(PANEL_WARNINGS, are_lit, strict=True):
                self.pings_with_warning[name] += is_lit
        position = world_from_sonar[:3, 3].tolist()
        self.positions_m.append(position)
        self.mapped_m.append(position if mapped_from_m is None else mapped_from_m.tolist())
        self.echo_count += len(points_world_m)
        if len(self.positions_m) % PINGS_PER_CANDIDATE == 0:
            self._consider(ping, points_world_m, position)

    def _consider(self, ping: _core.Ping, points_world_m: NDArray[np.float32], position: list[float]) -> None:
        """Store a ping as the sample if it is better than the current one."""
        # The best sample is a full fan that hits solids as well as the bed.
        labels = ping.labels[ping.valid]
        score = 100.0 * np.count_nonzero(np.bincount(labels)) + len(labels) / len(ping.labels)
        if score > self.sample_score and self._is_in_area(position):
            self.sample_score = score
            self.sample = PingSample(ping.ranges_m, ping.angles_rad, ping.world_from_sonar, points_world_m)

    def _is_in_area(self, position: list[float]) -> bool:
        area_m = self.area_world_m
        return area_m is None or bool(inside(np.array([position[:2]]), area_m)[0])

    @property
    def path_world_m(self) -> Floats:
        """The true sonar position at each ping, (n, 3)."""
        return np.array(self.positions_m, np.float64).reshape(-1, 3)

    @property
    def mapped_path_m(self) -> Floats:
        """The sonar position used for the map at each ping, (n, 3)."""
        return np.array(self.mapped_m, np.float64).reshape(-1, 3)
