"""The instruments of a batch. Each call reads an instrument of one vehicle in every member."""

from __future__ import annotations

from collections.abc import Callable, Collection
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.named import did_you_mean
from uwsim.batch.arguments import whole
from uwsim.batch.commands import CommandedBatch
from uwsim.batch.members import Members
from uwsim.batch.results import (
    BatchEstimate,
    BatchJoints,
    BatchMotion,
    BatchObject,
    BatchPings,
    BatchSamples,
    Buffers,
    motion_buffers,
    ping_buffers,
    sample_buffers,
)
from uwsim.instruments.cameras.effects import effects_on
from uwsim.instruments.cameras.together import Together
from uwsim.scenario import Scenario
from uwsim.scenario.spec.camera import LARGEST_SIDE
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind


class InstrumentedBatch(CommandedBatch):
    """The part of uwsim.Batch that reads instruments. vehicle: by default each member's first. Raises ValueError."""

    scenario: Scenario
    threads: int
    _members: Members

    def _make_buffers(self) -> None:
        self._motion = [motion_buffers(self.n) for _ in self._names]
        self._together: dict[tuple[int, int] | None, Together] = {}
        self._samples: dict[tuple[int, int], Buffers[BatchSamples]] = {}
        self._pings: dict[tuple[int, int, bool], Buffers[BatchPings]] = {}

    @property
    def time_s(self) -> NDArray[np.float64]:
        """The time of each member since its start, (n,) [s]."""
        return self.observe().time_ns.astype(np.float64) * 1e-9

    def observe(self, vehicle: str | None = None) -> BatchMotion:
        """Return the true motion of a vehicle (by default the first) in each member."""
        index = self._vehicle(vehicle)
        motion = self._motion[index]
        self._core.motion(index, *motion.writable)
        return motion.shown

    def observe_object(self, name: str) -> BatchObject:
        """Return the true motion of one of the scenario's `objects` in each member."""
        names = [body.name for body in self.scenario.objects]
        if name not in names:
            rule = f"must be one of {', '.join(names)}" if names else "the scenario has none"
            raise ValueError(f"object = {name!r}: {rule}{did_you_mean(str(name), names)}")
        states = [self._core.member(k).object_state(names.index(name)) for k in range(self.n)]
        return BatchObject(
            np.array([state.position_world_m for state in states]),
            np.array([state.orientation_xyzw for state in states]),
            np.array([state.velocity_body for state in states]),
        )

    def read_joints(self, body: str | None = None) -> BatchJoints:
        """Return the joints of an arm, or of an object's links, in each member, like Arm.read.

        body: a vehicle, by default the first, or an object.
        """
        carried = {entry.name: entry.model.arm for entry in self.scenario.vehicles}
        carried |= {one.name: one.links for one in self.scenario.objects}
        name = self._names[0] if body is None else body
        known = [one for one, links in carried.items() if links]
        if name not in known:
            rule = f"must be one of {', '.join(known)}" if known else "nothing has joints"
            raise ValueError(f"body = {name!r}: {rule}{did_you_mean(str(name), known)}")
        index, links = [*carried].index(name), carried[name] or {}
        readings = [self._core.member(k).arm(index) for k in range(self.n)]
        moving = [k for k, one in enumerate(readings[0].names) if links[one].hinge or links[one].slide]
        names = tuple(readings[0].names[k] for k in moving)
        values = (
            np.array([getattr(one, what) for one in readings])[:, moving]
            for what in ("positions", "speeds", "motor_torques")
        )
        return BatchJoints(names, *values)

    def read(self, sensor: str, vehicle: str | None = None, *, noise: bool = True) -> BatchSamples:
        """Return the latest sample from a sensor in each member, like Sensor.read."""
        index = self._vehicle(vehicle)
        sensors = self._members.vehicles[index].sensors
        names = [spec.name for spec in sensors]
        if sensor not in names:
            rule = f"must be one of {', '.join(names)}{did_you_mean(str(sensor), names)}"
            raise ValueError(f"{self._names[index]}.sensors[{sensor!r}]: {rule}")
        key = index, names.index(sensor)
        if isinstance(sensor_kind(self.scenario.vehicles[index].model.sensors[sensor].kind), DerivedKind):
            rule = "is of a kind in Python: read it in batch.aboard(k)"
            raise ValueError(f"{self._names[index]}.sensors[{sensor!r}]: {rule}")
        if key not in self._samples:
            self._samples[key] = sample_buffers(self.n, _core.sensor_kind(sensors[key[1]].kind).fields)
        samples = self._samples[key]
        self._core.read_sensor(*key, noise, *samples.writable)
        self._programs.convert(*key, noise, samples)
        return samples.shown

    def ping(self, vehicle: str | None = None) -> BatchPings:
        """Ping with a vehicle's first sonar in each member. In physics mode, return BatchPhysicsPings.

        The sonars of all members must have the same number of beams and the same mode. Raises ValueError.
        """
        index = self._vehicle(vehicle)
        if not self._members.vehicles[index].sonars:
            raise ValueError(f"vehicle '{self._names[index]}': carries no sonar")
        modes = self._core.in_physics_mode(index, 0)
        in_physics_mode = modes[0]
        if in_physics_mode in modes and (not in_physics_mode) in modes:
            other = f"another in batch[{modes.index(not in_physics_mode)}] than in batch[0]"
            raise ValueError(f"{self._names[index]}.sonar.mode: {other}: a batch pings in one mode")
        key = index, self._core.beams(index, 0), in_physics_mode
        if key not in self._pings:
            self._pings[key] = ping_buffers(self.n, key[1], in_physics_mode)
        pings = self._pings[key]
        (self._core.acoustic_ping if in_physics_mode else self._core.ping)(index, 0, *pings.writable)
        return pings.shown

    def estimate(self, vehicle: str | None = None) -> BatchEstimate:
        """Return a vehicle's motion in each member as estimated by its instruments; see Vehicle.estimate.

        The first call starts the filters, which process their samples in Python, one member after another.
        """
        name = self._names[self._vehicle(vehicle)]
        navigators = [self.aboard(k).vehicles[name].estimate for k in range(self.n)]
        poses, velocities = [one.pose for one in navigators], [one.velocity for one in navigators]
        return BatchEstimate(
            np.array([one.time_s for one in navigators]),
            np.array([pose.position_world_m for pose in poses]),
            np.array([pose.orientation_xyzw for pose in poses]),
            np.array([[*velocity.linear_body_m_s, *velocity.angular_body_rad_s] for velocity in velocities]),
            np.array([one.covariance for one in navigators]),
        )

    def image(
        self, sonar: str, *arguments: Any, vehicle: str | None = None, with_labels: bool = False
    ) -> tuple[Any, ...]:
        """Ping with an imaging sonar in each member, like ImagingSonar.ping, and return one result per member.

        sonar: the sonar's name in the vehicle file. arguments: depend on the kind of sonar, such as the angles of a
        single beam. The results are SonarImage, Waterfall or Profiles. Raises ValueError.
        """
        name = self._names[self._vehicle(vehicle)]
        later = [
            self.aboard(k).vehicles[name].imaging_sonars[sonar].later(*arguments, with_labels=with_labels)
            for k in range(self.n)
        ]
        with ThreadPoolExecutor(self.threads) as pool:
            return tuple(pool.map(_called, later))

    def capture(
        self,
        camera: str,
        effects: str | Collection[str] = "on",
        *,
        without: Collection[str] = (),
        size: tuple[int, int] | None = None,
        vehicle: str | None = None,
    ) -> NDArray[np.uint8]:
        """Return a picture from a camera in each member, (n, height, width, 3) uint8 sRGB, like Camera.capture.

        size: (height, width), by default the camera's. Each picture has the light, lamps, aim and seed of its member;
        it is black where the camera is off. All members' pictures share the threads. Raises ValueError.
        """
        index = self._vehicle(vehicle)
        members = [self.aboard(k) for k in range(self.n)]
        cameras = [member.vehicles[self._names[index]].cameras[camera] for member in members]
        motions = [self.observe(name) for name in self._names]
        poses = [[member.objects[body.name].pose for member in members] for body in self.scenario.objects]
        positions = [np.array([pose.position_world_m for pose in each]) for each in poses]
        orientations = [np.array([pose.orientation_xyzw for pose in each]) for each in poses]
        attached = np.stack([one.scene.attached_surfaces() for one in cameras])
        if size not in self._together:
            self._together[size] = Together(_checked_size(size))
        off = effects_on(without)
        return self._together[size].capture(
            cameras,
            np.concatenate(
                [np.stack([*(one.position_world_m for one in motions), *positions], axis=1), attached[..., :3]], 1
            ),
            np.concatenate(
                [np.stack([*(one.orientation_xyzw for one in motions), *orientations], axis=1), attached[..., 3:]], 1
            ),
            motions[0].time_ns.tolist(),
            [name for name in effects_on(effects) if name not in off],
            self.threads,
        )


def _checked_size(size: tuple[int, int] | None) -> tuple[int, int] | None:
    for side, pixels in zip(("height", "width"), size or (), strict=False):
        whole(pixels, f"size: {side}", 1, LARGEST_SIDE)
    return size


def _called(work: Callable[[], Any]) -> Any:
    return work()
