"""Parsing of --pose: X,Y,Z[,YAW[,PITCH[,ROLL]]]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

POSE_FIELDS = ("X", "Y", "Z", "YAW", "PITCH", "ROLL")


def parsed_pose(text: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Parse a pose in metres and degrees; return position (3,) [m] and quaternion (4,), x, y, z, w.

    Raises ValueError.
    """
    rule = "must be X,Y,Z[,YAW[,PITCH[,ROLL]]]: metres, and degrees about z, y (positive: nose down) and x"
    try:
        figures = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise ValueError(f"--pose {text}: {rule}") from error
    if not 3 <= len(figures) <= len(POSE_FIELDS):
        raise ValueError(f"--pose {text}: {len(figures)} numbers; {rule}")
    if not np.isfinite(figures).all():
        raise ValueError(f"--pose {text}: must be finite")
    figures += [0.0] * (len(POSE_FIELDS) - len(figures))
    turn = Rotation.from_euler("ZYX", figures[3:], degrees=True)
    return np.array(figures[:3]), np.asarray(turn.as_quat(), np.float64)


def place_as_typed(vehicle: Vehicle, text: str) -> None:
    """Place a vehicle at the pose in --pose. Raises ValueError for an invalid pose or position."""
    position, quaternion = parsed_pose(text)
    try:
        vehicle.place(position, quaternion)
    except ValueError as error:
        raise ValueError(f"--pose {text}: {error}") from error


def chosen_vehicle(sim: Simulator, name: str | None) -> Vehicle:
    """Return the vehicle named by --vehicle, by default the first. Raises ValueError for an unknown name."""
    return sim.rov if name is None else sim.vehicles[name]
