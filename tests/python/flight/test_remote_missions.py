"""The same mission in process and over a rosbridge; a remote vehicle has the same readings as the simulated one."""

import json
from pathlib import Path

import numpy as np
import pytest

from command_line import error_line
from command_line import uwsim as run_uwsim
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.remote import LockstepClock, RemoteClock, RemoteConnection, RemoteVehicle
from uwsim.bridges.remote.flight import fly_remote
from uwsim.flight.fly import fly
from uwsim.live import LiveSimulator
from uwsim.missions import aim_to, dive_to, goto, run, wait


def there(vehicle):
    """Fly to a point using pose, altitude, sonar, panel and lamps."""
    vehicle.undock()
    vehicle.lamps["front"].on = True
    vehicle.sonar.aim(-0.6)
    yield from goto(vehicle, (-1.0, 3.0), altitude_m=2.0, speed_m_s=0.5)
    yield from dive_to(vehicle, 2.0)
    ping = vehicle.sonar.ping()
    vehicle.log("there", depth_m=vehicle.telemetry().depth_m, free=vehicle.released)
    return vehicle.pose.position_world_m, float(np.nanmin(ping.ranges_m)), vehicle.sensors["altitude"].read()


def test_a_mission_flies_remotely_as_in_process(tmp_path: Path) -> None:
    here = fly(there, "pool", map=True, voxel_m=0.5)
    with LiveSimulator("pool", paused=True) as live, RosbridgeServer(live) as server:
        far = fly_remote(there, server.url, tmp_path, lockstep=True, map=True, voxel_m=0.5, report="json", truth="pool")
        assert live.paused, "as it was before"
        assert live.rov.lamps["front"].on
        assert not live.simulator.rov.effort.any(), "efforts are zero at the end"
    for mine, other in zip(here.result, far.result, strict=True):
        assert other == pytest.approx(mine, abs=0.3)
    assert far.simulated_s == pytest.approx(here.simulated_s, abs=2.0)
    assert far.ended_because == here.ended_because
    apart_m = [
        np.linalg.norm(here.samples["rov"].path_world_m - p, axis=1).min() for p in far.samples["rov"].path_world_m
    ]
    assert np.max(apart_m) < 0.5
    assert here.occupancy is not None and far.occupancy is not None
    # Compare columns, because the bed lies on the boundary between two voxel layers.
    columns = [len(np.unique(flown.occupancy.occupied_voxels()[:, :2], axis=0)) for flown in (far, here)]
    assert columns[0] > 0.5 * columns[1]
    off_m = Simulator("pool").scene.distance_m(far.occupancy.occupied_voxels())
    assert off_m.max() < 0.5 * np.sqrt(3.0) / 2.0 + 0.05, "the true surface runs through its voxels"
    assert json.loads((tmp_path / "summary.json").read_text())["pings"] > 50
    assert (tmp_path / "map.bt").exists()
    assert far.score is not None and far.score.distance_mean_m < 0.3, "the truth was named"


def aimed(vehicle):
    """Aim the sonar and a camera, and look."""
    yield from aim_to(vehicle.sonar, -0.7)
    yield from aim_to(vehicle.cameras["front"], pan_rad=0.3)
    return vehicle.imaging_sonars["forward_looking"].ping()


def test_a_remote_vehicle_reads_and_aims_as_the_simulated_one_does() -> None:
    with LiveSimulator(Simulator("pool", seed=4), paused=True) as live, RosbridgeServer(live) as server:
        sim = live.simulator
        with RemoteConnection(server.url) as connection:
            far, clock = RemoteVehicle(connection), LockstepClock(connection, "odom")
            far.release()
            far.set_effort(surge=0.3, sway=-0.2, heave=0.1, yaw=0.5)
            clock.wait(2.0)
            assert clock.time_s == pytest.approx(sim.time_s)
            assert sim.rov.effort == pytest.approx([0.3, -0.2, 0.1, 0.0, 0.0, 0.5])
            assert far.pose.world_from_body == pytest.approx(sim.rov.pose.world_from_body, abs=1e-6)
            assert far.velocity.linear_body_m_s == pytest.approx(sim.rov.velocity.linear_body_m_s, abs=1e-6)
            assert far.velocity.angular_body_rad_s == pytest.approx(sim.rov.velocity.angular_body_rad_s, abs=1e-6)
            far.sonar.ping()
            clock.wait(1.0)
            ping = far.sonar.ping()
            assert ping.valid.any()
            points = ping.points_sonar_m[ping.valid] @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
            assert sim.scene.distance_m(np.asarray(points, np.float64)).max() < 0.02, "echoes lie on surfaces"
            for name in ("pressure", "temperature", "depth", "altitude", "proximity_port"):
                far.sensors[name].read()
            eye = far.cameras["down"]
            clock.wait(1.0)
            assert far.sensors["pressure"].read() == pytest.approx(sim.rov.sensors["pressure"].read(), rel=5e-3)
            assert far.sensors["altitude"].read() == pytest.approx(sim.rov.sensors["altitude"].read(), abs=0.1)
            assert far.telemetry().depth_m == pytest.approx(sim.rov.sensors["depth"].read(), abs=0.05)
            picture, camera = eye.capture(), sim.rov.cameras["down"]
            scale = picture.info.width / camera.info.width
            assert picture.rgb.shape == (picture.info.height, picture.info.width, 3)
            assert picture.info.k[:2, :2] == pytest.approx(scale * camera.info.k[:2, :2], rel=0.02)
            assert picture.world_from_camera == pytest.approx(camera.world_from_camera, abs=0.15), "a moment ago"
            far.set_effort()
            run(aimed, far, clock)
            assert sim.rov.sonar.elevation_rad == pytest.approx(-0.7)
            assert sim.rov.cameras["front"].aim_rad[0] == pytest.approx(0.3)
            clock.wait(4.0)  # until it is nearly at rest
            look, truth = far.imaging_sonars["forward_looking"].ping(), sim.rov.imaging_sonars["forward_looking"].look()
            assert look.level_db.shape == truth.level_db.shape
            assert look.bearings_rad == pytest.approx(truth.bearings_rad, abs=1e-6)
            assert look.world_from_sonar == pytest.approx(truth.world_from_sonar, abs=0.05), "a moment ago"
            with pytest.raises(ValueError, match="no motor: there is no topic 'camera/down/cmd_pan'"):
                far.cameras["down"].aim(pan_rad=0.1)
            with pytest.raises(ValueError, match=r"dock: it is .* away"):
                far.dock()
            with pytest.raises(ValueError, match="did you mean 'altitude'"):
                far.sensors["altitud"]


def test_a_free_running_clock_keeps_a_missions_period() -> None:
    def mission(vehicle):
        vehicle.undock()
        for _ in range(20):
            yield wait(0.1)
        return vehicle.time_s

    with LiveSimulator("pool", speed=4.0) as live, RosbridgeServer(live) as server:
        connection = RemoteConnection(server.url)
        vehicle, clock = RemoteVehicle(connection), RemoteClock(connection)
        begun_s = clock.time_s
        assert run(mission, vehicle, clock) - begun_s >= 2.0 - 1e-6
        connection.close()


def test_a_server_that_goes_away_ends_the_mission_with_its_results(tmp_path: Path) -> None:
    with LiveSimulator("pool", speed=1.0) as live:
        server = RosbridgeServer(live).start()

        def mission(vehicle):
            yield wait(0.3)
            server.stop()
            while True:
                yield wait(0.1)

        with pytest.raises(OSError, match="the connection to the vehicle is lost"):
            fly_remote(mission, server.url, tmp_path, report="json")
    assert "connection to the vehicle is lost" in json.loads((tmp_path / "summary.json").read_text())["ended_because"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--connect http://localhost:1", "must begin with ws://"),
        ("--connect ws://127.0.0.1:9", "no rosbridge answers"),
        ("--connect ws://127.0.0.1:9 --estimate filter", "--estimate: cannot be given with --connect"),
        ("--voxel 0.5", "--voxel: needs --map"),
        ("--record-topic odom", "--record-topic: needs --record"),
        ("--lockstep", "--lockstep: needs --connect"),
        ("--connect ws://127.0.0.1:9 --seed 3", "--seed: cannot be given with --connect"),
        ("--connect ws://127.0.0.1:9 --record a.mcap", "--record: cannot be given with --connect"),
        ("--connect ws://127.0.0.1:9 --autosave 5", "--autosave: cannot be given with --connect"),
        ("--connect ws://127.0.0.1:9 --report fulll", "report = 'fulll': must be one of full, json, none"),
    ],
)
def test_wrong_ways_to_connect_are_one_line(options: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "m.py"
    file.write_text("from uwsim.missions import wait\ndef mission(vehicle):\n    yield wait(1.0)\n")
    result = run_uwsim("run", file, "--out", tmp_path / "out", *options.split())
    assert words in error_line(result)
    assert not (tmp_path / "out").exists()


def test_a_mission_of_vehicles_gets_all_of_a_server_told_apart() -> None:
    def mission(vehicles):
        yield wait(0.2)
        return sorted(vehicles)

    with LiveSimulator("pair", paused=True) as live, RosbridgeServer(live) as server:
        with RemoteConnection(server.url) as connection:
            scout = RemoteVehicle(connection, "scout")
            assert scout.pose.position_world_m == pytest.approx(live.simulator.vehicles["scout"].pose.position_world_m)
            with pytest.raises(ValueError, match="must be one of rov, scout"):
                RemoteVehicle(connection, "diver")
        flown = fly_remote(mission, server.url, lockstep=True)
    assert flown.result == ["rov", "scout"] == sorted(flown.samples)
