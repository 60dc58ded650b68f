"""Published covariances match the sensors' noise: readings scatter about the truth accordingly."""

import numpy as np
import pytest

from channel_tools import table
from uwsim import Simulator
from uwsim.channels import diagnostics_channel
from uwsim.channels.families.covariance import UNKNOWN, of_velocity, variance
from uwsim.live import LiveSimulator
from uwsim.scenario.spec.sensor import SensorMount
from waiting import until

SEEDS = 60


def mount(**noise):
    return SensorMount(kind="depth", rate_hz=25.0, noise=noise)


def test_independent_errors_add_up():
    assert variance(mount(), "depth", 25.0, 0.0) == 0.0
    assert variance(mount(density=0.2), "depth", 25.0, 0.0) == pytest.approx(1.0)  # 0.2 x sqrt(25)
    parts = {"std": 0.3, "turn_on_std": 0.4, "bias_std": 1.2, "bias_time_s": 5.0, "walk": 0.1}
    assert variance(mount(**parts), "depth", 25.0, 100.0) == pytest.approx(0.09 + 0.16 + 1.44 + 1.0)
    by_channel = SensorMount(
        kind="imu", noise={"std": 1.0}, channels={"orientation": {"std": 2.0}, "linear_acceleration": {}}
    )
    assert [variance(by_channel, name, 1.0, 0.0) for name in ("orientation", "angular_velocity")] == [4.0, 1.0]


def test_a_velocity_from_beams_scatters_as_its_covariance_says():
    azimuth = np.radians([45, 135, 225, 315])
    beams = np.stack([0.5 * np.cos(azimuth), 0.5 * np.sin(azimuth), np.full(4, -np.sqrt(0.75))], axis=1)
    draws = np.random.default_rng(1).normal(0.0, 0.1, (20_000, 4)) @ np.linalg.pinv(beams).T
    np.testing.assert_allclose(of_velocity(beams, 0.01).reshape(3, 3), np.cov(draws.T), atol=6e-4)
    assert of_velocity(beams[:2], 0.01)[0] == UNKNOWN


def test_readings_of_many_seeds_scatter_as_the_messages_say():
    sim, draws = Simulator("pool"), []
    found = table(sim)
    for seed in range(SEEDS):
        sim.reset(seed=seed)
        sim.rov.place((0.0, 0.0, -2.0))
        sim.advance(0.25)
        pressure, temperature, imu = (found[name].read(sim) for name in ("pressure", "temperature", "imu"))
        true = {name: sensor.read(noise=False) for name, sensor in sim.rov.sensors.items()}
        draws.append(
            [
                pressure.fluid_pressure - true["pressure"],
                temperature.temperature - true["temperature"],
                imu.angular_velocity.z - true["imu"].angular_velocity_rad_s[2],
                imu.linear_acceleration.y - true["imu"].linear_acceleration_m_s2[1],
            ]
        )
    said = [pressure.variance, temperature.variance, imu.angular_velocity_covariance[8]]
    ratios = np.var(draws, axis=0) / [*said, imu.linear_acceleration_covariance[4]]
    assert (ratios > 0.45).all() and (ratios < 1.8).all()  # of 60 draws, 99.9 % of the ratios lie in 0.5..1.7
    before = pressure.variance
    sim.parameters["rov.sensors.pressure.noise.std"] = 500.0
    sim.advance(0.1)
    assert found["pressure"].read(sim).variance == pytest.approx(before - 50.0**2 + 500.0**2), "of the new value"


def test_diagnostics_tell_the_pace():
    with LiveSimulator("pool", speed=1.0, paused=True) as live:
        channel = diagnostics_channel(live)
        status, *others = live.read(channel.read).result().status
        values = {pair.key: pair.value for pair in status.values}
        assert (status.level, status.message, values["speed"], values["paused"]) == (0, "paused", "1.0", "True")
        assert [(one.name, one.level) for one in others[:2]] == [("uwsim: delivery", 0), ("uwsim: rov", 0)]
        live.speed = 1e6  # faster than any machine can run
        live.resume()
        until(lambda: live.slipped_s > 0.0)
        status, *_ = live.read(channel.read).result().status
        assert (status.level, status.message) == (1, "the pace is not held")
