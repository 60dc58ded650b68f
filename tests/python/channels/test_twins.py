"""Channels with the names and types of other stacks have the content of ours, and are sent on request only."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from all_stop_world import scenario
from channel_tools import stamp_ns, table
from uwsim import Simulator
from uwsim.channels import Channel, Table
from uwsim.channels.ros import build
from uwsim.channels.ros.messages import from_bytes, to_bytes
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.recording.replay import replay

NAME = "thrusters"  # a BlueROV2 Heavy
TWINS = {"robot_description", "cmd_vel_stamped", "imu/accel", "dvl/data", "usbl/pose", "thruster_states"}


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveSimulator]:
    with LiveSimulator(Simulator(scenario(tmp_path), seed=3), paused=True) as live:
        yield live


def found(live: LiveSimulator, **options: Any) -> dict[str, Channel]:
    every = table(live.simulator, **options)
    return {name.removeprefix(f"{NAME}/"): channel for name, channel in every.items() if name.startswith(f"{NAME}/")}


def publish(live: LiveSimulator, channel: Channel, message: Any) -> None:
    assert channel.authority.door is not None
    channel.authority.door.apply(live, channel, message, "a client")


def stamped(surge: float, stamp: int = 0, frame: str = "") -> Any:
    twist = build.message("geometry_msgs/msg/Twist", linear=build.vector((surge, 0.0, 0.0)))
    return build.message("geometry_msgs/msg/TwistStamped", header=build.header(stamp, frame), twist=twist)


def test_they_are_sent_and_recorded_on_request_and_the_poor_ones_not_even_offered(live: LiveSimulator) -> None:
    usual, every = found(live), found(live, thruster_topics=True)
    assert {name for name, channel in usual.items() if channel.delivery.on_request} >= TWINS
    poor = every.keys() - usual.keys()
    names = live.vehicles[NAME].thrusters
    assert poor == {f"thrusters/{name}/{end}" for name in names for end in ("command", "force")}
    assert all(every[name].delivery.on_request for name in poor)


def test_sensors_scatter_about_the_truth_as_their_covariances_state(live: LiveSimulator) -> None:
    channels, origin_m = found(live, origin="published"), np.array([0.0, 0.0, 75.3])
    live.step(800)
    usbl, sim = channels["usbl/pose"].read(live.simulator), live.simulator
    mount = sim.scenario.vehicles[0].model.sensors["usbl"].position_m
    pose = sim.vehicles[NAME].pose
    true = pose.position_world_m + pose.world_from_body[:3, :3] @ mount + origin_m
    at, covariance = usbl.pose.pose.position, usbl.pose.covariance.reshape(6, 6)
    off = np.array([at.x, at.y, at.z]) - true
    assert usbl.header.frame_id == f"{NAME}/odom"
    assert 1e-3 < off @ np.linalg.inv(covariance[:3, :3]) @ off < 25.0
    assert np.all(np.diag(covariance)[3:] == 1e6)

    accel = channels["imu/accel"].read(sim).accel
    still = np.array([accel.accel.linear.x, accel.accel.linear.y, accel.accel.linear.z])
    assert np.abs(still).max() < 5.0 * np.sqrt(accel.covariance[0]), "at rest, gravity is left out"
    assert np.linalg.norm(still) < 0.5 and accel.covariance[35] == 1e6

    ours, theirs = channels["dvl"].read(sim), channels["dvl/data"].read(sim)
    assert theirs.velocity == ours.velocity and theirs.altitude == ours.altitude and theirs.velocity_valid
    assert [beam.distance for beam in theirs.beams] == ours.range.tolist() and theirs.header == ours.header
    assert theirs.time_of_validity * 1000 == stamp_ns(theirs)
    assert theirs.fom == pytest.approx(np.sqrt(ours.velocity_covar.reshape(3, 3).trace() / 3.0))
    back = from_bytes(to_bytes(theirs, 2), "dvl_msgs/msg/DVL")
    assert [beam.velocity for beam in back.beams] == pytest.approx(ours.beam_velocity.tolist())


def test_a_stamped_velocity_is_held_unless_it_is_stale_or_of_another_frame(live: LiveSimulator) -> None:
    channels = found(live)

    def hear(name: str, message: Any) -> None:
        publish(live, channels[name], message)

    live.step(400)
    hear("cmd_vel", stamped(0.3).twist)
    for _ in range(15):  # the other topic goes on where this one stops, and its publisher is heard
        hear("cmd_vel_stamped", stamped(0.3, live.time_ns, f"{NAME}/base_link"))
        live.step(40)
    assert live.vehicles[NAME].velocity.linear_body_m_s[0] == pytest.approx(0.3, abs=0.05)
    with pytest.raises(ValueError, match=r"stamp = 2\.\d+ s, \+\d\.\d+ s late: must be within 0\.5 s of /clock"):
        hear("cmd_vel_stamped", stamped(0.3, live.time_ns - 3_000_000_000))
    with pytest.raises(ValueError, match=f"frame_id = 'map': must be '{NAME}/base_link'"):
        hear("cmd_vel_stamped", stamped(0.3, live.time_ns, "map"))
    live.step(1000)
    assert abs(live.vehicles[NAME].velocity.linear_body_m_s[0]) < 0.05, "a silent publisher's command ends"


def test_each_thruster_is_commanded_alone_and_reports_its_force(live: LiveSimulator) -> None:
    channels, rov = found(live, thruster_topics=True), live.vehicles[NAME]

    def say(thruster: str, value: float) -> None:
        publish(live, channels[f"thrusters/{thruster}/command"], build.message("std_msgs/msg/Float64", data=value))

    say("front_left", 0.5)
    say("rear_left", -0.25)
    live.step(80)
    commands = {name: thruster.command for name, thruster in rov.thrusters.items() if thruster.command}
    assert commands == {"front_left": 0.5, "rear_left": -0.25}, "both at once"
    state = channels["thruster_states"].read(live.simulator)
    assert state.name == [f"{NAME}/{name}" for name in rov.thrusters]
    assert state.effort.tolist() == [thruster.thrust_n for thruster in rov.thrusters.values()]
    assert (
        channels["thrusters/front_left/force"].read(live.simulator).data == rov.thrusters["front_left"].thrust_n > 9.0
    )
    with pytest.raises(ValueError, match="thrusters/front_left/command"):
        say("front_left", 1.5)
    rov.all_stop()
    live.step(10)
    with pytest.raises(ValueError, match="all stop is set"):
        say("front_left", 0.5)
    assert not any(thruster.command for thruster in rov.thrusters.values())


def test_the_topics_of_one_and_of_all_thrusters_replace_each_other(live: LiveSimulator) -> None:
    """Otherwise the silence of one publisher stops the thrusters that another commands."""
    channels, rov = found(live, thruster_topics=True), live.vehicles[NAME]
    one = build.message("std_msgs/msg/Float64", data=0.5)
    every = build.message("std_msgs/msg/Float64MultiArray", data=np.full(len(rov.thrusters), 0.1))

    def commands() -> set[float]:
        live.step(10)
        return {thruster.command for thruster in rov.thrusters.values()}

    publish(live, channels["thrusters/front_left/command"], one)
    for _ in range(20):
        publish(live, channels["cmd_thrusters"], every)
        assert commands() == {0.1}
    publish(live, channels["thrusters/rear_left/command"], one)
    assert commands() == {0.0, 0.5} and rov.thrusters["front_left"].command == 0.0


def test_a_recording_of_one_thruster_is_compared_in_a_replay(tmp_path: Path) -> None:
    path, topic = tmp_path / "one.mcap", f"{NAME}/thrusters/front_left/force"
    with (
        Simulator(scenario(tmp_path), seed=3) as sim,
        Recorder(sim, path, topics=[topic], shared=Table(sim, thruster_topics=True)),
    ):
        sim.vehicles[NAME].set_thrusters({"front_left": 0.5})
        sim.advance(0.2)
    result = replay(path)
    assert result.difference is None and not result.not_compared and result.messages[topic] > 5
