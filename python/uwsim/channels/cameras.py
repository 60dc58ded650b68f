"""Camera channels: JPEG pictures with camera_info, depth images, and pan and tilt commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from uwsim.channels import build
from uwsim.channels.channel import COMMAND, PICTURE, Channel
from uwsim.channels.pictures import RATE_HZ, Picture, Pictures
from uwsim.channels.source import Source
from uwsim.channels.steering import is_cut_off, log_error
from uwsim.instruments.cameras import Camera
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

CameraOf = Callable[[Simulator], Camera]


def station_cameras(sim: Simulator, pictures: Pictures, frame_prefix: str = "") -> list[Channel]:
    """Return the channels of the station's cameras."""
    return [
        channel
        for name in sim.cameras
        for channel in (
            *_channels("", name, pictures, f"{frame_prefix}{name}_optical", False, _at_station(name)),
            *aim_channels("", None, name, sim.cameras[name]),
        )
    ]


def vehicle_cameras(source: Source, sim: Simulator, pictures: Pictures) -> list[Channel]:
    """Return the channels of a vehicle's cameras."""
    return [
        channel
        for name, camera in source.of(sim).cameras.items()
        for channel in (
            *_channels(source.prefix, name, pictures, source.frame(f"{name}_optical"), True, _on_vehicle(source, name)),
            *aim_channels(source.prefix, source.name, name, camera),
        )
    ]


def aim_channels(prefix: str, vehicle: str | None, name: str, camera: Camera) -> list[Channel]:
    """Return the channels that pan and tilt a camera, one for each motorised axis."""
    motor = camera.mount.pan_tilt
    if motor is None:
        return []
    axes = (("pan", "to port", motor.pan_limits_deg), ("tilt", "down", motor.tilt_limits_deg))
    return [
        Channel(
            f"{prefix}camera/{name}/cmd_{axis}", "std_msgs/msg/Float64", "in",
            f"angle [rad] to turn to, positive {positive}, in [{math.radians(low):.4g}, {math.radians(high):.4g}]",
            over_link=vehicle is not None, priority=COMMAND,
            apply=_aimer(f"{prefix}camera/{name}/cmd_{axis}", vehicle, name, axis, limits),
        )
        for axis, positive, limits in axes
        for low, high in (limits,)
        if low < high
    ]  # fmt: skip


def _aimer(
    topic: str, vehicle: str | None, camera: str, axis: str, limits_deg: tuple[float, float]
) -> Callable[[LiveSimulator, Any], None]:
    low, high = np.radians(limits_deg)

    def apply(live: LiveSimulator, message: Any) -> None:
        if not low <= message.data <= high:
            raise ValueError(f"{topic} = {message.data} rad: must be in [{low:.4g}, {high:.4g}] rad")
        if vehicle is not None and is_cut_off(live.simulator, vehicle):
            return
        angle = {f"{axis}_rad": message.data}
        live.command("aim_camera", vehicle=vehicle, camera=camera, **angle).add_done_callback(log_error)

    return apply


def _at_station(name: str) -> CameraOf:
    return lambda sim: sim.cameras[name]


def _on_vehicle(source: Source, name: str) -> CameraOf:
    return lambda sim: source.of(sim).cameras[name]


RGB_JPEG = "rgb8; jpeg compressed bgr8"


def jpeg_message(picture: Picture, frame_id: str, format_text: str = RGB_JPEG) -> Any:
    """Return a picture as a CompressedImage."""
    return compressed_image(picture.jpeg, picture.frame.time_ns, frame_id, format_text)


def compressed_image(jpeg: bytes, time_ns: int, frame_id: str, format_text: str = RGB_JPEG) -> Any:
    """Return a JPEG as a CompressedImage. format_text: by default image_transport's; the published wire has "jpeg"."""
    return build.message(
        "sensor_msgs/msg/CompressedImage",
        header=build.header(time_ns, frame_id),
        format=format_text,
        data=np.frombuffer(jpeg, np.uint8),
    )


def depth_message(picture: Picture, frame_id: str) -> Any:
    """Return a picture's depth along the optical axis as a 32FC1 Image [m]."""
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
    """Return a picture's intrinsics, scaled to the size at which it is sent."""
    info, stream = picture.frame.info, picture.stream
    scale = stream.width / info.width if stream.width else 1.0
    # Pixel centres are at integer coordinates: u' + 0.5 = scale (u + 0.5).
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
    def channel(topic: str, kind: str, description: str, write: Callable[[Picture, str], Any], packing: str) -> Channel:
        def read(sim: Simulator) -> Any:
            picture = pictures.read(sim, prefix + name, camera_of(sim))
            return None if picture is None else write(picture, frame_id)

        return Channel(
            f"{prefix}camera/{name}/{topic}", f"sensor_msgs/msg/{kind}", "out", description, rate_hz=RATE_HZ,
            frame_id=frame_id, over_link=over_link, priority=PICTURE, packing=packing, late=True, read=read,
        )  # fmt: skip

    return [
        channel("image_raw/compressed", "CompressedImage", "pictures as JPEG", jpeg_message, "thumbnail"),
        channel("camera_info", "CameraInfo", "intrinsics of the pictures as sent", info_message, ""),
        channel(
            "depth/image_raw", "Image", "depth along the optical axis [m], full size; inf: nothing", depth_message, ""
        ),
    ]
