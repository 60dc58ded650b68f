"""Creates the cameras on vehicles and on the station."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from uwsim import _core
from uwsim.base.quaternions import about_z
from uwsim.instruments.cameras.camera import Camera
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
