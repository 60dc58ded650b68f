"""PX4's plugins for Gazebo Classic: a hull's water, and the speeds to which its flight stack can set each motor.

Sources: PX4-SITL_gazebo-classic, gazebo_uuv_plugin.cpp and gazebo_mavlink_interface.cpp. Damping is linear, at the base
link; the buoyancy of a link is a share, its compensation, of that link's weight, at a point of it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from uwsim.exchange.robots.links import Links, carried
from uwsim.exchange.robots.robot import Found, Robot
from uwsim.exchange.robots.xml_file import Element, Pose

DENSITY_KG_M3 = 1000.0


def is_px4_hull(file: str) -> bool:
    """Return whether a plugin's file is that of the hull's water."""
    return "gazebo_uuv_plugin" in file


def put_px4_hull(robot: Robot, found: Found, plugin: Element, links: Links, to_base: Pose) -> None:
    """Read the damping, added mass and buoyancy of a hull. Raises ValueError."""
    there = to_base.then(links.pose(plugin.text("baseLinkName") or "", plugin))
    if found.density_kg_m3 is None:
        found.density_kg_m3 = DENSITY_KG_M3
        found.assumed(f"{plugin.path}: water of {DENSITY_KG_M3:g} kg/m3")
    values = {}
    for key in ("addedMass", "damping"):
        parts = [plugin.numbers(f"{key}{way}", 3) for way in ("Linear", "Angular")]
        values[key] = carried(np.diag(np.concatenate([np.zeros(3) if each is None else each for each in parts])), there)
    robot.added_mass, robot.linear, robot.quadratic = values["addedMass"], values["damping"], np.zeros((6, 6))
    found.assumed(f"{plugin.path}: its added mass also resists acceleration, which Gazebo Classic leaves out")
    volumes, centres = [], []
    for each in plugin.all("buoyancy"):
        link, origin = each.text("link_name") or "", each.numbers("origin", 3)
        at, lump = to_base.then(links.pose(link, each)), links.lumps.get(link)
        volumes.append(each.number("compensation", 0.0) * (0.0 if lump is None else lump.mass_kg) / found.density_kg_m3)
        centres.append(at.points((np.zeros(3) if origin is None else origin)[None])[0])
    if sum(volumes) > 0.0:
        robot.volume_m3, robot.centre_of_buoyancy_m = sum(volumes), np.average(centres, axis=0, weights=volumes)


def px4_speeds(plugin: Element) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the number of each motor that a flight stack drives, and its speeds at the ends of its output, -1 and 1."""
    channels = plugin.find("control_channels")
    for channel in () if channels is None else channels.all("channel"):
        offset, scale = channel.number("input_offset", 0.0), channel.number("input_scaling", 1.0)
        ends = sorted(scale * (end + offset) + channel.number("zero_position_armed", 0.0) for end in (-1.0, 1.0))
        yield channel.text("input_index") or "", (ends[0], ends[1])
