"""Test helpers that read channels and compute poses from transforms."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.channels import Channel, channels


def table(sim: Simulator, **options: Any) -> dict[str, Channel]:
    """Return a simulator's channels by name."""
    found = channels(sim, **options)
    names = [channel.name for channel in found]
    assert len(names) == len(set(names))
    return dict(zip(names, found, strict=True))


def matrix(translation: Any, rotation: Any) -> np.ndarray:
    """Return the (4, 4) transform of a message's position and quaternion."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([rotation.x, rotation.y, rotation.z, rotation.w]).as_matrix()
    pose[:3, 3] = translation.x, translation.y, translation.z
    return pose


def chain(sim: Simulator, found: dict[str, Channel], frame: str, root: str = "world") -> np.ndarray:
    """Return root_from_frame (4, 4), composed from /tf and /tf_static as a client would."""
    steps = {t.child_frame_id: t for name in ("tf", "tf_static") for t in found[name].read(sim).transforms}
    pose = np.eye(4)
    while frame != root:
        moved = steps[frame]
        pose = matrix(moved.transform.translation, moved.transform.rotation) @ pose
        frame = moved.header.frame_id
    return pose


def stamp_ns(message: Any) -> int:
    """Return the time stamp in a message's header, in ns."""
    return int(message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)
