"""`--mavlink`: the first vehicle as an ArduSub for ground stations, without firmware."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from uwsim.base.options import Options, option
from uwsim.bridges.doors.door import EVERYONE, OWN, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened


@dataclass(frozen=True)
class MavlinkOptions(Options):
    """The options of the MAVLink vehicle."""

    switch = "mavlink"

    mavlink: str | None = option(
        None,
        "Speak MAVLink as ArduSub does: udpout, udpin or tcp, with [:HOST]:PORT; see docs/connections/ardupilot.md.",
    )
    mavlink_pictures: Path | None = option(
        None, "Folder for the pictures that the triggers of missions take, and for pictures.csv.", metavar="FOLDER"
    )


class MavlinkPlug(BridgePlug[MavlinkOptions]):
    """The MAVLink vehicle. Raises ValueError for a wrong address."""

    options = MavlinkOptions
    needs_live = True
    crosses_link = False
    excluded_by = {"ardusub": "the firmware speaks MAVLink itself"}  # noqa: RUF012  # read only
    doors = (
        Door("`--mavlink tcp`", "TCP", 1, OWN, "MAVLink", f"{EVERYONE}; no web page", ("--mavlink", "tcp:0"),
             speaks_first=True),
        Door("`--mavlink udpin`", "UDP", 1, OWN, "MAVLink", f"{EVERYONE}, from its first valid message",
             ("--mavlink", "udpin:0")),
        Door("`--mavlink udpout`", "UDP", 1, OWN, "MAVLink", "the program at the target", ("--mavlink", "udpout")),
    )  # fmt: skip

    def __init__(self, options: MavlinkOptions) -> None:
        super().__init__(options)
        from uwsim.bridges.mavlink.endpoint import FORM

        self._pictures = options.mavlink_pictures
        self._endpoint = FORM.parse(options.mavlink or "")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Connect the vehicle, which announces the video to ground stations if there is one."""
        from uwsim.bridges.mavlink import MavlinkVehicle
        from uwsim.bridges.mavlink.earth import place_of
        from uwsim.channels import require_live

        live, video = require_live(context.live), context.opened.get("video")
        with MavlinkVehicle(
            live,
            self._endpoint,
            context.channels,
            context.services,
            action=context.flights.get(live.simulator.rov.name),
            feed=context.feed,
            home=place_of(live.simulator.scenario),
            pictures=self._pictures,
            video=None if video is None else video.bridge,
        ) as vehicle:
            yield Opened(f"MAVLink at {vehicle.endpoint}", vehicle)
