"""Taped channels: the simulation writes their readings by itself, and their messages are made many at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator


class Track(NamedTuple):
    """The content of rows: a sensor's readings, a vehicle's motion if there is no sensor, or the time alone."""

    vehicle: str = ""
    sensor: str = ""


class Rows(NamedTuple):
    """Rows of a track, as from `Simulation.take_rows` of the core.

    stamps_ns, times_ns: (n,), the times of measurement and of reading. values: (n, width). valid: (n,).
    """

    stamps_ns: NDArray[np.uint64]
    times_ns: NDArray[np.uint64]
    values: NDArray[np.float64]
    valid: NDArray[np.bool_]

    def only(self, which: NDArray[np.bool_]) -> Rows:
        """Return the rows of a mask (n,)."""
        return Rows(*(column[which] for column in self))  # type: ignore[arg-type]  # each keeps its type


class Stretch(NamedTuple):
    """Messages of a channel, in columns (see `ros.columns`), and when they were read, (n,) [ns]."""

    times_ns: NDArray[np.uint64]
    message: Any


Make = Callable[[Sequence[Rows]], Stretch]
"""Makes messages from the rows of a channel's tracks."""


class Taped(NamedTuple):
    """How a channel's messages follow from a tape.

    begin: returns the function that makes them, from now until the next command, or None if the channel must be read.
    It keeps all that it needs of the simulator's present state, which the command may have changed. note: for a channel
    without tracks, returns the numbers that a row has, (width,), which are then read instead of a message.
    """

    tracks: tuple[Track, ...]
    begin: Callable[[Simulator], Make | None]
    note: Callable[[Simulator], Floats] | None = None


@dataclass(frozen=True, slots=True)
class Motion:
    """A vehicle's true motion at one time, or in columns at n times, in the world and in body axes.

    elevation_rad: its multibeam's; NaN without one.
    """

    time_ns: Any
    position_m: Floats
    orientation_xyzw: Floats
    linear_m_s: Floats
    angular_rad_s: Floats
    elevation_rad: Any

    @classmethod
    def now(cls, source: Source, sim: Simulator) -> Motion:
        """Return the present motion."""
        vehicle = source.of(sim)
        pose, velocity = vehicle.pose, vehicle.velocity
        elevation_rad = vehicle.sonar.elevation_rad if source.has_sonar else math.nan
        turning = velocity.linear_body_m_s, velocity.angular_body_rad_s
        return cls(sim.time_ns, pose.position_world_m, pose.orientation_xyzw, *turning, elevation_rad)

    @classmethod
    def of_rows(cls, rows: Rows) -> Motion:
        """Return the motion in columns."""
        position_m, orientation_xyzw, linear_m_s, angular_rad_s, elevations_rad = np.split(
            rows.values, (3, 7, 10, 13), axis=1
        )
        elevation_rad = elevations_rad[:, 0] if elevations_rad.shape[1] else math.nan
        return cls(rows.times_ns, position_m, orientation_xyzw, linear_m_s, angular_rad_s, elevation_rad)

    @property
    def tilt_xyzw(self) -> Any:
        """The rotation of the multibeam's head, (4,) or (n, 4)."""
        one = not isinstance(self.elevation_rad, np.ndarray)
        return build.tilt_xyzw(self.elevation_rad) if one else build.tilts_xyzw(self.elevation_rad)


def of_motion(source: Source, write: Callable[[Motion], Any]) -> dict[str, Any]:
    """Return what a channel needs whose message depends on a vehicle's motion only: `read` and `taped`."""
    taped = of_motions([source], lambda sim: lambda motions: write(motions[0]))
    return {"read": lambda sim: write(Motion.now(source, sim)), "taped": taped}


def of_motions(
    sources: Sequence[Source], begin: Callable[[Simulator], Callable[[Sequence[Motion]], Any] | None]
) -> Taped:
    """Return how a channel's messages follow from several vehicles' motion.

    begin: returns the function that makes the message from the motions of all, and keeps what else it needs; None if
    something else moves, so that the channel must be read.
    """

    def begin_tape(sim: Simulator) -> Make | None:
        write = begin(sim)
        if write is None:
            return None
        return lambda rows: Stretch(rows[0].times_ns, write([Motion.of_rows(each) for each in rows]))

    return Taped(tuple(Track(source.name) for source in sources), begin_tape)
