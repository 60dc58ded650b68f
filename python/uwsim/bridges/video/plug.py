"""`--video`: a camera of the first vehicle as an H.264 stream for ground stations."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from uwsim.base.options import Options, option
from uwsim.bridges.doors.door import IF_LOCAL, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened


@dataclass(frozen=True)
class VideoOptions(Options):
    """The options of the video stream."""

    switch = "video"

    video: str | None = option(
        None,
        "Send a camera's pictures as H.264 by RTP to this UDP port. QGroundControl expects them at 5600.",
        metavar="[HOST:]PORT",
    )
    video_camera: str | None = option(None, "Video: the vehicle's camera. Default: its first.")


class VideoPlug(BridgePlug[VideoOptions]):
    """The video stream. Raises ValueError for a wrong address."""

    options = VideoOptions
    doors = (
        Door("`--video`", "UDP", 2, IF_LOCAL, "ffmpeg's RTP and RTCP",
             "reports on the reception; they have no effect", ("--video", "5600")),
    )  # fmt: skip
    needs_live = True
    crosses_link = False

    def __init__(self, options: VideoOptions) -> None:
        super().__init__(options)
        from uwsim.bridges.video.video import FORM

        self._target = FORM.parse(options.video or "")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Send the stream."""
        from uwsim.bridges.video.video import VideoStream
        from uwsim.channels import require_live

        live = require_live(context.live)
        with VideoStream(live, live.simulator.rov.name, self._target, self.given.video_camera) as stream:
            yield Opened(f"video of camera '{stream.camera}' to UDP {stream.target}", stream)
