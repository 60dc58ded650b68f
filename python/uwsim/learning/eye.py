"""Pictures as part of observations, taken by a single camera that moves from member to member."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from uwsim.base.did_you_mean import did_you_mean
from uwsim.batch import Batch
from uwsim.instruments.cameras.shared_scene import Snapshot
from uwsim.learning.options import EpisodeOptions
from uwsim.scenario import Scenario
from uwsim.scenario.spec.fault import CameraFault
from uwsim.simulator.simulator import Simulator

EFFECTS = ("attenuation", "backscatter", "sunlight", "lamps", "distortion", "exposure", "noise")


class Eye:
    """A simulator camera that takes pictures from the poses of all members.

    Image noise depends on the scenario's seed and the member's time, not on the member's seed. All members share the
    light of the scenario.
    """

    def __init__(self, scenario: Scenario, options: EpisodeOptions, threads: int) -> None:
        self._sim = Simulator(scenario, threads=1)
        cameras = self._sim.rov.cameras
        if options.camera is None or options.camera not in cameras:
            known = f"must be one of {', '.join(cameras)}{did_you_mean(str(options.camera), list(cameras))}"
            raise ValueError(f"camera = {options.camera!r}: {known}")
        self._camera, self._name = cameras[options.camera], options.camera
        self.height, self.width = options.camera_size
        self._camera.change(self._camera.mount.model_copy(update={"width": self.width, "height": self.height}))
        self._first = self._camera.snapshot()
        self._names = list(self._sim.vehicles)
        self._threads = threads

    @property
    def space(self) -> Box:
        """The Gymnasium space of one picture."""
        return Box(0, 255, (self.height, self.width, 3), np.uint8)

    def pictures(self, batch: Batch) -> NDArray[np.uint8]:
        """Return the pictures (n, height, width, 3) of all members."""
        motions = [batch.observe(name) for name in self._names]
        positions = np.stack([motion.position_world_m for motion in motions], axis=1)
        orientations = np.stack([motion.orientation_xyzw for motion in motions], axis=1)
        velocities = np.stack([motion.velocity_body for motion in motions], axis=1)
        first = self._first
        snapshots = [
            Snapshot(
                time_ns, positions[k], orientations[k], velocities[k], self._lights(positions[k], orientations[k]),
                first.optics, first.aims_rad,
            )
            for k, time_ns in enumerate(motions[0].time_ns.tolist())
        ]  # fmt: skip
        pictures = self._camera.capture_many(snapshots, EFFECTS, threads=self._threads)
        self._blacken(pictures, batch)
        return pictures

    def _blacken(self, pictures: NDArray[np.uint8], batch: Batch) -> None:
        """Blacken the pictures of members whose camera has failed."""
        for k, faults in enumerate(batch.faults):
            if any(isinstance(fault, CameraFault) for fault in faults):
                pictures[k] *= batch.aboard(k).camera_is_on(self._names[0], self._name)

    def _lights(self, positions: Any, orientations: Any) -> list[Any]:
        return [
            light
            for position, orientation, rov in zip(positions, orientations, self._sim.vehicles.values(), strict=True)
            for lamp in rov.lamps.values()
            if lamp.on
            for light in lamp.lights(position, orientation)
        ]


def look(space: Space[Any], eye: Eye | None) -> Space[Any]:
    """Return the observation space, including the eye's pictures if there is an eye."""
    if eye is None:
        return space
    parts = dict(space.spaces) if isinstance(space, Dict) else {"state": space}
    return Dict({**parts, "camera": eye.space})
