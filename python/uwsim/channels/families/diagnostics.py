"""The /diagnostics channel, which reports pace, message delivery and each vehicle's all stop to ROS monitors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from uwsim.channels.channel import Channel
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

RATE_HZ = 1.0
OK, WARN, ERROR = 0, 1, 2  # diagnostic_msgs/DiagnosticStatus


def diagnostics_channel(live: LiveSimulator, offered: Callable[[], Iterable[Channel]] = tuple) -> Channel:
    """Return the channel that reports a live simulator's pace: speed, factor, lateness_s, slipped_s, paused.

    offered: returns the channels whose dropped messages are reported.
    """
    slipped_before_s = 0.0
    dropped_before: dict[str, int] = {}

    def read(sim: Simulator) -> Any:
        nonlocal slipped_before_s, dropped_before
        slipped_s = live.slipped_s
        has_slipped, slipped_before_s = slipped_s > slipped_before_s, slipped_s
        level, message = _judged(live, has_slipped)
        values = {
            "speed": live.speed, "factor": f"{live.factor:.4f}", "lateness_s": f"{live.lateness:.4f}",
            "slipped_s": f"{slipped_s:.4f}", "paused": live.paused,
        }  # fmt: skip
        dropped = {f"/{channel.name}": channel.drops.count for channel in offered() if channel.drops.count}
        has_dropped, dropped_before = dropped != dropped_before, dropped
        delivery = "messages were dropped, since a peer or the network is too slow" if has_dropped else "all delivered"
        return build.message(
            "diagnostic_msgs/msg/DiagnosticArray",
            header=build.header(sim.time_ns, ""),
            status=[
                _status(level, "uwsim: pace", message, values),
                _status(WARN if has_dropped else OK, "uwsim: delivery", delivery, dropped),
                *_vehicles(sim),
            ],
        )

    return Channel(
        "diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "out",
        "the simulator's pace: speed, factor, lateness_s, slipped_s, paused; the number of dropped messages by topic; "
        "each vehicle's all stop; once a simulated second",
        rate_hz=RATE_HZ, read=read,
    )  # fmt: skip


def _status(level: int, name: str, text: str, values: Mapping[str, Any], hardware: str = "uwsim") -> Any:
    pairs = [build.message("diagnostic_msgs/msg/KeyValue", key=key, value=str(value)) for key, value in values.items()]
    return build.message(
        "diagnostic_msgs/msg/DiagnosticStatus", level=level, name=name, message=text, hardware_id=hardware, values=pairs
    )


def _vehicles(sim: Simulator) -> list[Any]:
    """Report whether each vehicle accepts commands. Across a link, this is known only from its delayed telemetry."""
    return [
        _status(
            WARN if vehicle.all_stopped else OK,
            f"uwsim: {name}",
            "all stop is set: its thrusters are stopped" if vehicle.all_stopped else "it obeys commands",
            {},
            name,
        )
        for name, vehicle in (sim.vehicles.items() if sim.link is None else ())
    ]


def _judged(live: LiveSimulator, has_slipped: bool) -> tuple[int, str]:
    if live.error is not None:
        return ERROR, f"the simulation stopped: {live.error}"
    if live.paused:
        return OK, "paused"
    if live.speed == "max":
        return OK, "as fast as it can"
    if has_slipped or live.is_behind:
        return WARN, "the pace is not held"
    return OK, "the pace is held"
