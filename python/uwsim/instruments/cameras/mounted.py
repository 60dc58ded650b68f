"""Creates the cameras on vehicles and on the station; saves and restores the states of lamps and camera motors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from uwsim import _core
from uwsim.base.named import require_names
from uwsim.base.quaternions import about_z
from uwsim.instruments.cameras.camera import Camera
from uwsim.instruments.cameras.lamp import Lamp
from uwsim.instruments.cameras.pan_tilt import Motion, PanTiltHead
from uwsim.instruments.cameras.shared_scene import SharedScene
from uwsim.scenario.build.camera import chase_camera
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.settings import Station
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import VehicleEntry


def vehicle_cameras(vehicle: VehicleEntry, index: int, scene: SharedScene) -> dict[str, Camera]:
    """Return a vehicle's cameras, keyed by name: those in its file, plus "chase".

    index: the vehicle's index in the simulation.
    """
    return {
        key: Camera(_core.stream_name(vehicle.name, key), mount, scene, index, owner=vehicle.name, key=key)
        for key, mount in camera_mounts(vehicle.model).items()
    }


def camera_mounts(model: VehicleModel) -> Mapping[str, CameraMount]:
    """Return the mounts of a vehicle's cameras, keyed by camera name."""
    return {"chase": chase_camera(model), **model.cameras}


def change_cameras(cameras: Mapping[str, Camera], mounts: Mapping[str, CameraMount]) -> None:
    """Replace the mounts of cameras, given by camera name."""
    for name, mount in mounts.items():
        cameras[name].change(mount)


def station_cameras(station: Station, scene: SharedScene) -> dict[str, Camera]:
    """Return the station's cameras, keyed by name."""
    pose = np.asarray(station.position_m), about_z(math.radians(station.yaw_deg))
    return {name: Camera(name, mount, scene, pose) for name, mount in station.cameras.items()}


class SavedLamps:
    """Saves which lamps are on, by vehicle and name."""

    STATE: ClassVar[Any] = dict[str, dict[str, bool]]

    def __init__(self, lamps: Mapping[str, Mapping[str, Lamp]]) -> None:
        self._lamps = lamps

    def save(self) -> dict[str, dict[str, bool]]:
        """Return the state as JSON values."""
        return {vehicle: {name: lamp.on for name, lamp in lamps.items()} for vehicle, lamps in self._lamps.items()}

    def restore(self, state: Mapping[str, Mapping[str, bool]]) -> None:
        """Continue from the result of `save`. Raises ValueError if the saved lamps differ from these."""
        require_names("lamps", _paths(state), _paths(self._lamps))
        for vehicle, lit in state.items():
            for name, on in lit.items():
                self._lamps[vehicle][name].set_silently(on)


class SavedHeads:
    """Saves the motion of cameras that have a motor, by name."""

    STATE: ClassVar[Any] = dict[str, Motion]

    def __init__(self, heads: Mapping[str, PanTiltHead]) -> None:
        self._heads = heads

    def save(self) -> dict[str, Any]:
        """Return the state as JSON values."""
        return {name: head.save() for name, head in self._heads.items()}

    def restore(self, state: Mapping[str, Motion]) -> None:
        """Continue from the result of `save`. Raises ValueError if the saved cameras differ from these."""
        require_names("cameras", state, self._heads)
        for name, motion in state.items():
            self._heads[name].restore(motion)


def _paths(lamps: Mapping[str, Mapping[str, object]]) -> list[str]:
    return [f"{vehicle}/{name}" for vehicle, named in lamps.items() for name in named]
