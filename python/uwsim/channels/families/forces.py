"""The forces on a vehicle: numbers by name. They are true, not measured."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import FORCES
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator

RATE_HZ = 10.0


def force_channels(source: Source, sim: Simulator, *, truth: bool) -> list[Channel]:
    """Return a vehicle's channel of forces; none with Bullet's engine, which has no such terms."""
    if not truth or sim.scenario.dynamics.engine != "uwsim":
        return []
    frame_id = source.frame("base_link")
    return [
        Channel(
            source.topic("forces"), FORCES, "out", "wrenches by name, and contacts, in the last step",
            rate_hz=RATE_HZ, frame_id=frame_id, delivery=Delivery(on_request=True),
            read=lambda sim: _forces(source, sim, frame_id),
        ),
    ]  # fmt: skip


def _forces(source: Source, sim: Simulator, frame_id: str) -> Any:
    vehicle = source.of(sim)
    forces, (points, pushes) = vehicle.forces, _contacts(source, sim)
    return build.message(
        FORCES,
        header=build.header(sim.time_ns, frame_id),
        names=list(forces),
        wrenches=[
            build.message(
                "geometry_msgs/msg/Wrench", force=build.vector(each.force_body_n),
                torque=build.vector(each.torque_body_nm),
            )
            for each in forces.values()
        ],
        contact_points=[build.xyz("geometry_msgs/msg/Point", point) for point in points],
        contact_forces=[build.vector(push) for push in pushes],
        contact_others=[contact.other for contact in vehicle.contacts],
        contact_links=[contact.link for contact in vehicle.contacts],
        contact_other_links=[contact.other_link for contact in vehicle.contacts],
    )  # fmt: skip


def _contacts(source: Source, sim: Simulator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the points (n, 3) [m] and the forces (n, 3) [N] of a vehicle's contacts in its body frame."""
    vehicle = source.of(sim)
    contacts, pose = vehicle.contacts, vehicle.pose
    turn = pose.world_from_body[:3, :3]
    points = np.array([contact.point_world_m for contact in contacts]).reshape(-1, 3)
    forces = np.array([contact.force_world_n for contact in contacts]).reshape(-1, 3)
    return (points - pose.position_world_m) @ turn, forces @ turn
