"""The water column of a multibeam in physics mode, which contains the level of each range sample of each beam."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim import _core
from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.families.imaging import DTYPE_FLOAT32
from uwsim.channels.families.pings import Pings
from uwsim.channels.ros import build
from uwsim.simulator.simulator import Simulator

NAME = "water_column"
IMAGE = "marine_acoustic_msgs/msg/ProjectedSonarImage"


def water_column_channels(pings: Pings, sim: Simulator) -> list[Channel]:
    """Return the channel of a multibeam's water column, if the scenario selects it by `sonar.water_column`."""
    source = pings.source
    entry = next(entry for entry in sim.scenario.vehicles if entry.name == source.name)
    if not entry.sonar.water_column:
        return []
    frame_id = source.frame("base_scan")

    def read(sim: Simulator) -> Any:
        ping: Any = pings.newest(sim).ping
        speed_m_s = sim.world.water.sound_speed_m_s(min(float(ping.world_from_sonar[2, 3]), 0.0))
        return water_column_message(ping, pings.model, frame_id, speed_m_s)

    return [
        Channel(
            source.topic(NAME), IMAGE, "out", "the water column: levels [dB re source level] by beam and range",
            rate_hz=pings.rate_hz, frame_id=frame_id, delivery=Delivery(on_request=True), read=read,
        )
    ]  # fmt: skip


def water_column_message(
    ping: _core.PhysicsPing, model: _core.MultibeamModel, frame_id: str, sound_speed_m_s: float
) -> Any:
    """Return a ping's water column as a message, with samples in rows and beams in columns.

    In its frame, x is ahead and z up. sound_speed_m_s: speed of sound at the head.
    """
    level_db = np.asarray(ping.water_column, np.float32)
    return build.message(
        IMAGE,
        header=build.header(ping.time_ns, frame_id),
        ping_info=build.message(
            "marine_acoustic_msgs/msg/PingInfo", frequency=model.frequency_hz, sound_speed=sound_speed_m_s
        ),
        beam_directions=[build.vector((np.cos(angle), np.sin(angle), 0.0)) for angle in ping.angles_rad],
        ranges=np.asarray(ping.water_column_ranges_m, np.float32),
        image=build.message(
            "marine_acoustic_msgs/msg/SonarImageData",
            dtype=DTYPE_FLOAT32,
            beam_count=len(level_db),
            data=np.ascontiguousarray(level_db.T, "<f4").view(np.uint8).ravel(),
        ),
    )
