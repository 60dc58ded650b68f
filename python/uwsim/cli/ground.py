"""Options for ArduPilot users' ground stations: MAVLink without firmware, and video."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.cli.options import need

if TYPE_CHECKING:
    from uwsim.bridges.actions import Action
    from uwsim.channels import Table
    from uwsim.live import LiveSimulator
    from uwsim.simulator.simulator import Simulator

Mavlink = Annotated[
    str | None,
    typer.Option(
        "--mavlink",
        help="Speak MAVLink as ArduSub does: udpout, udpin or tcp, with [:HOST]:PORT; see "
        "docs/connections/ardupilot.md.",
    ),
]
Video = Annotated[
    str | None,
    typer.Option(
        metavar="[HOST:]PORT",
        help="Send a camera's pictures as H.264 by RTP to this UDP port. QGroundControl expects them at 5600.",
    ),
]
VideoCamera = Annotated[str | None, typer.Option(help="Video: the vehicle's camera. Default: its first.")]


class GroundStation:
    """The connections to ground stations that options request. Raises ValueError for options without effect."""

    def __init__(self, *, mavlink: str | None, video: str | None, video_camera: str | None, ardusub: bool) -> None:
        self._endpoint = self._target = None
        self._camera = video_camera
        if mavlink is not None:
            from uwsim.bridges.mavlink import Endpoint

            if ardusub:
                raise ValueError("--mavlink: cannot be given with --ardusub: the firmware speaks MAVLink itself")
            self._endpoint = Endpoint.parse(mavlink)
        if video is None:
            need("--video", video_camera=video_camera)
        else:
            from uwsim.bridges.video import Target

            self._target = Target.parse(video)

    def check(self, simulator: Simulator) -> None:
        """Raise ValueError for connections that this simulator cannot serve."""
        wanted = {"--mavlink": self._endpoint, "--video": self._target}
        crossing = [option for option, value in wanted.items() if value is not None]
        if crossing and simulator.link is not None:
            raise ValueError(f"{crossing[0]}: does not cross the link; use a scenario without one, or --link none")

    def join(self, sinks: ExitStack, live: LiveSimulator, table: Table, actions: list[Action], feed: Any) -> list[str]:
        """Start the requested connections; return their descriptions. Raises OSError, ValueError, MissingExtraError."""
        name, places, stream = live.simulator.rov.name, [], None
        if self._target is not None:
            from uwsim.bridges.video import VideoStream

            stream = sinks.enter_context(VideoStream(live, name, self._target, self._camera))
            places.append(f"video of camera '{stream.camera}' to UDP {stream.target}")
        if self._endpoint is not None:
            from uwsim.bridges.mavlink import MavlinkVehicle

            flights = {action.source.name: action for action in actions if action.name.endswith("fly_path")}
            ground = MavlinkVehicle(
                live, self._endpoint, table.channels, table.services, action=flights.get(name), feed=feed, video=stream
            )
            places.insert(0, f"MAVLink at {sinks.enter_context(ground).endpoint}")
        return places
