"""Camera channels: JPEG pictures with camera_info, and depth images."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from uwsim.cameras import Camera
from uwsim.channels import build
from uwsim.channels.channel import Channel
from uwsim.channels.pictures import RATE_HZ, Picture, Pictures
from uwsim.channels.source import Source
from uwsim.simulator import Simulator

CameraOf = Callable[[Simulator], Camera]


def station_cameras(sim: Simulator, pictures: Pictures) -> list[Channel]:
    """Return the channels of the station's cameras."""
    return [
        channel
        for name in sim.cameras
        for channel in _channels("", name, pictures, f"{name}_optical", False, _at_station(name))
    ]


def vehicle_cameras(source: Source, sim: Simulator, pictures: Pictures) -> list[Channel]:
    """Return the channels of a vehicle's cameras."""
    return [
        channel
        for name in source.of(sim).cameras
        for channel in _channels(
            source.prefix, name, pictures, source.frame(f"{name}_optical"), True, _on_vehicle(source, name)
        )
    ]  # fmt: skip


def _at_station(name: str) -> CameraOf:
    return lambda sim: sim.cameras[name]


def _on_vehicle(source: Source, name: str) -> CameraOf:
    return lambda sim: source.of(sim).cameras[name]


def jpeg_message(picture: Picture, frame_id: str) -> Any:
    """Return a picture as a CompressedImage."""
    return build.message(
        "sensor_msgs/msg/CompressedImage",
        header=build.header(picture.frame.time_ns, frame_id),
        format="rgb8; jpeg compressed bgr8",
        data=np.frombuffer(picture.jpeg, np.uint8),
    )


def depth_message(picture: Picture, frame_id: str) -> Any:
    """Return a picture's depth along the optical axis, 32FC1 [m]."""
    height, width = picture.frame.depth_m.shape
    return build.message(
        "sensor_msgs/msg/Image",
        header=build.header(picture.frame.time_ns, frame_id),
        height=height,
        width=width,
        encoding="32FC1",
        step=4 * width,
        data=np.ascontiguousarray(picture.frame.depth_m, "<f4").view(np.uint8).ravel(),
    )


def info_message(picture: Picture, frame_id: str) -> Any:
    """Return the intrinsics of a picture as it is sent."""
    info, stream = picture.frame.info, picture.stream
    scale = stream.width / info.width if stream.width else 1.0
    # Pixel centres are at whole numbers: u' + 0.5 = scale (u + 0.5).
    resize = np.array([[scale, 0.0, 0.5 * scale - 0.5], [0.0, scale, 0.5 * scale - 0.5], [0.0, 0.0, 1.0]])
    return build.message(
        "sensor_msgs/msg/CameraInfo",
        header=build.header(picture.frame.time_ns, frame_id),
        height=max(1, round(info.height * scale)),
        width=stream.width or info.width,
        distortion_model=info.distortion_model,
        d=np.array(info.d),
        k=(resize @ info.k).ravel(),
        r=np.array(info.r).ravel(),
        p=(resize @ info.p).ravel(),
    )


def _channels(
    prefix: str, name: str, pictures: Pictures, frame_id: str, over_link: bool, camera_of: CameraOf
) -> list[Channel]:
    def channel(topic: str, kind: str, description: str, write: Callable[[Picture, str], Any]) -> Channel:
        def read(sim: Simulator) -> Any:
            picture = pictures.read(sim, prefix + name, camera_of(sim))
            return None if picture is None else write(picture, frame_id)

        return Channel(
            f"{prefix}camera/{name}/{topic}", f"sensor_msgs/msg/{kind}", "out", description, rate_hz=RATE_HZ,
            frame_id=frame_id, over_link=over_link, read=read,
        )  # fmt: skip

    return [
        channel("image_raw/compressed", "CompressedImage", "pictures as JPEG", jpeg_message),
        channel("camera_info", "CameraInfo", "intrinsics of the pictures as sent", info_message),
        channel("depth/image_raw", "Image", "depth along the optical axis [m], full size; inf: nothing", depth_message),
    ]
