"""Fins and wings in SDF and URDF: gz-sim's system LiftDrag, UUV Simulator's fins, and the joints that turn them.

Sources: gz-sim's LiftDrag.cc; UUV Simulator's FinPlugin.cc and LiftDragModel.cc. Lift is q A cla (alpha + angle of the
joint), with q = rho V^2 / 2. A fin of uwsim has the same slope of lift through its aspect ratio: cla = pi a / (1 +
sqrt(1 + a^2 / 4)), which is below 2 pi.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from uwsim.exchange.robots.links import Joint, Links
from uwsim.exchange.robots.robot import Description, Fin, Robot, plain_name
from uwsim.exchange.robots.xml_file import Element, Floats, Pose

AIR_KG_M3, SLOPE, STALL_RAD = 1.2041, 1.0, math.pi / 2
"""gz-sim's defaults: of air_density, cla and alpha_stall."""
MOST_LIFT_RAD = math.pi / 4
STALL_DEG = (1.0, 89.0)
"""Stall angles of uwsim; a surface that stalls beyond them does not."""
STRAIGHT = 0.999
QUADRATIC_SLOPE = 2.603
"""The slope [1/rad] of a fin of which only the lift as a whole is stated: aspect ratio 2."""


class _Lift(NamedTuple):
    """Where a surface of a link is and how it lifts. Directions and the centre of pressure: in the link's frame."""

    forward: Floats
    upward: Floats
    centre_m: Floats
    slope: float
    density_area_kg_m: float
    stall_rad: float


def is_lift_drag(file: str) -> bool:
    """Return whether a plugin's file, in small letters, is LiftDrag, of Gazebo, or asv_sim's of foils.

    Those of others, such as AdvancedLiftDrag and that of sails, have coefficients of another meaning.
    """
    return ("lift-drag" in file or "liftdrag" in file) and not any(word in file for word in ("advanced", "sail"))


def put_surface(robot: Robot, plugin: Element, links: Links, to_base: Pose, found: Description) -> None:
    """Add the fin of a LiftDrag plugin, or a note if uwsim has no such surface. Raises ValueError.

    Water whose density is not stated elsewhere has the plugin's.
    """
    density = plugin.number("air_density", plugin.number("fluid_density", AIR_KG_M3))
    centre = plugin.numbers("cp", 3)
    lift = _Lift(
        _direction(plugin, "forward", 0), _direction(plugin, "upward", 2), np.zeros(3) if centre is None else centre,
        plugin.number("cla", SLOPE), density * plugin.number("area", 1.0), plugin.number("alpha_stall", STALL_RAD),
    )  # fmt: skip
    if plugin.text("control_joint_name"):
        found.left_out(f"{plugin.path}: control_joint_name, a flap; the whole surface turns by its own joint")
    if _put(robot, plugin, plugin, lift, links, to_base, found) and found.density_kg_m3 is None:
        found.density_kg_m3 = density


def put_uuv_fin(robot: Robot, plugin: Element, links: Links, to_base: Pose, found: Description) -> None:
    """Add the fin of UUV Simulator's plugin, x ahead and z along its span. Raises ValueError."""
    model = plugin.find("liftdrag")
    if model is None:
        raise plugin.error("has no liftdrag")
    kind = model.text("type") or ""
    if kind == "TwoLines":
        slope, area = model.number("cla"), model.number("fluid_density") * model.number("area")
        stall = model.number("alpha_stall")
    elif kind == "Quadratic":
        slope, stall = QUADRATIC_SLOPE, STALL_RAD
        area = 2.0 * model.number("lift_constant") / slope
        found.assumed(f"{model.path}: a fin of aspect ratio 2, with the stated lift")
    else:
        raise model.error(f"type '{kind}': must be TwoLines or Quadratic")
    if plugin.number("dynamics/timeConstant", 0.0) > 0.0:
        found.left_out(f"{plugin.path}: the lag of its servo; fins turn at a limited rate")
    lift = _Lift(np.eye(3)[0], np.eye(3)[1], np.zeros(3), slope, area, stall)
    _put(robot, plugin, model, lift, links, to_base, found)


def _put(
    robot: Robot, plugin: Element, stated: Element, lift: _Lift, links: Links, to_base: Pose, found: Description
) -> bool:
    """Add a fin; return whether uwsim has such a surface. stated: the element with its coefficients."""
    link = plugin.text("link_name") or ""
    pose = to_base.then(links.pose(link, plugin))
    if not (lift.slope > 0.0 and lift.density_area_kg_m > 0.0):
        raise stated.error(f"slope of lift {lift.slope:g}: must be positive, as area and density")
    if lift.slope >= 2.0 * math.pi:
        larger = lift.slope / QUADRATIC_SLOPE
        found.assumed(
            f"{stated.path}: slope of lift {lift.slope:g}: no fin has one of 2 pi: one of aspect ratio 2 and an area "
            f"{larger:.3g} times as large, which has the same lift"
        )
        lift = lift._replace(slope=QUADRATIC_SLOPE, density_area_kg_m=lift.density_area_kg_m * larger)
    span = pose.turn @ np.cross(lift.forward, lift.upward)
    if not np.linalg.norm(span) > 1e-3:
        raise plugin.error("forward and upward must be two directions")
    span /= np.linalg.norm(span)
    if (pose.turn @ lift.forward)[0] < STRAIGHT or abs(span[0]) > 1e-6:
        found.dropped(plugin, f" of link '{link}': its forward direction is not the vehicle's")
        return False
    joint = next((each for each in links.joints.values() if each.child == link), None)
    travel_rad = 0.0
    if joint is not None and joint.kind in ("revolute", "continuous"):
        axis = to_base.turn @ joint.axis
        if abs(axis @ span) < STRAIGHT:
            found.dropped(plugin, f" of link '{link}': joint '{joint.name}' does not turn it about its span")
            return False
        span, travel_rad = span * np.sign(axis @ span), _travel_rad(plugin, joint, found)
    if stated.number("a0", 0.0) != 0.0:
        found.left_out(f"{stated.path}: a0 = {stated.number('a0'):g} rad, its lift at no angle")
    found.assumed(f"{plugin.path}: the drag of its lift, and its lift in stall, are those of uwsim's fins")
    stall_deg = math.degrees(lift.stall_rad)
    name = plain_name(link.removesuffix("_link"), [each.name for each in robot.fins])
    robot.fins.append(Fin(
        name, pose.points(lift.centre_m[None])[0], span, lift.density_area_kg_m, aspect_ratio(lift.slope),
        stall_deg if STALL_DEG[0] <= stall_deg <= STALL_DEG[1] else None, math.degrees(travel_rad),
    ))  # fmt: skip
    return True


def aspect_ratio(slope: float) -> float:
    """Return the aspect ratio of a fin whose lift coefficient rises by a slope [1/rad] below 2 pi."""
    share = math.pi / slope
    return 2.0 * share / (share * share - 0.25)


def _direction(plugin: Element, key: str, default: int) -> Floats:
    found = plugin.numbers(key, 3)
    return np.eye(3)[default] if found is None else found / max(float(np.linalg.norm(found)), 1e-9)


def _travel_rad(plugin: Element, joint: Joint, found: Description) -> float:
    """Return the smaller of a joint's two limits, at most 45 deg.

    The lift of uwsim's fins, C_La sin a cos a, falls beyond that angle, while that of UUV Simulator's grows with it: a
    controller that turned a fin further would steer the other way.
    """
    low, high = joint.limits_rad
    if not low <= 0.0 <= high:
        raise plugin.error(f"joint '{joint.name}': limits from {low:g} to {high:g} rad: must include 0")
    if abs(low + high) > 1e-3:
        found.assumed(f"joint '{joint.name}': it turns by the smaller of its limits in both directions")
    travel_rad = min(-low, high)
    if travel_rad > MOST_LIFT_RAD + 1e-6:
        limit_deg = math.degrees(min(travel_rad, math.pi))
        found.assumed(f"joint '{joint.name}': it turns by 45 deg, at which its lift is greatest, not {limit_deg:.0f}")
    return min(travel_rad, MOST_LIFT_RAD)
