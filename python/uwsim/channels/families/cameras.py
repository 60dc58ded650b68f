"""Camera channels: JPEG pictures with camera_info, depth images, and pan and tilt commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.authority.steering import is_cut_off, log_error
from uwsim.channels.channel import COMMAND, PICTURE, Channel, Delivery, OverLink
from uwsim.channels.delivery.pictures import RATE_HZ, Part, Picture, Pictures
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.instruments.cameras import Camera
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

CameraOf = Callable[[Simulator], Camera]
Write = Callable[[Picture, str], Any]
"""Builds the message for a picture, in a coordinate frame."""


def station_cameras(sim: Simulator, pictures: Pictures, frame_prefix: str = "") -> list[Channel]:
    """Return the channels of the station's cameras."""
    for name, camera in sim.cameras.items():
        pictures.begin_stream(name, camera)
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
    for name, camera in source.of(sim).cameras.items():
        pictures.begin_stream(source.prefix + name, camera)
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
            over_link=None if vehicle is None else OverLink(COMMAND),
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
    """Return a JPEG as a CompressedImage. format_text: the message's format field, by default as in image_transport."""
    return build.message(
        "sensor_msgs/msg/CompressedImage",
        header=build.header(time_ns, frame_id),
        format=format_text,
        data=np.frombuffer(jpeg, np.uint8),
    )


def image_message(picture: Picture, frame_id: str, pixels: NDArray[Any]) -> Any:
    """Return an Image in rgb8 from pixels (h, w, 3) uint8, or in 32FC1 from depths (h, w) float32 [m]."""
    is_depth = pixels.ndim == 2
    return build.message(
        "sensor_msgs/msg/Image",
        header=build.header(picture.frame.time_ns, frame_id),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding="32FC1" if is_depth else "rgb8",
        step=pixels.shape[1] * (4 if is_depth else 3),
        data=np.ascontiguousarray(pixels, "<f4" if is_depth else np.uint8).view(np.uint8).ravel(),
    )


def info_message(picture: Picture, frame_id: str, *, is_sent: bool = True) -> Any:
    """Return a picture's intrinsics. is_sent: use the size at which the picture is sent instead of its full size."""
    info, (k, p) = picture.frame.info, picture.intrinsics if is_sent else (picture.frame.info.k, picture.frame.info.p)
    width = (picture.stream.width if is_sent else 0) or info.width
    return build.message(
        "sensor_msgs/msg/CameraInfo",
        header=build.header(picture.frame.time_ns, frame_id),
        height=max(1, round(info.height * width / info.width)),
        width=width,
        distortion_model=info.distortion_model,
        d=np.array(info.d),
        k=k.ravel(),
        r=np.array(info.r).ravel(),
        p=p.ravel(),
    )


def _channels(
    prefix: str, name: str, pictures: Pictures, frame_id: str, crosses_link: bool, camera_of: CameraOf
) -> list[Channel]:
    def channel(topic: str, kind: str, description: str, write: Write, part: Part | None = None) -> Channel:
        def read(sim: Simulator) -> Any:
            picture = pictures.read(sim, prefix + name, camera_of(sim), part)
            return None if picture is None else write(picture, frame_id)

        packing = "thumbnail" if kind == "CompressedImage" else ""
        return Channel(
            f"{prefix}camera/{name}/{topic}", f"sensor_msgs/msg/{kind}", "out", description, rate_hz=RATE_HZ,
            frame_id=frame_id, over_link=OverLink(PICTURE, packing) if crosses_link else None,
            delivery=Delivery(late=True, on_request=part is not None), read=read,
        )  # fmt: skip

    def image(topic: str, description: str, part: Part) -> Channel:
        return channel(topic, "Image", description, lambda one, frame: image_message(one, frame, one.part(part)), part)

    return [
        channel("image_raw/compressed", "CompressedImage", "pictures as JPEG", jpeg_message),
        image("image_raw", "pictures as sent, through the lens", "image"),
        image("image_rect", "pictures as sent, rectified: through a pinhole, P of camera_info", "rectified"),
        channel("camera_info", "CameraInfo", "intrinsics of the pictures as sent", info_message),
        channel(
            "depth/image_raw", "Image", "depth along the optical axis [m], full size, through the lens; inf: nothing",
            lambda one, frame: image_message(one, frame, one.frame.depth_m),
        ),
        image("depth/image_rect", "depth through a pinhole, P of depth/camera_info [m]", "rectified_depth"),
        channel("depth/camera_info", "CameraInfo", "intrinsics of the depth", partial(info_message, is_sent=False)),
    ]  # fmt: skip
