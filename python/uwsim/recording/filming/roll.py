"""Roll: what a scene's cameras need to know of a recorded run, at the time of each frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.agenda import NEVER, Rank
from uwsim.instruments.cameras import Camera
from uwsim.instruments.cameras.shared_scene import SharedScene, Snapshot
from uwsim.recording.filming.options import FilmOptions
from uwsim.recording.replay import replay
from uwsim.simulator.simulator import Simulator


def scene_of(sim: Simulator) -> SharedScene:
    """Return the scene of a simulator's cameras, even if it has none."""
    return sim._shared_scene


class Roll:
    """The states of a run at the times of its frames, with one more after the last.

    sim: the simulator that repeats it. states: snapshots, in order. camera: the one that is followed, or None. poses:
    (n, 7), its own: position and orientation x, y, z, w.
    """

    def __init__(self, from_s: float, until_s: float, fps: float, camera: str | None, vehicle: str | None) -> None:
        """camera: the vehicle's camera whose poses are kept, or None. vehicle: its name; by default the first."""
        self.states: list[Snapshot] = []
        self.poses: NDArray[np.float64] = np.empty((0, 7))
        self.due_tick = NEVER
        self._from_s, self._until_s, self._fps, self._names = from_s, until_s, fps, (camera, vehicle)
        self._poses: list[NDArray[np.float64]] = []

    @classmethod
    def of(cls, recording: Path, wanted: FilmOptions) -> Roll:
        """Repeat a recorded run; return its roll.

        Raises ValueError if the run cannot be repeated bit for bit, or has no two states between the times; OSError.
        """
        from_s, until_s, fps = wanted.from_s, wanted.until_s, wanted.fps
        roll = cls(from_s, until_s, fps, wanted.carried_camera, wanted.vehicle)
        result = replay(recording, until_s=until_s + 1.0 / fps, on_start=roll.attach)
        if result.difference is not None:
            raise ValueError(f"recording '{recording}': {result.difference}")
        if len(roll.states) < 2:
            rule = f"has less than a frame between from = {from_s:g} s and until = {until_s:g} s"
            raise ValueError(
                f"recording '{recording}': " + (rule if roll.states else f"ends before from = {from_s:g} s")
            )
        roll.poses = np.array(roll._poses).reshape(-1, 7)
        return roll

    def attach(self, sim: Simulator) -> None:
        """Start to collect. Raises ValueError for an unknown vehicle or camera."""
        name, vehicle = self._names
        if vehicle is not None and vehicle not in sim.vehicles:
            raise ValueError(f"vehicle = '{vehicle}': must be one of {', '.join(sim.vehicles)}")
        self.sim, self._vehicle = sim, sim.rov if vehicle is None else sim.vehicles[vehicle]
        if name is not None and name not in self._vehicle.cameras:
            others = ", ".join(dict.fromkeys(("chase", "orbit", *self._vehicle.cameras, "a CSV file")))
            raise ValueError(f"camera = '{name}': must be one of {others}")
        self.camera: Camera | None = None if name is None else self._vehicle.cameras[name]
        self.due_tick = max(round(self._from_s / sim.step_s), sim.tick)
        sim.agenda.add(self, Rank.OBSERVER, self._take, jump=self._end)

    @property
    def vehicle(self) -> int:
        """The index of the vehicle among those of a snapshot."""
        return list(self.sim.vehicles).index(self._vehicle.name)

    def _take(self, tick: int) -> None:
        self.states.append(scene_of(self.sim).snapshot(with_lamps=True))
        if self.camera is not None:
            self._poses.append(np.concatenate(self.camera.pose))
        due_s = self._from_s + len(self.states) / self._fps
        self.due_tick = NEVER if due_s > self._until_s + 1e-9 else max(round(due_s / self.sim.step_s), tick + 1)

    def _end(self, tick: int) -> None:
        self.due_tick = NEVER  # time was reset: the film ends
