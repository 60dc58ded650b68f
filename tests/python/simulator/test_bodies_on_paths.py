"""Bodies on paths: their motion is smooth, a function of time alone; nothing changes it; all perceive and feel it."""

from math import pi

import numpy as np
import pytest

from sites import flat, rov
from uwsim import Simulator
from uwsim.scenario import ScenarioError

BALL = {"kind": "sphere", "name": "diver", "position_m": [0, 0, -5], "radius_m": 0.4}


def on_path(shape: dict, **path: object) -> dict:
    return {"shape": shape, "path": path}


def site(*objects: dict, vehicle: dict | None = None, **changes: object) -> Simulator:
    return Simulator(flat(vehicle or rov(position_m=(-8, 0, -5)), objects=list(objects), **changes))


def state_bytes(sim: Simulator) -> bytes:
    pose, velocity = sim.objects["diver"].pose, sim.objects["diver"].velocity
    values = (pose.position_world_m, pose.orientation_xyzw, velocity.linear_body_m_s, velocity.angular_body_rad_s)
    return np.concatenate(values).tobytes()


def test_a_straight_path_is_followed_at_its_speed_and_ends_in_rest() -> None:
    """A trapezium of speed: 2 s to the speed, and as long to stop."""
    sim = site(on_path(BALL, points_m=[[6, 8, -5]], speed_m_s=0.5))
    sim.advance(9.0)
    diver = sim.objects["diver"]
    assert diver.pose.position_world_m == pytest.approx([0.6 * 4.0, 0.8 * 4.0, -5], abs=1e-3)
    assert diver.velocity.linear_body_m_s == pytest.approx([0.5, 0, 0], abs=1e-3)
    assert diver.pose.yaw_rad == pytest.approx(np.arctan2(8, 6))
    sim.advance(15.0)
    assert diver.pose.position_world_m == pytest.approx([6, 8, -5], abs=1e-6)
    assert not diver.velocity.linear_body_m_s.any()


@pytest.mark.parametrize("climbs", [False, True])
def test_velocity_is_the_derivative_of_the_pose_also_at_the_points_of_the_path(climbs: bool) -> None:
    block = {"kind": "box", "name": "diver", "position_m": [0, 0, -5], "size_m": [1, 0.4, 0.3]}
    block["yaw_pitch_roll_deg"] = [20, 5, 3]
    points = [[4, 1, -4], [6, 5, -6], [1, 7, -5]]
    times = [6.0, 9.0, 17.0, 21.0]
    step_s = 0.001
    sim = site(on_path(block, points_m=points, times_s=times, closed=True, climbs=climbs), step_s=step_s)
    diver = sim.objects["diver"]
    speeds = []
    for until_s in (0.002, 3.0, 5.998, 6.001, 8.998, 9.001, 20.998, 21.001):
        sim.advance(round(until_s - sim.time_s, 3))
        before, velocity = diver.pose, diver.velocity
        sim.step()
        after = diver.pose
        turn = before.world_from_body[:3, :3].T @ after.world_from_body[:3, :3]
        omega = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / (2 * step_s)
        mean = 0.5 * (velocity.angular_body_rad_s + diver.velocity.angular_body_rad_s)
        assert omega == pytest.approx(mean, abs=1e-4)
        moved = (after.position_world_m - before.position_world_m) / step_s
        ends = (
            before.world_from_body[:3, :3] @ velocity.linear_body_m_s,
            after.world_from_body[:3, :3] @ diver.velocity.linear_body_m_s,
        )
        assert moved == pytest.approx(0.5 * (ends[0] + ends[1]), abs=1e-4)
        speeds.append(ends[0])
    assert speeds[2] == pytest.approx(speeds[3], abs=0.01), "no jump at a point"
    assert speeds[6] == pytest.approx(speeds[7], abs=0.01), "no jump at the start of the next round"


def test_a_closed_path_repeats_and_looks_along_itself() -> None:
    corners = [[5 * np.cos(a), 5 * np.sin(a), -5] for a in 2 * pi * np.arange(1, 12) / 12]
    sim = site(on_path({**BALL, "position_m": [5, 0, -5]}, points_m=corners, speed_m_s=1.0, closed=True))
    diver = sim.objects["diver"]
    sim.advance(4.0)
    x, y, _ = diver.pose.position_world_m
    assert np.hypot(x, y) == pytest.approx(5.0, rel=1e-3) and np.arctan2(y, x) == pytest.approx(0.8, rel=1e-2)
    assert diver.velocity.linear_body_m_s == pytest.approx([1, 0, 0], abs=1e-3)
    assert diver.velocity.angular_body_rad_s == pytest.approx([0, 0, 0.2], abs=0.01)


def test_a_boat_at_anchor_heaves_in_place_with_its_own_heading() -> None:
    boat = {"kind": "box", "name": "diver", "position_m": [2, 1, -5], "size_m": [1, 0.4, 0.3]}
    sim = site(on_path(boat | {"yaw_pitch_roll_deg": [40, 0, 0]}, points_m=[[2, 1, -4]], times_s=[3.0, 6.0],
                       closed=True, turns=False))  # fmt: skip
    for until_s, height_m, climb_m_s in ((1.5, -4.5, None), (3.0, -4.0, 0.0), (4.5, -4.5, None), (6.0, -5.0, 0.0)):
        sim.advance(until_s - sim.time_s)
        pose, velocity = sim.objects["diver"].pose, sim.objects["diver"].velocity
        assert pose.position_world_m == pytest.approx([2, 1, height_m], abs=1e-9)
        assert pose.yaw_rad == pytest.approx(np.radians(40)) and not velocity.angular_body_rad_s.any()
        assert climb_m_s is None or velocity.linear_body_m_s == pytest.approx([0, 0, climb_m_s], abs=1e-9)


def test_a_vehicle_is_pushed_and_the_body_is_not() -> None:
    hammer = {"kind": "box", "name": "diver", "position_m": [-12, 0, -5], "size_m": [1, 2, 2]}
    path = {"points_m": [[20, 0, -5]], "speed_m_s": 0.5}
    sim = site(on_path(hammer, **path))
    alone = site(on_path(hammer, **path), vehicle=rov(position_m=(0, 9, -5)))
    start = sim.rov.pose.position_world_m
    others = set()
    for _ in range(16):
        sim.advance(1.0)
        alone.advance(1.0)
        assert state_bytes(sim) == state_bytes(alone)
        others |= {contact.other for contact in sim.rov.contacts}
    assert "diver" in others and sim.rov.collisions > 0
    assert sim.rov.pose.position_world_m[0] - start[0] > 2.0
    with pytest.raises(ValueError, match="must not follow a path"):
        _ = sim.objects["diver"].forces


def test_instruments_perceive_it_where_it_is() -> None:
    wall = {"kind": "box", "name": "diver", "position_m": [-3, 0, -5], "size_m": [1, 4, 4]}
    sim = site(on_path(wall, points_m=[[9, 0, -5]], speed_m_s=1.0), vehicle=rov("rov", (-10, 0, -5)))
    label = sim.label_names.index("diver")
    ranges = []
    for _ in range(2):
        ping = sim.rov.sonar.ping()
        ranges.append(float(ping.ranges_m[ping.labels == label].min()))
        frame = sim.rov.cameras["front"].capture()
        assert label in frame.labels
        sim.advance(4.0)
    assert ranges[1] - ranges[0] == pytest.approx(3.0, abs=0.25)


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"points_m": [[5, 0, -5]]}, "give one of speed_m_s and times_s"),
        ({"points_m": [[5, 0, -5]], "speed_m_s": 1, "times_s": [3]}, "give one of speed_m_s and times_s"),
        ({"points_m": [[5, 0, -5], [6, 0, -5]], "times_s": [3]}, "must be 2 times, one for each point"),
        ({"points_m": [[5, 0, -5], [6, 0, -5]], "times_s": [3, 2]}, r"times_s\[1\] = 2.*must be later"),
        ({"points_m": [[5, 0, -5], [5, 0, -5]], "speed_m_s": 1}, "must differ from the point before"),
        ({"points_m": [[5, 0, -5], [0, 0, -5]], "speed_m_s": 1, "closed": True}, "within 1 mm"),
        ({"points_m": [[5, 0, -20]], "speed_m_s": 1}, "object 'diver' is on its path at .* must be above the bed"),
        ({"points_m": [[0, 0, -9]], "speed_m_s": 1}, "straight up or down"),
        ({"points_m": [[20, 0, -5]], "times_s": [0.1]}, "must be at most 30 m/s"),
        ({"points_m": [[50, 0, -5]], "speed_m_s": 1}, "outside the terrain"),
    ],
)
def test_a_path_that_cannot_be_followed_is_refused(wrong: dict, rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        site(on_path(BALL, **wrong))


def test_what_does_not_belong_to_a_path_is_refused() -> None:
    path = {"points_m": [[5, 0, -5]], "speed_m_s": 1}
    with pytest.raises(ScenarioError, match="must be left out for a body on a path"):
        site(on_path(BALL, **path) | {"mass_kg": 80.0})
    with pytest.raises((ScenarioError, ValueError), match="must be uwsim for bodies on a path"):
        site(on_path(BALL, **path), dynamics={"engine": "bullet"})
