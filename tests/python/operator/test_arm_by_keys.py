"""The pilot's keys move an arm while they are held: hand, joints and jaws. They do the gripper's exercises.

For the plug, whose socket is 8 mm wider on each side, the pilot takes a stick, and looks at the plug.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from arm_pilots import BASKET_M, GRIP_M, JAWS_M, SAMPLE_M, SOCKET_M, TAIL_M, before_the_lever
from uwsim import Simulator
from uwsim.base.axes import AXES
from uwsim.base.quaternions import turned
from uwsim.channels.table import Table
from uwsim.exercises import Course, load_exercise
from uwsim.live import LiveSimulator
from uwsim.operator.station.controls.pilot import Pilot

pytestmark = pytest.mark.usefixtures("blank_figures")  # of the sheets
REACH = """
name: reach
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - name: rov
    start: {position_m: [0, 0, -4]}
    model:
      builds_on: bluerov2_heavy_alpha5
      name: with_a_camera
      cameras:
        front: {position_m: [0, 0, 0], yaw_pitch_roll_deg: [90, 30, 0], field_of_view_deg: 90, width: 8, height: 8}
"""
FAR, NEAR = 0.25, 0.1  # the pilot's gain, far from a place and near to it
AHEAD_S = 1.0  # for which a pilot thinks ahead
STILL_M_S, HARDEST = 0.02, 3.0  # where nothing moves for a second, a pilot turns the gain up
SURE_M, SURE_RAD = 0.008, 0.04  # nearer than this, no key is pressed


def _stick(value, sure):
    return float(np.clip(value / (4 * sure), -1.0, 1.0))


def _key(value, sure):
    return 0.0 if abs(value) < sure else math.copysign(1.0, value)


class Keys:
    """A pilot who sees where the jaws are, and presses keys for 0.1 s at a time, through the station's door."""

    def __init__(self, live: LiveSimulator) -> None:
        self.live, self.now_s = live, 100.0
        self.helm = Pilot(live, Table(live.simulator).steering, clock=lambda: self.now_s)
        live.command("hold", vehicle="rov", heading=True)  # the key H

    def press(self, for_s: float = 0.1, arm: dict[str, object] | None = None, **axes: float) -> None:
        for _ in range(round(for_s / 0.1)):
            self.helm.drive({"vehicle": "rov", **axes})
            if arm is not None:
                assert self.helm.move_arm({"vehicle": "rov", **arm}).result(10.0)["success"]
            self.helm.beat()
            self.live.step(round(0.1 / self.live.simulator.step_s))
            self.now_s += 0.1

    def jaws_to(
        self, place, heading_rad=0.0, *, within_m=0.02, for_s=1.0, limit_s=40.0, gain=NEAR, push=_key, held=None
    ):
        """Bring the middle between the jaws to a place, and keep it there for a while; return False if it takes longer.

        heading_rad: None for any. push: _key or _stick. held: what the jaws hold, which is brought there instead.
        """
        inside_s = still_s = 0.0
        for _ in range(round(10 * limit_s)):
            turn, velocity = self.live.rov.pose.world_from_body[:3, :3], self.live.rov.velocity
            jaws = self.live.rov.pose.position_world_m + turn @ [JAWS_M[0], 0.0, JAWS_M[1]]
            here = jaws if held is None else self.live.simulator.objects[held].pose.position_world_m
            off = turn.T @ (np.asarray(place) - here)
            heading = math.atan2(turn[1, 0], turn[0, 0])
            yaw = 0.0 if heading_rad is None else math.remainder(heading_rad - heading, math.tau)
            inside_s = inside_s + 0.1 if np.linalg.norm(off) < within_m and abs(yaw) < 0.08 else 0.0
            if inside_s >= for_s:
                return True
            is_still = np.linalg.norm(velocity.linear_body_m_s) < STILL_M_S
            still_s = still_s + 0.1 if is_still and not inside_s else 0.0
            harder = min(1.0 + still_s, HARDEST)
            wanted = off - AHEAD_S * velocity.linear_body_m_s
            share = FAR if np.linalg.norm(off) > 0.4 else gain * harder
            turning = yaw - AHEAD_S * velocity.angular_body_rad_s[2] if heading_rad is not None else 0.0
            keys = {axis: share * push(far, SURE_M) for axis, far in zip(AXES[:3], wanted, strict=True)}
            self.press(**keys, yaw=NEAR * harder * push(turning, SURE_RAD))
        return False

    def grip(self, share, for_s=2.5):
        """Hold the key that closes or opens the jaws, and let go of it."""
        self.press(for_s, arm={"grip": share})
        self.press(arm={})


def started(scenario):
    return LiveSimulator(Simulator(scenario), paused=True)


def test_the_hand_goes_where_the_camera_looks_and_stops_with_silence(tmp_path: Path):
    path = tmp_path / "reach.yaml"
    path.write_text(REACH)
    with started(path) as live:
        keys, arm = Keys(live), live.rov.arm
        front = live.rov.cameras["front"]

        def hand():  # along the camera's axes, from the vehicle
            body = (np.linalg.inv(live.simulator.rov.pose.world_from_body) @ arm.poses_world()["jaw"])[:3, 3]
            return turned([-1, -1, -1, 1] * front.mounting_xyzw(), body)

        live.command("set_joints", vehicle="rov", positions={"shoulder": 0.5, "upperarm": 1.0, "forearm": 1.4})
        keys.press(6.0)
        for axis, share in ((0, 0.5), (1, -0.5), (2, -0.5)):
            before, share_of = hand(), np.zeros(3)
            share_of[axis] = share
            keys.press(1.0, arm={"hand": share_of.tolist(), "camera": "front"})
            assert hand() - before == pytest.approx(0.1 * share_of, abs=0.006), axis
        keys.press(0.4, arm={"joints": {"wrist": 1.0}})
        assert arm.read().speeds[3] == pytest.approx(arm.speed_limits["wrist"], rel=0.02)
        keys.press(0.4)
        assert arm.read().speeds[3] > 0.8
        keys.press(0.4)  # 0.5 s after the last call
        assert not arm.read().speeds.round(3).any()
        for wrong in ({"joints": {"elbow": 1.0}}, {"joints": {"wrist": 1.1}}, {"hand": [1, 0]}, {"hand": [1, 0, "x"]},
                      {"grip": 1.0}, {"camera": "rear"}, {"vehicle": "boat"}):  # fmt: skip
            with pytest.raises(ValueError, match=next(iter(wrong))):
                keys.helm.move_arm({"vehicle": "rov", **wrong})


def test_jaws_stop_where_the_key_is_let_go_unless_they_press():
    """That they press on is in the exercises: what they hold is lifted."""
    with started("panel") as live:
        keys, arm = Keys(live), live.rov.arm
        keys.grip(0.5, for_s=0.5)
        keys.press(1.0)
        now = arm.read()
        assert now.positions == pytest.approx([0.01, 0.01], abs=0.003) and not now.speeds.round(3).any()
        with pytest.raises(ValueError, match="fewer than two motors"):
            keys.helm.move_arm({"vehicle": "rov", "hand": [1, 0, 0]})


def test_jaws_are_known_by_what_brings_them_together(tmp_path: Path):
    model = """
name: hand
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - name: rov
    start: {position_m: [0, 0, -4]}
    model:
      builds_on: bluerov2_heavy
      name: hand
      arm:
        palm: &part {mass_kg: 0.1, inertia_kg_m2: [1.0e-4, 1.0e-4, 1.0e-4]}
        port: &finger
          <<: *part
          on: palm
          position_m: [0.05, 0.03, 0]
          centre_of_mass_m: [0.05, 0, 0]
          hinge: {motor: {strongest_nm: 1, fastest_deg_s: 9}}
        starboard: {<<: *finger, position_m: [0.05, -0.03, 0]}
"""
    path = tmp_path / "hand.yaml"
    path.write_text(model)
    with Simulator(path) as sim:
        assert sim.rov.arm.jaws == {"port": -1.0, "starboard": 1.0} and sim.rov.arm.hand == "palm"


def pull_the_pin(keys):
    keys.jaws_to((GRIP_M[0] - 0.3, *GRIP_M[1:]))
    keys.jaws_to(GRIP_M)
    keys.grip(1.0)
    keys.press(3.0, surge=-0.25)
    keys.grip(-1.0)
    keys.jaws_to((0.44, 0.5, -3.6), None, within_m=0.3)


def take_the_sample(keys):
    above = (*SAMPLE_M[:2], -3.75)
    keys.jaws_to((SAMPLE_M[0] - 0.3, *SAMPLE_M[1:]))
    keys.jaws_to(SAMPLE_M)
    keys.grip(1.0)
    keys.jaws_to(above, gain=0.25, within_m=0.05)
    keys.jaws_to((*BASKET_M[:2], above[2]), within_m=0.05)
    keys.jaws_to(BASKET_M, within_m=0.05)
    keys.grip(-1.0)
    keys.press(3.0)


def turn_the_valve(keys):
    keys.grip(1.0)
    keys.jaws_to(before_the_lever(0, before_m=0.3)[0])
    for angle_deg in range(0, 101, 10):
        keys.jaws_to(*before_the_lever(angle_deg), within_m=0.04, for_s=0.1, gain=0.25)
    keys.jaws_to((2.3, 0.3, -2.8), None, within_m=0.2)
    keys.jaws_to((0, 0.94, -3.6), None, within_m=0.3)


def plug_the_connector(keys):
    above, plugged = (*TAIL_M[:2], -3.4), (2.84, -0.204, -3.6)
    keys.jaws_to((TAIL_M[0] - 0.3, *TAIL_M[1:]))
    keys.jaws_to(TAIL_M, within_m=0.01, push=_stick)
    keys.grip(1.0)
    keys.jaws_to(above, within_m=0.03)
    keys.jaws_to((SOCKET_M[0] - 0.2, *above[1:]), within_m=0.03)
    for _ in range(5):  # a plug that meets the edge of its socket is drawn back, and tried again
        keys.jaws_to((plugged[0] - 0.2, *plugged[1:]), within_m=0.008, for_s=0.5, push=_stick, held="plug")
        if keys.jaws_to(plugged, for_s=0.5, limit_s=10.0, push=_stick, held="plug"):
            break
    keys.grip(-1.0)
    keys.jaws_to((SOCKET_M[0] - 0.2, *SOCKET_M[1:]), within_m=0.05)


SEEDS = [0, 1, 2, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(3, 20))]


@pytest.mark.parametrize("seed", SEEDS)  # of all noise: what only one processor's last bits allow fails at another
@pytest.mark.parametrize("name, fly", [
    ("pin", pull_the_pin), ("sample", take_the_sample), ("valve", turn_the_valve), ("wet-mate", plug_the_connector),
])  # fmt: skip
def test_the_gripper_s_exercises_are_done_by_keys(name, fly, seed):
    exercise = load_exercise(name).in_world()
    sim = Simulator(exercise.made_scenario(), seed=seed)
    course = Course(exercise, sim).attach()
    with LiveSimulator(sim, paused=True) as live:
        fly(Keys(live))
        state = live.read(lambda sim: course.state()).result()
    assert state["score"] == exercise.points, state
