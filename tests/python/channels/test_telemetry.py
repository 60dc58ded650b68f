"""/telemetry: the panel's values in one message."""

import re
import struct
from pathlib import Path

import numpy as np

import uwsim
from channel_tools import table
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.ros.cdr import encode
from uwsim.instruments.gauges import GAUGES

USERS = {  # of a gauge's value, each for a reason of its own
    "distance_to_seabed": {
        "telemetry.py",  # the warning
        "inspection.py",  # the place of a note
        "telemetry.js",  # contact ahead
        "readout.py",  # the pilot's line in a terminal
    },
    "distance_to_port": {"telemetry.js"},  # the nearest obstacle
}


def test_a_gauge_is_named_in_the_table_and_where_its_value_is_used() -> None:
    sources = [path for kind in ("py", "js") for path in Path(uwsim.__file__).parent.rglob(f"*.{kind}")]
    texts = [(path.name, path.read_text()) for path in sources if "vendor" not in path.parts]
    assert set(USERS) <= {gauge.name for gauge in GAUGES}
    for name, users in USERS.items():
        assert {file for file, text in texts if re.search(rf"\b{name}\b", text)} == users | {"gauges.py"}, name


def test_accelerations_are_the_rates_of_the_velocities_along_the_body_axes() -> None:
    sim = Simulator("pool")
    sim.rov.undock()
    sim.rov.set_effort(surge=0.6, sway=-0.3, roll=0.4, yaw=0.5)
    sim.advance(1.5)

    def in_world() -> np.ndarray:
        turn, velocity = sim.rov.pose.world_from_body[:3, :3], sim.rov.velocity
        return np.array([turn @ velocity.linear_body_m_s, velocity.angular_body_rad_s])

    before = in_world()
    sim.step()
    message, measured = table(sim)["telemetry"].read(sim), sim.rov.sensors["acceleration"].read()
    assert (message.linear_acceleration == measured.linear_acceleration_m_s2.astype(np.float32)).all()
    linear, angular = (in_world() - before) / sim.step_s
    linear = sim.rov.pose.world_from_body[:3, :3].T @ linear
    assert np.linalg.norm(linear) > 0.05
    np.testing.assert_allclose(message.linear_acceleration, linear, atol=0.05)  # 5 standard deviations
    np.testing.assert_allclose(message.angular_acceleration, angular, atol=0.025)


def test_gauges_show_what_the_instruments_measure_and_how_old_it_is() -> None:
    """A stuck depth gauge is stuck on the panel; one that is off shows nothing; the truth moves on."""
    sim = Simulator("pool")
    telemetry = table(sim)["telemetry"]
    sim.rov.undock()
    sim.advance(0.5)
    before = telemetry.read(sim)
    sensors = sim.rov.sensors
    for field, name in (("depth", "depth"), ("distance_to_seabed", "altitude"), ("temperature", "temperature")):
        assert getattr(before, field) == np.float32(sensors[name].read()), field
    sim.faults.inject("sensor", sensor="depth", mode="stuck")
    sim.faults.inject("sensor", sensor="altitude", mode="off")
    depth_m = sim.rov.telemetry().depth_m
    sim.rov.set_effort(heave=-0.8)
    sim.advance(2.0)
    after = telemetry.read(sim)
    assert sim.rov.telemetry().depth_m > depth_m + 0.2
    assert after.depth == np.float32(sensors["depth"].read()) and abs(after.depth - depth_m) < 0.05
    assert np.isnan(after.distance_to_seabed)
    ages_s = dict(zip(after.gauges, after.gauge_ages, strict=True))
    assert ages_s["distance_to_seabed"] == np.inf and 0.0 <= ages_s["temperature"] <= 0.2


def test_where_the_truth_is_hidden_no_topic_has_it() -> None:
    """No message contains a coordinate of the true position, to the last bit, in any of its numbers."""
    sim = Simulator("pool")
    sim.rov.undock()
    sim.rov.estimate  # noqa: B018  # starts it
    sim.rov.set_effort(surge=0.8, yaw=0.3)
    sim.advance(3.0)
    true_m = sim.rov.pose.position_world_m

    def revealing(truth: bool) -> set[str]:
        said = [channel for channel in Table(sim, truth=truth).channels if channel.direction == "out"]
        found = {channel.name: bytes(encode(channel.read(sim))) for channel in said if not channel.delivery.late}
        return {
            name
            for name, data in found.items()
            if any(struct.pack(code, value) in data for value in true_m for code in ("<d", "<f"))
        }

    assert {"tf", "odom", "ground_truth/odom", "propPos", "telemetry"} <= revealing(truth=True)
    assert revealing(truth=False) == set()
    assert {"key", "cmd_vel", "tf", "odom"} <= {channel.name for channel in Table(sim, truth=False).channels}


def test_the_published_vehicle_s_gauges_are_exact_through_a_release() -> None:
    """Docked, falling, splashing and at rest: speed, position and distance are those of its exact sensors."""
    sim = Simulator("paper", seed=3)
    telemetry = table(sim)["telemetry"]
    station_m, fastest_m_s = np.asarray(sim.scenario.station.position_m), 0.0
    for tick in range(60):
        if tick == 10:
            sim.rov.release()
        sim.advance(0.1)
        message, velocity, position_m = telemetry.read(sim), sim.rov.velocity, sim.rov.pose.position_world_m
        speed_m_s = float(np.linalg.norm(velocity.linear_body_m_s))
        fastest_m_s = max(fastest_m_s, speed_m_s)
        assert abs(message.speed - speed_m_s) < 1e-5, sim.time_s
        assert abs(message.angular_speed - np.linalg.norm(velocity.angular_body_rad_s)) < 1e-5
        assert abs(message.distance_to_station - np.linalg.norm(position_m - station_m)) < 1e-4
        np.testing.assert_allclose(message.position, position_m, atol=1e-9)
        assert (message.position_std == 0.0).all()
    assert fastest_m_s > 5.0 and speed_m_s < 0.1
