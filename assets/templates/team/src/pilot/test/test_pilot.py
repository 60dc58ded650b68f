"""Laws of the pilot, which need neither ROS nor the simulator."""

import math
from types import SimpleNamespace

import pytest

from pilot.pilot import Pilot


def odom(x=0.0, y=0.0, z=-1.1, yaw=0.0):
    """Return the message for a vehicle at rest."""
    pose = SimpleNamespace(
        position=SimpleNamespace(x=x, y=y, z=z),
        orientation=SimpleNamespace(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )
    still = SimpleNamespace(twist=SimpleNamespace(angular=SimpleNamespace(z=0.0)))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose), twist=still)


def scan_of(*posts, beams=512, half=0.74):
    """Return the scan from the origin of posts that are 6 cm wide, before a wall at 12 m."""
    step = 2.0 * half / (beams - 1)
    ranges = [12.0] * beams
    for x, y in posts:
        far, bearing = math.hypot(x, y), math.atan2(y, x)
        for k in range(beams):
            if abs(-half + k * step - bearing) * far <= 0.03:
                ranges[k] = far
    return SimpleNamespace(ranges=ranges, angle_min=-half, angle_increment=step, range_min=0.0, range_max=50.0)


@pytest.mark.parametrize("yaw", [0.0, 0.3, -0.4])
def test_a_post_is_where_the_scan_shows_it(yaw):
    pilot = Pilot(log=str)
    for _ in range(4):
        pilot.receive("odom", odom(1.0, 2.0, yaw=yaw))
        pilot.receive("scan", scan_of((4.0, 0.5)))
    ((x, y),) = pilot.posts.sure(-99.0)
    ahead, left = 0.24 + 4.0, 0.5
    assert x == pytest.approx(1.0 + ahead * math.cos(yaw) - left * math.sin(yaw), abs=0.02)
    assert y == pytest.approx(2.0 + ahead * math.sin(yaw) + left * math.cos(yaw), abs=0.02)


def test_it_aims_at_the_starboard_half_of_the_gate():
    pilot = Pilot(log=str)
    pilot.receive("odom", odom(x=-11.0))
    for _ in range(4):
        pilot.receive("scan", scan_of((5.0, -1.525), (5.0, 1.525), (8.0, -1.5), (8.0, 0.0), (8.0, 1.5)))
    (_, starboard), (_, middle) = pilot.opening()
    assert starboard == pytest.approx(-1.525, abs=0.03) and middle == pytest.approx(0.0, abs=0.03)


def test_without_a_pose_it_commands_nothing():
    assert Pilot(log=str).commands() == []
