"""Laws of the pilot, which need neither ROS nor the simulator."""

import math
from types import SimpleNamespace

import pytest

from pilot.pilot import BEFORE_M, LEVEL_RAD, SONAR_M, Pilot


def odom(x=0.0, y=0.0, z=-1.7, yaw=0.0):
    """Return the message for a vehicle at rest."""
    pose = SimpleNamespace(
        position=SimpleNamespace(x=x, y=y, z=z),
        orientation=SimpleNamespace(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )
    still = SimpleNamespace(twist=SimpleNamespace(angular=SimpleNamespace(z=0.0)))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose), twist=still)


def test_echoes_are_in_the_frame_of_odom_and_only_those_of_a_level_scan():
    pilot = Pilot(log=str)
    scan = SimpleNamespace(ranges=[2.0, 0.0], angle_min=0.5, angle_increment=0.1, range_min=0.0, range_max=50.0)
    pilot.receive("odom", odom(1.0, 2.0, yaw=0.3))
    pilot.receive("scan", scan)
    assert pilot.echoes == []
    pilot.tilt_rad = LEVEL_RAD
    pilot.receive("scan", scan)
    ((x, y),) = pilot.echoes
    ahead, left = SONAR_M[0] + 2.0 * math.cos(0.5), 2.0 * math.sin(0.5)
    assert x == pytest.approx(1.0 + ahead * math.cos(0.3) - left * math.sin(0.3))
    assert y == pytest.approx(2.0 + ahead * math.sin(0.3) + left * math.cos(0.3))


@pytest.mark.parametrize("yaw", [-0.3, 0.0, 0.3])
def test_it_stops_before_the_pipes_and_square_to_them(yaw):
    pilot = Pilot(log=str)
    along = (-math.sin(yaw), math.cos(yaw))
    pilot.see_pipes([(5.0 + k * along[0], 3.0 + k * along[1]) for k in (-1.0, -0.4, 0.2, 1.0)])
    x, y, _, heading = pilot.steering.way[-1]
    assert heading == pytest.approx(yaw)
    assert (5.0 - x, 3.0 - y) == pytest.approx((BEFORE_M * math.cos(yaw), BEFORE_M * math.sin(yaw)))


def test_without_a_pose_it_commands_nothing_and_without_echoes_it_goes_on():
    pilot = Pilot(log=str)
    assert pilot.commands() == []
    pilot.see_buoy([])
    assert pilot.steering.way == []
