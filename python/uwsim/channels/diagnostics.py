"""/diagnostics: a live simulator's pace, and whether each vehicle's all stop is set, for ROS's monitors."""

from __future__ import annotations

from typing import Any

from uwsim.channels import build
from uwsim.channels.channel import Channel
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

RATE_HZ = 1.0
OK, WARN, ERROR = 0, 1, 2  # diagnostic_msgs/DiagnosticStatus
HELD = 0.95  # fraction of the requested speed


def diagnostics_channel(live: LiveSimulator) -> Channel:
    """Return the channel of a live simulator's pace: speed, factor, lateness_s, slipped_s, paused."""
    slipped_before_s = 0.0

    def read(sim: Simulator) -> Any:
        nonlocal slipped_before_s
        slipped_s = live.slipped_s
        has_slipped, slipped_before_s = slipped_s > slipped_before_s, slipped_s
        level, message = _judged(live, has_slipped)
        values = {
            "speed": live.speed, "factor": f"{live.factor:.4f}", "lateness_s": f"{live.lateness:.4f}",
            "slipped_s": f"{slipped_s:.4f}", "paused": live.paused,
        }  # fmt: skip
        status = build.message(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=level,
            name="uwsim: pace",
            message=message,
            hardware_id="uwsim",
            values=[
                build.message("diagnostic_msgs/msg/KeyValue", key=key, value=str(value))
                for key, value in values.items()
            ],
        )
        return build.message(
            "diagnostic_msgs/msg/DiagnosticArray",
            header=build.header(sim.time_ns, ""),
            status=[status, *_vehicles(sim)],
        )

    return Channel(
        "diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "out",
        "the simulator's pace: speed, factor, lateness_s, slipped_s, paused; each vehicle's all stop; once a simulated "
        "second",
        rate_hz=RATE_HZ, read=read,
    )  # fmt: skip


def _vehicles(sim: Simulator) -> list[Any]:
    """Report whether each vehicle obeys commands; with a link, this is only known from its delayed telemetry."""
    return [
        build.message(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=WARN if vehicle.all_stopped else OK,
            name=f"uwsim: {name}",
            message="all stop is set: its thrusters are stopped" if vehicle.all_stopped else "it obeys commands",
            hardware_id=name,
            values=[],
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
    if has_slipped or 0.0 < live.factor < HELD * float(live.speed):
        return WARN, "the pace is not held"
    return OK, "the pace is held"
