"""Simulates the outputs of a log, and their derivatives, in one batch of simulations."""

from __future__ import annotations

import tempfile
from itertools import product
from pathlib import Path
from shutil import rmtree
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.batch import Batch
from uwsim.evidence.identification.motion_log import MotionLog
from uwsim.evidence.identification.unknowns import Unknown, parameters_at
from uwsim.scenario import Scenario, VehicleModel

Array = NDArray[np.float64]
VEHICLE = "vehicle"
DEPTH_M, BED_M = 400.0, 1000.0
STEP_S = 0.005
START_SPREADS = np.repeat((0.5, 0.2, 0.5, 0.5), 3)  # of a segment's initial state [m, rad, m/s, rad/s]
OUTPUTS = 12
DIFFERENCE = 1e-5
BOX = (
    (1, 2, 4), (1, 4, 3), (5, 8, 6), (5, 7, 8), (1, 6, 2), (1, 5, 6),
    (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4),
)  # fmt: skip
"""The triangles of a box, outward, with its corners in binary order."""


class Flown:
    """Simulates a log for given values of the unknowns, in segments that each have their own initial state.

    z has the unknowns, in standard deviations of their priors, then 12 entries for the start of each segment.
    """

    def __init__(
        self,
        model: VehicleModel,
        log: MotionLog,
        found: list[Unknown],
        segment_s: float,
        density_kg_m3: float,
        threads: int | None = None,
    ):
        """segment_s: approximate length of a segment. density_kg_m3: density of the water."""
        self.found, self._log = found, log
        every_s = min(max(float(np.median(np.diff(log.times_s))), STEP_S), 0.1)
        self._steps = max(round(every_s / STEP_S), 1)
        self._every_s = self._steps * STEP_S
        duration_s = float(log.times_s[-1] - log.times_s[0])
        self.segments = max(1, round(duration_s / segment_s))
        length_s = duration_s / self.segments
        self._starts_s = log.times_s[0] + length_s * np.arange(self.segments)
        self._count = int(np.ceil(length_s / self._every_s)) + 1
        own = np.minimum(((log.times_s - log.times_s[0]) / length_s).astype(int), self.segments - 1)
        self._rows = [np.flatnonzero(own == k) for k in range(self.segments)]
        self._origin_m = np.array([0.0, 0.0, -DEPTH_M]) - _first(log.position_m)
        self.size = len(found) + OUTPUTS * self.segments
        self._members = 1 + len(found) + OUTPUTS
        self._last_z, self._last = np.empty(0), (np.empty(0), np.empty(0))
        folder = Path(tempfile.mkdtemp(prefix="uwsim-"))
        finalize(self, rmtree, folder, ignore_errors=True)  # members reread the hull when its centre changes
        bare = _bare(model, folder)
        scenario = Scenario.model_validate(
            {
                "name": "identification",
                "step_s": STEP_S,
                "water": {"density_kg_m3": density_kg_m3},
                "terrain": {"source": "noise", "size_m": [1000, 1000], "spacing_m": 100, "bed_depth_m": BED_M},
                "station": {"position_m": [0, 0, 0]},
                "vehicles": [{"name": VEHICLE, "model": bare, "start": {"position_m": [0, 0, -DEPTH_M]}}],
            }
        )
        self._batch = Batch(scenario, n=self._members, threads=threads)
        self._begin = [self._measured_start(rows) for rows in self._rows]
        grid_s = self._starts_s[:, None] + self._every_s * np.arange(self._count)
        self._efforts = np.array([log.efforts_at(row) for row in grid_s])  # (segments, count, 6)

    def outputs(self, z: Array) -> tuple[Array, Array]:
        """Return residuals (n, 12) against the log, NaN where it has none, and their derivatives (n, 12, size).

        Columns: position [m], attitude [rad], velocity [m/s], rate [rad/s]. The result for the last z is cached. Raises
        ValueError if a motion diverges.
        """
        if not np.array_equal(z, self._last_z):
            self._last, self._last_z = self._simulated(z), z.copy()
        return self._last

    def _simulated(self, z: Array) -> tuple[Array, Array]:
        p = len(self.found)
        values = np.tile(z[:p], (self._members, 1))
        values[1 : p + 1] += DIFFERENCE * np.eye(p)
        each = [parameters_at(self.found, row) for row in values]
        self._batch.reset(parameters=each)
        states = np.zeros((self._count, self.segments, self._members, 13))
        for k in range(self.segments):  # thrusters continue from the previous segment's commands
            start = z[p + OUTPUTS * k : p + OUTPUTS * (k + 1)]
            placed = np.tile(self._placed(k, start), (self._members, 1))
            placed[p + 1 :] = [self._placed(k, start + nudge) for nudge in DIFFERENCE * np.eye(OUTPUTS)]
            self._batch.place(placed[:, :3], placed[:, 3:7], placed[:, 7:])
            for index in range(self._count):
                motion = self._batch.observe()
                states[index, k] = np.hstack([motion.position_world_m, motion.orientation_xyzw, motion.velocity_body])
                if index + 1 < self._count:
                    self._batch.step(self._steps, np.tile(self._efforts[k, index], (self._members, 1)))
        return self._compared(states)

    def _compared(self, states: Array) -> tuple[Array, Array]:
        p, log = len(self.found), self._log
        n = len(log.times_s)
        found, slopes = np.full((n, OUTPUTS), np.nan), np.zeros((n, OUTPUTS, self.size))
        for k, rows in enumerate(self._rows):
            at = (log.times_s[rows] - self._starts_s[k]) / self._every_s
            low = np.clip(np.floor(at + 1e-9).astype(int), 0, self._count - 2)
            share = np.clip(at - low, 0.0, 1.0)[:, None, None]
            first, second = states[low, k], states[low + 1, k]
            flip = np.sign(np.einsum("rmq,rmq->rm", first[..., 3:7], second[..., 3:7]))[..., None]
            second = np.concatenate([second[..., :3], flip * second[..., 3:7], second[..., 7:]], axis=-1)
            between = (1 - share) * first + share * second
            turned = Rotation.from_quat(between[..., 3:7].reshape(-1, 4))
            measured = Rotation.from_quat(np.repeat(log.orientation_xyzw[rows], self._members, axis=0))
            off = (measured.inv() * turned).as_rotvec().reshape(len(rows), self._members, 3)
            position = between[..., :3] - (log.position_m[rows] + self._origin_m)[:, None]
            velocity = between[..., 7:] - log.velocity_body[rows][:, None]
            residual = np.concatenate([position, off, velocity], axis=-1)  # (rows, members, 12)
            found[rows] = residual[:, 0]
            derivative = np.nan_to_num((residual[:, 1:] - residual[:, :1]) / DIFFERENCE).transpose(0, 2, 1)
            slopes[rows, :, :p] = derivative[..., :p]
            slopes[rows, :, p + OUTPUTS * k : p + OUTPUTS * (k + 1)] = derivative[..., p:]
        return found, slopes

    def _measured_start(self, rows: NDArray[np.intp]) -> Array:
        """Return the measured state (13,) at the start of a segment; 0 for velocities that were not measured."""
        log, first = self._log, rows[0]
        position_m = np.nan_to_num(log.position_m[first] + self._origin_m, nan=0.0)
        if not np.isfinite(log.position_m[first]).all():
            position_m = np.array([0.0, 0.0, -DEPTH_M])
        return np.concatenate([position_m, log.orientation_xyzw[first], np.nan_to_num(log.velocity_body[first])])

    def _placed(self, segment: int, start: Array) -> Array:
        state, shift = self._begin[segment], START_SPREADS * start
        attitude = (Rotation.from_quat(state[3:7]) * Rotation.from_rotvec(shift[3:6])).as_quat()
        return np.concatenate([state[:3] + shift[:3], attitude, state[7:] + shift[6:]])


def _bare(model: VehicleModel, folder: Path) -> VehicleModel:
    """Return the vehicle without instruments; if its volume is published, its hull is replaced by a box of that volume.

    Deep under water, only the volume of a hull and its centre matter.
    """
    update: dict[str, Any] = {"sensors": {}, "sonar": None, "imaging_sonars": {}, "cameras": {}, "trim": None}
    if model.volume_m3 is not None and model.centre_of_buoyancy_m is not None:
        side_m = model.volume_m3 ** (1 / 3)
        corners = [
            [c + side_m * (bit - 0.5) for c, bit in zip(model.centre_of_buoyancy_m, bits, strict=True)]
            for bits in product((0, 1), repeat=3)
        ]
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in BOX]
        path = folder / "box.obj"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        update |= {"mesh": path, "collision": "hull", "collision_pieces": None}
    return model.model_copy(update=update)


def _first(position_m: Array) -> Array:
    known = np.isfinite(position_m).all(axis=1)
    return np.asarray(position_m[np.argmax(known)] if known.any() else np.zeros(3), np.float64)
