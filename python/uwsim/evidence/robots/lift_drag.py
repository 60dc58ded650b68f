"""Fins and wings in SDF: gz-sim's system LiftDrag, and the joint that turns its link.

Source: gz-sim's LiftDrag.cc. Lift is q A cla (alpha + angle of the joint), with q = rho V^2 / 2. A fin of uwsim has the
same slope of lift through its aspect ratio: cla = pi a / (1 + sqrt(1 + a^2 / 4)), which is below 2 pi.
"""

from __future__ import annotations

import math

import numpy as np

from uwsim.evidence.robots.links import Joint, Links
from uwsim.evidence.robots.robot import Fin, Found, Robot, plain_name
from uwsim.evidence.robots.xml_file import Element, Floats, Pose

AIR_KG_M3, SLOPE, STALL_RAD = 1.2041, 1.0, math.pi / 2
"""gz-sim's defaults: of air_density, cla and alpha_stall."""
STALL_DEG = (1.0, 89.0)
"""Stall angles of uwsim; a surface that stalls beyond them does not."""
STRAIGHT = 0.999


def is_lift_drag(file: str) -> bool:
    """Return whether a plugin's file, in small letters, is LiftDrag, of gz-sim or of Gazebo Classic."""
    return "lift-drag" in file or "liftdrag" in file


def put_surface(robot: Robot, plugin: Element, model: Element, links: Links, to_base: Pose, found: Found) -> None:
    """Add the fin of a LiftDrag plugin, or a note if uwsim has no such surface. Raises ValueError.

    Water whose density is not stated elsewhere has the plugin's.
    """
    fin = _surface(plugin, model, links, to_base, found, [each.name for each in robot.fins])
    if fin is not None:
        robot.fins.append(fin)
        if found.density_kg_m3 is None:
            found.density_kg_m3 = plugin.number("air_density", AIR_KG_M3)


def _surface(
    plugin: Element, model: Element, links: Links, to_base: Pose, found: Found, others: list[str]
) -> Fin | None:
    link = plugin.text("link_name") or ""
    pose = to_base.then(links.pose(link, plugin))
    slope, area = plugin.number("cla", SLOPE), plugin.number("area", 1.0)
    if not (0.0 < slope < 2.0 * math.pi and area > 0.0):
        raise plugin.error(f"cla = {slope:g}, area = {area:g} m2: must be in (0, 2 pi), and positive")
    forward, upward = (_direction(plugin, key, default) for key, default in (("forward", 0), ("upward", 2)))
    span = pose.turn @ np.cross(forward, upward)
    if not np.linalg.norm(span) > 1e-3:
        raise plugin.error("forward and upward must be two directions")
    span /= np.linalg.norm(span)
    if (pose.turn @ forward)[0] < STRAIGHT or abs(span[0]) > 1e-6:
        found.left_out(f"{plugin.path} of link '{link}': its forward direction is not the vehicle's")
        return None
    joint = next((each for each in links.joints.values() if each.child == link), None)
    travel_rad = 0.0
    if joint is not None and joint.kind == "revolute":
        axis = to_base.turn @ joint.axis
        if abs(axis @ span) < STRAIGHT:
            found.left_out(f"{plugin.path} of link '{link}': joint '{joint.name}' does not turn it about its span")
            return None
        span, travel_rad = span * np.sign(axis @ span), _travel_rad(model, joint, found)
    if plugin.number("a0", 0.0) != 0.0:
        found.left_out(f"{plugin.path}: a0 = {plugin.number('a0'):g} rad, its lift at no angle")
    if plugin.text("control_joint_name"):
        found.left_out(f"{plugin.path}: control_joint_name, a flap; the whole surface turns by its own joint")
    found.assumed(f"{plugin.path}: the drag of its lift, and its lift in stall, are those of uwsim's fins")
    stall_deg = math.degrees(plugin.number("alpha_stall", STALL_RAD))
    centre = plugin.numbers("cp", 3)
    return Fin(
        plain_name(link.removesuffix("_link"), others),
        pose.points((np.zeros(3) if centre is None else centre)[None])[0],
        span,
        area * plugin.number("air_density", AIR_KG_M3),
        aspect_ratio(slope),
        stall_deg if STALL_DEG[0] <= stall_deg <= STALL_DEG[1] else None,
        math.degrees(travel_rad),
    )


def aspect_ratio(slope: float) -> float:
    """Return the aspect ratio of a fin whose lift coefficient rises by a slope [1/rad] below 2 pi."""
    share = math.pi / slope
    return 2.0 * share / (share * share - 0.25)


def _direction(plugin: Element, key: str, default: int) -> Floats:
    found = plugin.numbers(key, 3)
    return np.eye(3)[default] if found is None else found / max(float(np.linalg.norm(found)), 1e-9)


def _travel_rad(model: Element, joint: Joint, found: Found) -> float:
    """Return the smaller of a joint's two limits."""
    element = next(each for each in model.all("joint") if each.name == joint.name)
    low, high = element.number("axis/limit/lower", -math.inf), element.number("axis/limit/upper", math.inf)
    if not low <= 0.0 <= high:
        raise element.error(f"limits from {low:g} to {high:g} rad: must include 0")
    if abs(low + high) > 1e-3 and math.isfinite(low + high):
        found.assumed(f"{element.path}: it turns by the smaller of its limits in both directions")
    return min(-low, high, math.pi / 2)
