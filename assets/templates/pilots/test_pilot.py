"""Laws of the pilot, which need neither ROS nor the simulator."""

import base64
import math
from types import SimpleNamespace

import pytest

from pilot import pilot as own
from pilot.pilot import SONAR_M, TILT_RAD, Pilot, middle, things


def odom(x, y, z, yaw):
    """Return the message for a level vehicle at rest."""
    pose = SimpleNamespace(
        position=SimpleNamespace(x=x, y=y, z=z),
        orientation=SimpleNamespace(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )
    still = SimpleNamespace(twist=SimpleNamespace(angular=SimpleNamespace(z=0.0)))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose), twist=still)


@pytest.mark.parametrize(("yaw", "beam"), [(0.0, 0.0), (0.3, 0.4), (-2.0, -0.2)])
def test_an_echo_above_the_bed_is_where_the_scan_shows_it(yaw, beam):
    pilot = Pilot(log=str)
    pilot.receive("odom", odom(1.0, 2.0, -2.2, yaw))
    pilot.commands()  # it begins the lanes
    pilot.receive("scan", SimpleNamespace(ranges=[0.0, 3.2], angle_min=beam - 0.1, angle_increment=0.1, range_min=0.1))
    ((x, y),) = pilot.echoes
    ahead, left = SONAR_M[0] + 3.2 * math.cos(beam) * math.cos(TILT_RAD), 3.2 * math.sin(beam)
    assert x == pytest.approx(1.0 + ahead * math.cos(yaw) - left * math.sin(yaw), abs=0.03)
    assert y == pytest.approx(2.0 + ahead * math.sin(yaw) + left * math.cos(yaw), abs=0.03)


def test_echoes_near_to_each_other_are_one_thing_and_few_are_none():
    line = [(0.1 * k, 2.0) for k in range(20)]
    found = things([*line, *((5.0 + 0.1 * k, 0.0) for k in range(10)), (9.0, 9.0)])
    assert [len(each) for each in found] == [20, 10]
    assert middle(found[0]) == pytest.approx((0.95, 2.0))


def test_without_a_pose_it_commands_nothing():
    assert Pilot(log=str).commands() == []


def picture(buoy):
    """Return turbid water with a buoy of a colour in its middle."""
    rows = [[(16, 116, 94)] * 64 for _ in range(36)]
    for row in rows[14:22]:
        row[28:36] = [buoy] * 8
    data = bytes(value for row in rows for pixel in row for value in pixel)
    return SimpleNamespace(data=base64.b64encode(data).decode(), width=64, height=36, step=3 * 64)


@pytest.mark.skipif(not hasattr(own, "yellowness"), reason="this pilot reads no picture")
def test_a_yellow_buoy_is_yellower_than_a_red_one():
    assert own.yellowness(picture((25, 150, 90))) > own.yellowness(picture((45, 105, 88)))
