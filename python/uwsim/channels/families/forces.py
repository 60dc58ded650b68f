"""The forces on a vehicle: numbers by name, and arrows that Foxglove and RViz draw. They are true, not measured."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import FORCES
from uwsim.channels.source import Source
from uwsim.simulator.forces import TOTAL
from uwsim.simulator.simulator import Simulator

RATE_HZ = 10.0
MARKERS, MARKER = "visualization_msgs/msg/MarkerArray", "visualization_msgs/msg/Marker"
ARROW, ADD, DELETE_ALL = 0, 0, 3
LONGEST_M = 1.0
"""The length of the longest arrow; the others are to scale with it."""
LEAST = 0.005
"""Shorter arrows, as fractions of the longest, are left out."""
COLOURS = {
    "weight": (0.90, 0.16, 0.16), "buoyancy": (0.16, 0.47, 0.90), "drag": (0.98, 0.75, 0.18),
    "added_mass": (0.55, 0.34, 0.75), "coriolis": (0.60, 0.60, 0.60), "actuators": (0.20, 0.70, 0.29),
    "applied": (0.96, 0.51, 0.19), "contact": (0.00, 0.75, 0.75), "dock": (0.40, 0.40, 0.20),
    "tether": (0.96, 0.80, 0.60), "arm": (0.80, 0.36, 0.36),
    "diffraction": (0.10, 0.35, 0.55), "wind": (0.70, 0.85, 1.00),
    TOTAL: (1.0, 1.0, 1.0),
}  # fmt: skip


def force_channels(source: Source, sim: Simulator, *, truth: bool) -> list[Channel]:
    """Return a vehicle's channels of forces; none with Bullet's engine, which has no such terms."""
    if not truth or sim.scenario.dynamics.engine != "uwsim":
        return []
    frame_id, on_request = source.frame("base_link"), Delivery(on_request=True)
    return [
        Channel(
            source.topic("forces"), FORCES, "out", "wrenches by name, and contacts, in the last step",
            rate_hz=RATE_HZ, frame_id=frame_id, delivery=on_request, read=lambda sim: _forces(source, sim, frame_id),
        ),
        Channel(
            source.topic("force_arrows"), MARKERS, "out", "the same forces as arrows; the longest is 1 m long",
            rate_hz=RATE_HZ, frame_id=frame_id, delivery=on_request, read=lambda sim: _arrows(source, sim, frame_id),
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


def _arrows(source: Source, sim: Simulator, frame_id: str) -> Any:
    """Return an arrow for each force from the body's origin, and one for each contact from its point."""
    forces, (points, pushes) = source.of(sim).forces, _contacts(source, sim)
    origin = np.zeros(3)
    arrows = [(name, index, origin, forces[name].force_body_n) for index, name in enumerate(forces)]
    arrows += [("contacts", index, *each) for index, each in enumerate(zip(points, pushes, strict=True))]
    longest_n = max((float(np.linalg.norm(force)) for *_, force in arrows), default=0.0)
    header = build.header(sim.time_ns, frame_id)
    shown = [
        _arrow(header, name, index, start, start + LONGEST_M / longest_n * force)
        for name, index, start, force in arrows
        if np.linalg.norm(force) > LEAST * longest_n
    ]
    return build.message(MARKERS, markers=[build.message(MARKER, header=header, action=DELETE_ALL), *shown])


def _arrow(header: Any, name: str, index: int, start: NDArray[np.float64], end: NDArray[np.float64]) -> Any:
    return build.message(
        MARKER, header=header, ns=name, id=index, type=ARROW, action=ADD, pose=still_pose(),
        scale=build.vector((0.02, 0.05, 0.08)),  # of the shaft and the head, and the head's length
        color=_colour(name), points=[build.xyz("geometry_msgs/msg/Point", point) for point in (start, end)],
    )  # fmt: skip


@cache
def still_pose() -> Any:
    """Return the pose of a marker in its own frame."""
    return build.message("geometry_msgs/msg/Pose", orientation=build.message("geometry_msgs/msg/Quaternion", w=1.0))


@cache
def _colour(name: str) -> Any:
    red, green, blue = COLOURS.get(name, COLOURS["contact"])
    return build.message("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0)
