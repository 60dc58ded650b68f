"""Packing of pictures as small JPEGs."""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np

from uwsim.channels import Channel
from uwsim.channels.ros import build

WIDTH = 96
QUALITY = 25
USUAL_BYTES = 1200  # for pictures of the lake
HEAD = struct.Struct("<qB")  # stamp [ns], length of the frame's name


def pack(message: Any) -> bytes:
    """Pack a CompressedImage as a JPEG at most 96 pixels wide, with its stamp and frame."""
    from PIL import Image

    picture = Image.open(io.BytesIO(bytes(message.data))).convert("RGB")
    if picture.width > WIDTH:
        picture = picture.resize((WIDTH, max(1, round(WIDTH * picture.height / picture.width))))
    jpeg = io.BytesIO()
    picture.save(jpeg, "JPEG", quality=QUALITY, optimize=True)
    frame: bytes = message.header.frame_id.encode()[:255]
    stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    return HEAD.pack(stamp_ns, len(frame)) + frame + jpeg.getvalue()


def unpack(data: bytes, channel: Channel) -> Any:
    """Return the small picture."""
    stamp_ns, length = HEAD.unpack_from(data)
    frame = data[HEAD.size : HEAD.size + length].decode()
    return build.message(
        "sensor_msgs/msg/CompressedImage",
        header=build.header(stamp_ns, frame),
        format="jpeg",
        data=np.frombuffer(data, np.uint8, offset=HEAD.size + length),
    )
