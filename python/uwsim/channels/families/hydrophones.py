"""The topics of hydrophones: the raw samples around each ping, once for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uwsim.channels.channel import Channel, Delivery, OverLink
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import HYDROPHONE_PING
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator

RATE_HZ = 20.0


def hydrophone_channels(source: Source, sim: Simulator) -> list[Channel]:
    """Return the channels of a vehicle's hydrophones, each with the array's name."""
    return [
        Channel(
            source.topic(name), HYDROPHONE_PING, "out", "samples of an array of hydrophones around each ping",
            rate_hz=RATE_HZ, frame_id=source.frame(f"{name}_link"), over_link=OverLink(packing=""),
            delivery=Delivery(is_sampled=True), read=_reader(source, name, source.frame(f"{name}_link")),
        )
        for name in source.of(sim).hydrophones
    ]  # fmt: skip


def _reader(source: Source, name: str, frame_id: str) -> Callable[[Simulator], Any]:
    last: tuple[Any, int, Any] = (None, 0, None)  # the ping, the time when it was read, the message

    def read(sim: Simulator) -> Any:
        """Return the message of the newest ping: the same object as before while there is no other."""
        nonlocal last
        array = source.of(sim).hydrophones[name]
        if (burst := array.newest()) is None:
            return None
        key = sim.seed, burst.pinger.name, burst.number
        if key != last[0] or sim.time_ns < last[1]:  # time goes back when the run begins again
            ping = array.samples_of(burst)
            last = key, sim.time_ns, build.message(
                HYDROPHONE_PING,
                header=build.header(round(1e9 * ping.start_s), frame_id),
                rate=ping.rate_hz,
                phones=ping.samples.shape[1],
                pascals_per_count=ping.pascals_per_count,
                samples=ping.samples.ravel(),
            )  # fmt: skip
        return last[2]

    return read
