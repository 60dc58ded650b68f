"""Simulates the outputs of a log, and their derivatives, in one batch of simulations.

Derivatives are central differences (Press et al. 2007, Numerical Recipes, 3rd ed., sec. 5.7). Mass, volume, added mass,
drag and thrust together may grow by a common factor with hardly any effect on the motion, the sum of large ones that
cancel. What a forward difference adds to each, half of the second derivative times the difference, would not cancel:
it would pass for information about the factor, which the log does not have.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from weakref import finalize

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.batch import Batch
from uwsim.evidence.identification import command_times
from uwsim.evidence.identification.unknowns import DELAY, Unknown, parameters_at
from uwsim.recording.real_flights.deep_water import BOAT_STEP_S, STEP_S, in_deep_water, start_m
from uwsim.recording.real_flights.motion import TILT, MotionLog, command
from uwsim.scenario import VehicleModel
from uwsim.scenario.build.hull import is_boat

Indices = NDArray[np.intp]
START_SPREADS = np.repeat((0.5, 0.2, 0.5, 0.5), 3)  # of a segment's initial state [m, rad, m/s, rad/s]
OUTPUTS = 12
DIFFERENCE = 1e-2
"""Difference of an unknown for its derivative, either way, in standard deviations of its prior.

A propeller's loss by inflow is as the root of its thrust, whose derivative is infinite where the thrust reverses; with
much smaller differences, one step near there would pass for information on the thrust's lag.
"""
MOST_ROWS, MOST_UNKNOWNS = 400_000, 3000  # which take 2 GB, and a minute for each solution


@dataclass(frozen=True)
class Part:
    """A segment: its rows (r,), its first time, its number of steps, and the commands near it.

    The motion is sampled after `ticks` (t,) steps; row k lies `share` (r,) between the samples low (r,) and high (r,).
    columns: of z, those that affect the segment.
    """

    rows: Indices
    start_s: float
    steps: int
    commands: command_times.Segment
    ticks: Indices
    low: Indices
    high: Indices
    share: Floats
    columns: Indices

    @property
    def shifts(self) -> int:
        """The number of its commands whose times may shift."""
        return len(self.commands.shifting)


@dataclass(frozen=True)
class Block:
    """Derivatives (r, 12, c) of the rows (r,) with respect to the columns (c,) of z: the unknowns, then the rest."""

    rows: Indices
    columns: Indices
    slopes: Floats


class Flown:
    """Simulates a log for given values of the unknowns, in segments that each have their own initial state.

    z has the unknowns, in standard deviations of their priors, then for each segment 12 entries for its start and one
    for each of its commands whose time may shift.
    """

    def __init__(
        self,
        model: VehicleModel,
        log: MotionLog,
        found: list[Unknown],
        segment_s: float,
        density_kg_m3: float,
        threads: int | None = None,
        most: int | None = None,
    ):
        """segment_s: approximate length of a segment. density_kg_m3: density of the water. most: number of segments.

        Of more segments than `most`, evenly spaced ones remain. Raises ValueError if the log is too long.
        """
        self.found, self._log = found, log
        self._step_s = BOAT_STEP_S if is_boat(model, density_kg_m3) else STEP_S
        self._parts = parts_of(log, len(found), segment_s, most, self._step_s)
        self.size = len(found) + sum(OUTPUTS + part.shifts for part in self._parts)
        if len(log.times_s) > MOST_ROWS:
            raise ValueError(f"log: {len(log.times_s)} rows: must be at most {MOST_ROWS}: leave out some")
        if self.size > MOST_UNKNOWNS:
            span_s = log.times_s[-1] - log.times_s[0]
            rule = f"must be at most {MOST_UNKNOWNS}: cut the log, or use longer segments"
            raise ValueError(f"log: {span_s:.0f} s in segments of {segment_s:g} s have {self.size} unknowns: {rule}")
        self._shifts = max(part.shifts for part in self._parts)
        self._moved = len(found) + OUTPUTS
        self._members = 1 + 2 * self._moved + self._shifts
        self._delay = next((k for k, unknown in enumerate(found) if unknown.name == DELAY), None)
        self._last_z = np.empty(0)
        self._last: tuple[Floats, list[Block]] = (np.empty(0), [])
        folder = Path(tempfile.mkdtemp(prefix="uwsim-"))
        finalize(self, rmtree, folder, ignore_errors=True)  # members reread the hull when its centre changes
        scenario = in_deep_water(model, density_kg_m3, folder, self._step_s)
        self._start_m = np.array(start_m(scenario))
        self._origin_m = self._start_m - _first(log.position_m)
        self._batch = Batch(scenario, n=self._members, threads=threads)
        self._begin = [self._measured_start(part.rows[0]) for part in self._parts]

    def outputs(self, z: Floats) -> tuple[Floats, list[Block]]:
        """Return residuals (n, 12) against the log, NaN where it has none, and their derivatives by segment.

        Columns: position [m], attitude [rad], velocity [m/s], rate [rad/s]. The result for the last z is cached. Raises
        ValueError if a motion diverges.
        """
        if not np.array_equal(z, self._last_z):
            self._last, self._last_z = self._simulated(z), z.copy()
        return self._last

    def _simulated(self, z: Floats) -> tuple[Floats, list[Block]]:
        p = len(self.found)
        values = np.tile(z[:p], (self._members, 1))
        for sign, nudged in self._nudged():
            values[nudged][:p] += sign * DIFFERENCE * np.eye(p)
        self._batch.reset(parameters=[parameters_at(self.found, row) for row in values])
        residuals, blocks = np.full((len(self._log.times_s), OUTPUTS), np.nan), []
        for k, part in enumerate(self._parts):  # thrusters continue from the previous segment's commands
            own = z[part.columns[p:]]
            placed = np.tile(self._placed(k, own[:OUTPUTS]), (self._members, 1))
            for sign, nudged in self._nudged():
                starts = own[:OUTPUTS] + sign * DIFFERENCE * np.eye(OUTPUTS)
                placed[nudged][p:] = [self._placed(k, start) for start in starts]
            self._batch.place(placed[:, :3], placed[:, 3:7], placed[:, 7:])
            residuals[part.rows], slopes = self._segment(part, z[:p], own[OUTPUTS:])
            blocks.append(Block(part.rows, part.columns, slopes))
        return residuals, blocks

    def _nudged(self) -> tuple[tuple[int, slice], tuple[int, slice]]:
        """Return the members whose unknowns, then starts, differ: by +1 and by -1 difference."""
        return (1, slice(1, 1 + self._moved)), (-1, slice(1 + self._moved, 1 + 2 * self._moved))

    def _segment(self, part: Part, z: Floats, shifts: Floats) -> tuple[Floats, Floats]:
        """Return the residuals (r, 12) of a segment and their derivatives (r, 12, c).

        Commands take effect at steps. Between two steps, the motion is interpolated linearly from one simulation with
        the earlier step and one with the later step, whose difference is the derivative; for each command that may
        shift, by its own time, the delay included, so that the residuals stay continuous.
        """
        delay = 0.0 if self._delay is None else self.found[self._delay].at(float(z[self._delay])) / self._step_s
        ticks = delay + shifts * part.commands.sd_s / self._step_s
        off = self._misses(part, int(np.floor(delay)), np.floor(ticks).astype(np.int64))
        m, n = self._moved, part.shifts
        nudges = np.full(m + n, DIFFERENCE)
        nudges[m:] = self._step_s / part.commands.sd_s
        (_, more), (_, less) = self._nudged()
        later = off[:, 1 + 2 * m : 1 + 2 * m + n] - off[:, :1]
        change = np.concatenate([0.5 * (off[:, more] - off[:, less]), later], axis=1).transpose(0, 2, 1)
        residual = off[:, 0] + change[..., m:] @ (ticks % 1.0)
        if self._delay is not None:
            nudges[self._delay] = self._step_s / self.found[self._delay].spread
            change[..., self._delay] = off[:, 1 + self._delay] - off[:, 0]
            residual += change[..., self._delay] * (delay % 1.0)
            change[..., self._delay] += change[..., m:].sum(axis=-1)
        return residual, np.nan_to_num(change / nudges)

    def _misses(self, part: Part, delay_ticks: int, shift_ticks: NDArray[np.int64]) -> Floats:
        """Return the differences (r, members, 12) between the simulated and the measured motion."""
        efforts = part.commands.efforts(delay_ticks, shift_ticks, part.steps)
        variant = np.zeros(self._members, np.intp)
        if self._delay is not None:
            variant[1 + self._delay] = 1
        first = 1 + 2 * self._moved
        variant[first : first + part.shifts] = 2 + np.arange(part.shifts)
        log = self._log
        changed = np.flatnonzero((np.diff(efforts, axis=0) != 0).any(axis=(1, 2))) + 1
        states = np.zeros((len(part.ticks), self._members, 13))
        sample = 0
        begins = np.unique([0, *changed, *part.ticks, part.steps])
        for begin, end in zip(begins, [*begins[1:], None], strict=True):
            if sample < len(part.ticks) and part.ticks[sample] == begin:
                motion = self._batch.observe()
                states[sample] = np.hstack([motion.position_world_m, motion.orientation_xyzw, motion.velocity_body])
                sample += 1
            if end is not None:
                command(self._batch, log.thrusters, efforts[begin, variant])
                self._batch.step(int(end - begin))
        at, share = self._compared(part.rows, states[part.low]), part.share[:, None, None]
        return at if (part.low == part.high).all() else at + share * (self._compared(part.rows, states[part.high]) - at)

    def _compared(self, rows: Indices, states: Floats) -> Floats:
        """Return the differences (r, members, 12) of states (r, members, 13) from the measured rows."""
        log = self._log
        turned = Rotation.from_quat(states[..., 3:7].reshape(-1, 4))
        measured = Rotation.from_quat(np.repeat(log.orientation_xyzw[rows], self._members, axis=0))
        off = (measured.inv() * turned).as_rotvec().reshape(len(rows), self._members, 3)
        off[..., [TILT.index(name) for name in log.unstated]] = np.nan
        position = states[..., :3] - (log.position_m[rows] + self._origin_m)[:, None]
        return np.concatenate([position, off, states[..., 7:] - log.velocity_body[rows][:, None]], axis=-1)

    def _measured_start(self, row: np.intp) -> Floats:
        """Return the measured state (13,) in a row; 0 for coordinates and velocities that were not measured."""
        log = self._log
        position_m = log.position_m[row] + self._origin_m
        position_m = np.where(np.isfinite(position_m), position_m, self._start_m)
        return np.concatenate([position_m, log.orientation_xyzw[row], np.nan_to_num(log.velocity_body[row])])

    def _placed(self, segment: int, start: Floats) -> Floats:
        state, shift = self._begin[segment], START_SPREADS * start
        attitude = (Rotation.from_quat(state[3:7]) * Rotation.from_rotvec(shift[3:6])).as_quat()
        return np.concatenate([state[:3] + shift[:3], attitude, state[7:] + shift[6:]])


def parts_of(log: MotionLog, unknowns: int, segment_s: float, most: int | None, step_s: float = STEP_S) -> list[Part]:
    """Return the segments of a log, each of which begins at a row; stretches without rows have none."""
    times_s = log.times_s
    count = max(1, round(float(times_s[-1] - times_s[0]) / segment_s))
    length_s = float(times_s[-1] - times_s[0]) / count
    own = np.minimum(((times_s - times_s[0]) / length_s).astype(np.int64), count - 1)
    groups = np.split(np.arange(len(times_s)), np.flatnonzero(np.diff(own)) + 1)
    if most is not None and len(groups) > most:
        groups = [groups[k] for k in np.linspace(0, len(groups) - 1, most).round().astype(int)]
    sds_s = np.broadcast_to(np.asarray(log.effort_sds_s, np.float64), log.effort_times_s.shape)
    parts, column = [], unknowns
    for k, rows in enumerate(groups):
        start_s = float(times_s[rows[0]])
        ticks = (times_s[rows] - start_s) / step_s
        low = np.floor(ticks + 1e-3).astype(int)
        share = np.maximum(ticks - low, 0.0)
        share[share < 1e-3] = 0.0
        samples, place = np.unique(np.concatenate([low, low + (share > 0)]), return_inverse=True)
        after = groups[k + 1][0] if k + 1 < len(groups) and groups[k + 1][0] == rows[-1] + 1 else rows[-1]
        steps = max(int(samples[-1]), min(round((times_s[after] - start_s) / step_s), int(samples[-1]) + 1000))
        end_s = float(times_s[rows[-1]])
        commands = command_times.segment_of(log.effort_times_s, log.efforts, sds_s, start_s, end_s, step_s)
        own_columns = np.arange(column, column + OUTPUTS + len(commands.shifting))
        column += len(own_columns)
        columns = np.concatenate([np.arange(unknowns), own_columns])
        halves = place[: len(low)], place[len(low) :]
        parts.append(Part(rows, start_s, steps, commands, samples, *halves, share, columns))
    return parts


def _first(position_m: Floats) -> Floats:
    """Return the first known value of each coordinate, 0 if none is known."""
    known = np.isfinite(position_m)
    return np.where(known.any(axis=0), position_m[np.argmax(known, axis=0), [0, 1, 2]], 0.0)
