"""Every channel publishes the simulator's values in the frames, signs and units of its message type."""

from pathlib import Path

import numpy as np
import pytest

from channel_tools import chain, require_writable, stamp_ns, table
from uwsim import Simulator
from uwsim.channels import Table, channels
from uwsim.mapping import OccupancyMap, ranging


@pytest.fixture(scope="module")
def sim() -> Simulator:
    sim = Simulator("pool", seed=3)
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, yaw=0.2, heave=-0.2)
    sim.rov.sonar.aim(-0.4)
    sim.advance(3.0)
    return sim


def test_several_vehicles_speak_under_their_names() -> None:
    sim = Simulator("pair")
    sim.advance(2.0)
    found = table(sim)
    assert {"rov/scan", "scout/scan", "rov/key", "scout/cmd_vel", "tf", "clock"} <= set(found)
    assert not {"scan", "key", "cmd_vel"} & set(found)
    assert found["scout/scan"].frame_id == "scout/base_scan"
    read = [require_writable(channel, sim) for channel in found.values()]
    assert sum(message is not None for message in read) > 0.5 * len(read)


def test_the_wires_are_chosen(sim: Simulator) -> None:
    published, standard = set(table(sim, wire="published")), set(table(sim, wire="standard"))
    words = "propPos scanPos depthArray modelTrigger stateData proximitySensor hFOV key"
    assert {*words.split(), "image/compressed", "images/compressed"} <= published
    assert not published & standard and published | standard == set(table(sim))
    with pytest.raises(ValueError, match="wire = 'both ends': must be"):
        channels(sim, wire="both ends")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"origin = 'mars': must be .*published"):
        channels(sim, origin="mars")


@pytest.mark.parametrize("origin", ["world", "published", (10.0, -20.0, 3.0)])
def test_transforms_lead_from_the_world_to_every_instrument(sim: Simulator, origin: str | tuple[float, ...]) -> None:
    found = table(sim, origin=origin)
    np.testing.assert_allclose(chain(sim, found, "base_link"), sim.rov.pose.world_from_body, atol=1e-12)
    np.testing.assert_allclose(chain(sim, found, "base_scan"), sim.rov.sonar.ping().world_from_sonar, atol=1e-9)
    for name, camera in (*sim.rov.cameras.items(), *sim.cameras.items()):
        expected = camera.capture(geometry_only=True).world_from_optical
        np.testing.assert_allclose(chain(sim, found, f"{name}_optical"), expected, atol=1e-9)


def test_odometry_is_the_pose_in_odom_and_the_velocity_of_the_body(sim: Simulator) -> None:
    message = table(sim, origin=(10.0, -20.0, 3.0))["odom"].read(sim)
    position = message.pose.pose.position
    expected = sim.rov.pose.position_world_m + np.array([10.0, -20.0, 3.0])
    np.testing.assert_allclose([position.x, position.y, position.z], expected)
    assert message.twist.twist.linear.x == sim.rov.velocity.linear_body_m_s[0]
    assert message.twist.twist.angular.z == sim.rov.velocity.angular_body_rad_s[2]
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_footprint")


def test_the_scan_s_echoes_lie_where_the_ping_met_the_world(sim: Simulator) -> None:
    found = table(sim)
    scan, cloud, points = (found[name].read(sim) for name in ("scan", "laserPointCloud", "points"))
    ping = sim.rov.sonar.ping()
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    hit = np.isfinite(scan.ranges)
    expected = np.column_stack([scan.ranges * np.cos(angles), scan.ranges * np.sin(angles), 0 * angles])[hit]
    np.testing.assert_allclose(ping.points_sonar_m[hit], expected, atol=1e-3)
    got = np.frombuffer(cloud.data.tobytes(), np.float32).reshape(-1, 3)
    np.testing.assert_allclose(got, expected, atol=1e-3)
    assert [field.name for field in points.fields] == ["x", "y", "z", "intensity"]
    columns = np.frombuffer(points.data.tobytes(), np.float32).reshape(-1, 4)
    np.testing.assert_array_equal(columns[:, 3], ping.intensity_db[ping.valid])


def test_a_ping_is_repeated_until_sound_has_had_time_for_another() -> None:
    sim = Simulator("pool")
    found, stamps = table(sim), []
    for _ in range(50):
        stamps.append(stamp_ns(found["scan"].read(sim)))
        sim.advance(0.02)
    intervals, least_s = np.diff(np.unique(stamps)) * 1e-9, 1.0 / sim.rov.sonar.ping_rate_max_hz
    assert least_s <= intervals.min() <= intervals.max() <= least_s + 0.02
    assert found["depthArray"].rate_hz == pytest.approx(1.0 / intervals.min())


def test_the_map_is_that_of_the_chain(tmp_path: Path) -> None:
    sim = Simulator("pool")
    sim.rov.release()
    sim.rov.sonar.aim(-1.0)  # tilt down, sweeping over the bed
    found, said = table(sim, origin="published"), []
    channel = found["octomap_binary"]
    expected = OccupancyMap(sim.scenario.survey.voxel_m if sim.scenario.survey else 0.2, on_outside="count")
    for _ in range(40):
        said.append(channel.read(sim))
        ranges = ranging.decode_depth_string(found["depthArray"].read(sim).data, 2)
        odom_from_scan = chain(sim, found, "base_scan", root="odom")
        points = ranging.to_point_cloud(ranging.to_laser_scan(ranges, 2))
        expected.insert_scan(ranging.transform_points(points, odom_from_scan), odom_from_scan[:3, 3], 55.0)
        sim.advance(1.0 / channel.rate_hz)
    message = [each for each in said if each is not None][-1]
    nodes = 1 + np.unpackbits(message.data.view(np.uint8)).reshape(-1, 2).any(axis=1).sum()  # two bits per child
    header = f"# Octomap OcTree binary file\nid OcTree\nsize {nodes}\nres {message.resolution}\ndata\n"
    (tmp_path / "said.bt").write_bytes(header.encode() + message.data.tobytes())
    got, whole = OccupancyMap.read(tmp_path / "said.bt").occupied_voxels(), expected.occupied_voxels()
    assert (message.binary, message.id) == (True, "OcTree")
    assert got[:, 2].max() > 60.0  # the surface of the published world is at 75.3 m
    shared = {tuple(voxel) for voxel in got.round(3)} & {tuple(voxel) for voxel in whole.round(3)}
    assert len(shared) > 0.9 * len(got) > 50


def test_the_dvl_speaks_in_its_frame_which_points_down() -> None:
    sim = Simulator("pool")
    sim.rov.place((0.0, 0.0, -2.0), velocity_body=[0.6, 0.3, 0.1, 0.0, 0.0, 0.0])
    found = table(sim)
    while (message := found["dvl"].read(sim)) is None:
        sim.step()
    body_from_dvl = chain(sim, found, "dvl_link", root="base_link")[:3, :3]
    np.testing.assert_allclose(body_from_dvl[:, 2], [0, 0, -1], atol=1e-12)
    sent_m_s = np.array([message.velocity.x, message.velocity.y, message.velocity.z])
    np.testing.assert_allclose(body_from_dvl @ sent_m_s, [0.6, 0.3, 0.1], atol=0.1)
    for beam, along_m_s in zip(message.beam_unit_vec, message.beam_velocity, strict=True):
        assert along_m_s == pytest.approx(np.dot([beam.x, beam.y, beam.z], sent_m_s), abs=0.05)
        assert beam.z == pytest.approx(np.cos(np.radians(30.0)))
    assert message.num_good_beams == 4


def test_units_are_those_of_the_messages(sim: Simulator) -> None:
    found = table(sim)
    assert found["pressure"].read(sim).fluid_pressure == sim.rov.sensors["pressure"].read()  # Pa
    assert found["temperature"].read(sim).temperature == sim.rov.sensors["temperature"].read()  # deg C
    assert found["battery_state"].read(sim).percentage == pytest.approx(0.01 * sim.rov.telemetry().battery_percent)
    assert found["altitude"].read(sim).range == sim.rov.sensors["altitude"].read()
    assert found["altitude"].read(sim).max_range == 100.0
    assert found["imu"].read(sim).linear_acceleration.z == pytest.approx(9.81, abs=0.5)  # REP 145: +g when level (z up)
    joints = found["joint_states"].read(sim)
    angles = dict(zip(joints.name, joints.position, strict=True))
    assert angles == {"sonar_tilt": -sim.rov.sonar.elevation_rad, "front_pan": 0.0, "front_tilt": 0.0}
    clock = found["clock"].read(sim).clock
    assert clock.sec * 1_000_000_000 + clock.nanosec == sim.time_ns
    above = Simulator("pool")
    above.rov.place([0.0, 0.0, 150.0])  # beyond the altimeter's range
    above.advance(0.2)
    assert table(above)["altitude"].read(above).range == np.inf


def voxels_after(known: set, message) -> set:
    """Return the occupied voxels that a client knows after applying a MapChanges message."""
    known, at = set() if message.snapshot else set(known), 0
    for block, count in zip(message.blocks.reshape(-1, 3).tolist(), message.counts.tolist(), strict=True):
        for cell in message.cells[at : at + count].tolist():
            voxel = tuple(16 * block[axis] + (cell >> 4 * axis & 15) for axis in range(3))
            (known.add if cell >> 15 else known.remove)(voxel)
        at += count
    return known


def test_map_changes_build_the_occupied_voxels_of_the_map_whenever_one_begins_to_listen():
    sim = Simulator("lake")
    whole, known, cursors = Table(sim), {"early": set(), "late": set()}, {"early": None}
    channel = next(channel for channel in whole.channels if channel.name == "map_changes")
    ping_map = whole.maps["rov"]
    for k in range(7):
        sim.rov.place((-30.0 + 0.5 * k, -40.0, -20.0))
        channel.read(sim)
        centres, edge_m = ping_map.points()
        occupied = set(map(tuple, np.floor(centres / edge_m).astype(int).tolist()))
        if k == 4:
            cursors["late"] = None
        for name, cursor in cursors.items():
            message, cursors[name] = channel.delivery.catch_up(cursor)
            assert message.snapshot == (cursor is None)
            known[name] = voxels_after(known[name], message)
            assert known[name] == occupied and len(occupied) > 100
        sim.advance(0.25)
    sim.reset()
    channel.read(sim)
    ping_map.points()
    assert channel.delivery.catch_up(cursors["late"])[0].snapshot  # a different map, hence a full snapshot


def test_telemetry_tells_the_truth_only_where_it_may():
    sim = Simulator("lake")
    sim.rov.place((-30.0, -40.0, -20.0))
    sim.advance(3.0)
    told = table(sim)["telemetry"].read(sim)
    assert told.is_truth and np.allclose(told.true_position, sim.rov.pose.position_world_m)
    assert (np.abs(told.position - told.true_position) < 5 * told.position_std).all()
    assert told.link_delay == pytest.approx(told.distance_to_station / 1475.0, rel=0.02)
    assert (told.depth, told.released) == (pytest.approx(20.0, abs=0.15), True)
    hidden = table(sim, truth=False)["telemetry"].read(sim)
    assert not hidden.is_truth and np.isnan(hidden.true_position).all()
    assert (hidden.position == told.position).all() and (hidden.orientation == told.orientation).all()
