"""Pan-tilt cameras: they turn at a finite rate, frames and images follow, commands are logged and replayed."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from channel_tools import chain, table
from uwsim import Simulator
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator, replay
from uwsim.scenario.build.camera import mount_orientation_xyzw

RATE_RAD_S = math.radians(30.0)
WRONG = (1.6, -1.6, math.nan)


@pytest.fixture(scope="module")
def shared():
    return Simulator("pool")


@pytest.fixture
def sim(shared):
    shared.reset()
    assert shared.rov.cameras["front"].aim_rad == (0.0, 0.0)
    return shared


def optical_axes(camera):
    """Return the right, down and forward axes of a camera that looks along its x."""
    ahead, left, up = camera.world_from_camera[:3, :3].T
    return np.stack([-left, -up, ahead], axis=1)


def test_it_turns_at_its_rate_and_stops_at_its_aim_also_in_a_restored_state(sim):
    camera = sim.rov.cameras["front"]
    before = camera.world_from_camera[:3, :3]
    camera.aim(pan_rad=0.5, tilt_rad=-0.2)
    sim.advance(0.3)
    state, half_way = sim.save_state(), (0.3 * RATE_RAD_S, -0.3 * RATE_RAD_S)
    sim.advance(2.0)
    camera.aim(tilt_rad=0.4)
    sim.advance(3.0)
    np.testing.assert_allclose(camera.aim_rad, [0.5, 0.4])
    turned = Rotation.from_euler("ZY", [0.5, 0.4]).as_matrix()  # about the camera's z, then its y
    np.testing.assert_allclose(camera.world_from_camera[:3, :3], before @ turned, atol=1e-9)
    sim.restore_state(state)
    np.testing.assert_allclose(camera.aim_rad, half_way)
    sim.advance(2.0)
    np.testing.assert_allclose(camera.aim_rad, [0.5, -0.2])


def test_frames_and_joints_follow(sim):
    camera, found = sim.rov.cameras["front"], table(sim)
    camera.aim(pan_rad=-0.7, tilt_rad=0.3)
    sim.advance(0.5)
    pose = chain(sim, found, "front_optical")
    np.testing.assert_allclose(pose[:3, :3], optical_axes(camera), atol=1e-9)
    np.testing.assert_allclose(pose[:3, 3], camera.world_from_camera[:3, 3], atol=1e-9)
    assert "front_optical" not in {t.child_frame_id for t in found["tf_static"].read(sim).transforms}
    joints = found["joint_states"].read(sim)
    angles = dict(zip(joints.name, joints.position, strict=True))
    np.testing.assert_allclose([angles["front_pan"], angles["front_tilt"]], camera.aim_rad)


def test_a_picture_is_of_its_snapshot_s_aim(sim):
    camera = sim.rov.cameras["front"]
    ahead = camera.snapshot()
    camera.aim(tilt_rad=1.0)
    sim.advance(3.0)
    late = camera.capture(at=ahead, geometry_only=True).world_from_camera
    mounting = Rotation.from_quat(mount_orientation_xyzw(camera.mount.yaw_pitch_roll_deg)).as_matrix()
    np.testing.assert_allclose(late[:3, :3], mounting, atol=1e-9)


def test_messages_aim_and_replay_to_the_same():
    with LiveSimulator("pool", paused=True) as live:
        aim = table(live.simulator)["camera/front/cmd_pan"].apply
        aim(live, build.message("std_msgs/msg/Float64", data=0.25))
        live.step(7)
        live.rov.cameras["front"].aim(tilt_rad=-0.1)
        live.step(100)
        np.testing.assert_allclose(live.rov.cameras["front"].aim_rad, [0.25, -0.1])
        for angle in WRONG:
            with pytest.raises(ValueError, match="camera/front/cmd_pan = "):
                aim(live, build.message("std_msgs/msg/Float64", data=angle))
        again = replay("pool", live.log, live.simulator.tick)
        assert again.save_state() == live.simulator.save_state()


def test_angles_beyond_the_motor_are_refused_whole(sim):
    camera = sim.rov.cameras["front"]
    for angle in WRONG:
        with pytest.raises(ValueError, match=r"camera 'rov[./]front': tilt_rad = .* rad: must be"):
            camera.aim(pan_rad=0.3, tilt_rad=angle)
    sim.advance(1.0)
    assert camera.aim_rad == (0.0, 0.0)
    with pytest.raises(ValueError, match=r"camera 'rov[./]down': has no pan_tilt"):
        sim.rov.cameras["down"].aim(0.1)
    assert "camera/down/cmd_pan" not in table(sim)
