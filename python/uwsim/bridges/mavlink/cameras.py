"""Cameras as MAVLink components (https://mavlink.io/en/services/camera.html), and their video stream."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import Any

from uwsim.bridges.mavlink.component import DONE, FAILED, Commands, Component, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.video.video import BITRATE_KBIT_S, VideoStream, own_first
from uwsim.channels.delivery.pictures import RATE_HZ

FIRST_COMPONENT, COMPONENTS = 100, 6  # MAV_COMP_ID_CAMERA to CAMERA6
CAMERA_TYPE, NO_AUTOPILOT, ACTIVE = 30, 8, 4  # MAV_TYPE, MAV_AUTOPILOT, MAV_STATE
CAPTURES_VIDEO_STREAM = 256  # CAMERA_CAP_FLAGS
VIDEO_MODE, STORAGE_NOT_SUPPORTED = 1, 3
RTP_UDP, H264, RUNNING = 1, 1, 1
STREAM = 1
REQUEST_STORAGE = 525  # MAV_CMD
REQUESTS = {
    521: (259, 1),
    522: (260, 1),
    525: (261, 2),
    527: (262, 1),
    2504: (269, 0),
    2505: (270, 0),
}
"""Older commands that request one message: the message's ID, and which parameter is a switch.

0: none, since the first parameter is the number of a stream. The others are answered even if their switch is off.
"""


class CameraComponent:
    """One of the vehicle's cameras. video: its stream, or None. gimbal: the ID of the gimbal that turns it, or 0."""

    def __init__(self, craft: Craft, component: Component, name: str, gimbal: int, video: VideoStream | None) -> None:
        self._craft, self._name, self._gimbal, self._video = craft, name, gimbal, video
        self.component, self._mav = component, component.mav
        requests: dict[int, Obey] = {command: partial(self._send, command) for command in REQUESTS}
        switches: dict[int, Obey] = {2502: partial(self._stream, True), 2503: partial(self._stream, False)}
        self.commands = Commands(component, {**requests, **(switches if video else {})}, [self.answer], craft.send_text)

    def heartbeat(self) -> Any:
        """Return HEARTBEAT."""
        return self._mav.heartbeat_encode(CAMERA_TYPE, NO_AUTOPILOT, 0, 0, ACTIVE, 3)

    def _send(self, command: int, given: Given) -> int:
        """Answer one of the older commands in REQUESTS with the message that it requests."""
        message, switch = REQUESTS[command]
        if command == REQUEST_STORAGE:
            given.integer(1, 0, 1)  # 0 stands for all, 1 for the first
        if switch:
            given.switch(switch)
        found = self.answer(message, 0.0 if switch else given.integer(1, 0, STREAM))
        if not found:
            return FAILED
        given.replies.extend(found)
        return DONE

    def _stream(self, on: bool, given: Given) -> int:
        given.integer(1, 0, STREAM)
        assert self._video is not None
        self._video.is_paused = not on
        return DONE

    def answer(self, number: int, value: float) -> Iterable[Any] | None:
        """Return the messages with an ID; `value` is the number of a stream, or 0 for all. See Answers."""
        if number == 259:
            return [self._information()]
        if number == 260:
            return [self._mav.camera_settings_encode(self._ms, VIDEO_MODE, math.nan, math.nan)]
        if number == 261:
            return [self._mav.storage_information_encode(self._ms, 0, 0, STORAGE_NOT_SUPPORTED, *[math.nan] * 5)]
        if number == 262:
            return [self._mav.camera_capture_status_encode(self._ms, 0, 0, 0.0, 0, 0.0)]
        if number in (269, 270) and self._video is not None and value in (0, STREAM):
            return [self._stream_message(number, self._video)]
        return None

    @property
    def _ms(self) -> int:
        return 0 if self._craft.state is None else round(1e3 * self._craft.state.time_s) % 2**32

    def _information(self) -> Any:
        info = self._craft.vehicle.cameras[self._name].info
        flags = CAPTURES_VIDEO_STREAM if self._video is not None else 0
        return self._mav.camera_information_encode(
            self._ms, _padded("uwsim", 32), _padded(self._name, 32), 0, math.nan, math.nan, math.nan, info.width,
            info.height, 0, flags, 0, b"", self._gimbal,
        )  # fmt: skip

    def _stream_message(self, number: int, video: VideoStream) -> Any:
        mount = self._craft.vehicle.cameras[self._name].mount
        flags = 0 if video.is_paused else RUNNING
        plain = flags, RATE_HZ, *video.size, 1000 * BITRATE_KBIT_S, 0, round(mount.field_of_view_deg)
        if number == 270:
            return self._mav.video_stream_status_encode(STREAM, *plain)
        name, uri = self._name.encode()[:31], str(video.target.port).encode()
        return self._mav.video_stream_information_encode(STREAM, 1, RTP_UDP, *plain, name, uri, H264)


def _padded(text: str, length: int) -> list[int]:
    return list(text.encode()[:length].ljust(length, b"\0"))


def camera_components(
    craft: Craft, make: Any, gimbal_camera: str, gimbal: int, video: VideoStream | None
) -> list[CameraComponent]:
    """Return the components of the vehicle's cameras, the streamed one first. make: creates a component with an ID."""
    names = own_first(craft.vehicle.cameras)
    if video is not None:
        names.sort(key=lambda name: name != video.camera)
    return [
        CameraComponent(
            craft, make(FIRST_COMPONENT + k), name, gimbal if name == gimbal_camera else 0,
            video if video is not None and video.camera == name else None,
        )
        for k, name in enumerate(names[:COMPONENTS])
    ]  # fmt: skip
