"""Forwards the vehicle camera pictures that have arrived over the link, the only ones that a pilot receives."""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels import Channel
from uwsim.channels.families.gauges import values_by_name
from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.ros.own_types import SENSOR_GAUGES, TELEMETRY
from uwsim.link import Carrier
from uwsim.link.carried import vehicle_of
from uwsim.live import LiveSimulator
from uwsim.operator.station.views.views import JPEG, View
from uwsim.simulator.simulator import Simulator

SUFFIX = "image_raw/compressed"
LOOK_S = 0.05
SMALL_S = 2.0
"""Interval between pictures of a view that no pilot has enlarged, in simulated time."""
PANELS = (TELEMETRY, SENSOR_GAUGES)


class Arrivals:
    """Arriving pictures for the views of vehicle cameras.

    A view's pictures are sent while any page shows the view enlarged. The newest picture is kept for later viewers and
    for the small view. A cable and the ideal link also carry pictures of small views, one every SMALL_S, for which a
    modem lacks the capacity.
    """

    def __init__(self, live: LiveSimulator, carrier: Carrier, views: Iterable[View], node: Node) -> None:
        self._live, self._carrier, self._node = live, carrier, node
        seen = {channel.name: channel for channel in carrier.channels if channel.direction == "out"}
        self._channels: dict[str, Channel | None] = {}
        self._vehicles: dict[str, str] = {}
        self._newest: dict[str, Any] = {}
        self._large_only = live.simulator.link is not None and live.simulator.link.modem.kind == "modem"
        self._small_due_ns: dict[str, int] = {}
        for view in views:
            if view.vehicle:
                self._channels[view.name] = seen.get(_topic(view))
                self._vehicles[view.name] = view.vehicle
        self._panels = {name: vehicle_of(one, live.simulator) for name, one in seen.items() if one.type in PANELS}

    def __contains__(self, view: str) -> bool:
        """Return whether a view's pictures are received over the link."""
        return view in self._channels

    def topics(self) -> list[GuestTopic]:
        """Return the topics of all views."""
        return [
            GuestTopic(f"station/{size}/{name}", JPEG, "pictures that have arrived over the link", latched=True)
            for name in self._channels
            for size in ("view", "small")
        ]

    def start(self) -> None:
        """Start publishing pictures as they arrive."""
        for name, channel in self._channels.items():
            if channel is not None:
                self._live.every(LOOK_S, self._reader(name, channel.name), self._shower(name))

    def describe(self, view: str) -> Values:
        """Return additional entries of `describe` for a view."""
        return {"link": self.pace(getattr(self._channels[view], "name", ""))}

    def pace(self, channel: str) -> Values:
        """Return the modem, the seconds between pictures (None if there is no capacity), and `large_only`."""
        rate_hz = self._carrier.rates.get(channel)
        period_s = None if rate_hz is None else 1.0 / rate_hz
        return {"modem": self._carrier.modem, "period_s": period_s, "large_only": self._large_only}

    def snapshot(self, view: str) -> tuple[NDArray[np.uint8], Values]:
        """Return the newest picture, (H, W, 3), and the newest panel. Raises ValueError if either has not arrived."""
        from PIL import Image

        if view not in self._newest:
            raise ValueError(f"no picture of '{view}' has come over {self._carrier.modem} yet")
        picture = Image.open(io.BytesIO(bytes(self._newest[view].data))).convert("RGB")
        return np.asarray(picture), self.panel(self._vehicles[view])

    def has_come(self, view: str) -> bool:
        """Return whether any picture of a view has arrived."""
        return view in self._newest

    def panel(self, vehicle: str) -> Values:
        """Return a vehicle's newest panel. Raises ValueError if none has arrived."""
        found: Values = {}
        for name, owner in self._panels.items():
            if owner == vehicle and (message := self._carrier.newest(name)) is not None:
                found |= values_by_name(message)
        if "position" not in found:
            raise ValueError(f"no telemetry of '{vehicle}' has come over {self._carrier.modem} yet")
        return found

    def _reader(self, name: str, channel: str) -> Any:
        """Return a function that requests pictures from the vehicle while any page needs them, and reads the newest."""

        def read(sim: Simulator) -> Any:
            if self._is_due(name, sim.time_ns):
                self._carrier.note_read(channel, sim)
            return self._carrier.newest(channel, sim.time_s - LOOK_S)

        return read

    def _is_due(self, name: str, time_ns: int) -> bool:
        """Return whether another picture of a view is needed."""
        if self._node.is_wanted(f"station/view/{name}"):
            return True
        due_ns = self._small_due_ns.get(name, 0)
        is_past = time_ns >= due_ns or due_ns > time_ns + round(1e9 * SMALL_S)  # simulated time may have been reset
        if self._large_only or not is_past or not self._node.is_wanted(f"station/small/{name}"):
            return False
        self._small_due_ns[name] = time_ns + round(1e9 * SMALL_S)
        return True

    def _shower(self, name: str) -> Any:
        def show(message: Any) -> None:
            if message is None:
                return
            self._newest[name] = message
            stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            for size in ("view", "small"):
                self._node.publish(f"station/{size}/{name}", message, stamp_ns)

        return show


def _topic(view: View) -> str:
    """Return the name of the camera channel of a view."""
    prefix, camera = view.name.rpartition("/")[::2]
    return f"{prefix}/camera/{camera}/{SUFFIX}" if prefix else f"camera/{camera}/{SUFFIX}"
