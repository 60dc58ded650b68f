"""The frames of a remote vehicle, from /tf and /tf_static."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.frames import matrix, quaternion, seconds, vector

WORLD = "world"


class RemoteTree:
    """Frame poses; the first query subscribes to the topics."""

    def __init__(self, connection: RemoteConnection) -> None:
        self._connection = connection

    def world_from(self, frame: str, time_s: float) -> NDArray[np.float64]:
        """Return a frame's pose (4, 4) in the world, from the message closest to a given time.

        Raises ValueError or OSError.
        """
        self._connection.subscribe("tf", keep=True)
        fixed, moving = self._connection.newest("tf_static"), self._connection.newest("tf")
        moving = min(self._connection.kept("tf"), key=lambda message: apart_s(message, time_s), default=moving)
        parents = {each.child_frame_id: each for each in (*fixed.transforms, *moving.transforms)}
        world_from_frame, at = np.eye(4), frame
        for _ in range(len(parents)):
            if at not in parents:
                break
            world_from_frame = matrix_of(parents[at].transform) @ world_from_frame
            at = parents[at].header.frame_id
        if at != WORLD:
            raise ValueError(f"/tf, /tf_static: do not say where frame '{frame}' is in '{WORLD}'")
        return world_from_frame


def apart_s(message: Any, time_s: float) -> float:
    """Return the difference [s] between a TFMessage's time and another time."""
    return abs(seconds(message.transforms[0].header.stamp) - time_s) if message.transforms else math.inf


def matrix_of(transform: Any) -> NDArray[np.float64]:
    """Return a geometry_msgs/Transform as a matrix (4, 4)."""
    return matrix(vector(transform.translation), quaternion(transform.rotation))
