"""Test helpers that read channels and compute poses from transforms."""

from typing import Any

import numpy as np
import orjson
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.channels import Channel, channels
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes, to_bytes, to_plain, typestore


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


def twist(*values: float) -> Any:
    """Return a Twist of up to three linear and three angular velocities."""
    given = [*values, *[0.0] * (6 - len(values))]
    return build.message("geometry_msgs/msg/Twist", linear=build.vector(given[:3]), angular=build.vector(given[3:]))


def floats(*values: float) -> Any:
    """Return a list of numbers, as of thrusters and fins."""
    return build.message("std_msgs/msg/Float64MultiArray", data=np.array(values, np.float64))


def require_writable(channel: Channel, sim: Simulator) -> Any:
    """Return a channel's message, or None; require its type and frame, and that each serialisation preserves it."""
    assert channel.type in typestore().fielddefs and channel.description
    message = None if channel.direction == "in" else channel.read(sim)
    if message is None:
        return None  # a command, or for example a sensor sample that was lost
    assert message.__msgtype__ == channel.type
    data, plain = bytes(encode(message)), to_bytes(message)
    assert len(data) % 4 == 0 and len(data) - len(plain) < 4 and data == plain.ljust(len(data), b"\0"), channel.name
    assert to_bytes(from_bytes(data, channel.type)) == plain and to_bytes(message, 1), channel.name
    assert orjson.dumps(to_plain(message), option=orjson.OPT_SERIALIZE_NUMPY)
    if hasattr(message, "header"):
        assert message.header.frame_id == channel.frame_id or not channel.frame_id or "usbl" in channel.name
        assert 0 <= stamp_ns(message) <= sim.time_ns
    return message
