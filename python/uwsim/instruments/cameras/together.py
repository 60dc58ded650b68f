"""Pictures from one camera of several simulators of a scenario, rendered in one native call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.instruments.cameras.camera import Camera
from uwsim.instruments.cameras.lens import Lens
from uwsim.scenario.build.camera import core_lamp, core_optics, mount_orientation_xyzw
from uwsim.scenario.spec.camera import CameraMount, Lamps

MOST_KEPT = 4096


class Together:
    """Takes pictures with the cameras of several simulators, and keeps the lenses that they share.

    size: (height, width) of the pictures; None for the cameras' own, which must be equal.
    """

    def __init__(self, size: tuple[int, int] | None) -> None:
        lenses: dict[tuple[str, CameraMount], Lens] = {}

        def lens(mount: CameraMount, name: str) -> _core.Camera:
            key = name, mount if size is None else mount.resized(size[1], size[0])
            return lenses.setdefault(key, Lens(*key)).core

        self._size = size
        self._lens = _Once(lens)
        self._optics = _Once(core_optics)
        self._lamps = _Once(_mounted)

    def capture(
        self,
        cameras: Sequence[Camera],
        positions_m: Floats,
        orientations_xyzw: Floats,
        times_ns: Sequence[int],
        effects: list[str],
        threads: int,
    ) -> NDArray[np.uint8]:
        """Return n pictures, (n, H, W, 3) uint8: the same bytes as the `rgb` of each camera's `capture`.

        cameras: n, of the same name on the same vehicle. positions_m (n, v, 3), orientations_xyzw (n, v, 4): of all
        vehicles. Raises ValueError as `capture` does, naming the camera's index, as in batch[3].
        """
        has_lamps, moves = "lamps" in effects, "shutter" in effects
        if has_lamps and any(camera.scene.fixed_lights for camera in cameras):  # render_many mounts lamps on vehicles
            return np.stack([self._alone(camera, effects, threads) for camera in cameras])
        scenes = [camera.scene if camera.mount.on else None for camera in cameras]
        positions, orientations = _poses(cameras, positions_m, orientations_xyzw)
        velocities = np.zeros((len(cameras), 6))
        for k, camera in enumerate(cameras):
            if moves and (camera.mount.shutter_ms or camera.mount.readout_ms):
                velocities[k] = camera.velocity(camera.snapshot())
        return _core.render_many(
            [None if scene is None else scene.core for scene in scenes],
            [self._lens(camera.mount, camera.name) for camera in cameras],
            [self._optics(camera.scene.optics) for camera in cameras],
            positions,
            orientations,
            times_ns,
            effects,
            [
                [
                    (vehicle, spot)
                    for vehicle, switches in enumerate(camera.scene.lamps if has_lamps else ())
                    for lamp in switches.values()
                    if lamp.on
                    for spot in self._lamps(lamp.spec)
                ]
                for camera in cameras
            ],
            positions_m,
            orientations_xyzw,
            cameras[0].hidden,
            velocities,
            threads,
        )

    def _alone(self, camera: Camera, effects: list[str], threads: int) -> NDArray[np.uint8]:
        sized = camera if self._size is None else camera.resized(self._size[1], self._size[0])
        return sized.capture(effects, threads=threads).rgb


def _poses(cameras: Sequence[Camera], positions_m: Floats, orientations_xyzw: Floats) -> tuple[Floats, Floats]:
    """Return the cameras' positions (n, 3) and orientations (n, 4)."""
    carrier = cameras[0].carrier
    if cameras[0].mount.follows == "heading" or not isinstance(carrier, int):
        each = [camera.pose for camera in cameras]
        return np.array([position for position, _ in each]), np.array([turn for _, turn in each])
    places, turns = np.empty((len(cameras), 3)), np.empty((len(cameras), 4))
    latest: tuple[Any, ...] = ()
    for k, camera in enumerate(cameras):  # most cameras share a mount and an aim
        now = camera.mount.yaw_pitch_roll_deg, camera.aim_rad
        if now != latest:
            latest, turn = now, camera.mounting_xyzw()
        places[k], turns[k] = camera.mount.position_m, turn
    return _core.mounted_poses(positions_m[:, carrier], orientations_xyzw[:, carrier], places, turns)


def _mounted(lamps: Lamps) -> list[_core.SpotLamp]:
    """Return the lamps of one switch in the vehicle's frame."""
    return [
        core_lamp(lamps, np.array(spot.position_m), mount_orientation_xyzw(spot.yaw_pitch_roll_deg))
        for spot in lamps.spots
    ]


class _Once:
    """Calls a function once per first argument, compared by identity, since hashing models would take longer."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self._make = make
        self._made: dict[int, tuple[object, Any]] = {}

    def __call__(self, key: object, *others: object) -> Any:
        made = self._made.get(id(key))
        if made is None:
            if len(self._made) >= MOST_KEPT:
                self._made.clear()
            made = self._made[id(key)] = key, self._make(key, *others)
        return made[1]
