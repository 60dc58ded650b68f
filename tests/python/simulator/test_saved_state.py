"""A simulator restored from a saved state behaves like the original."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.assets import assets_folder


def flown(scenario: str = "pool") -> Simulator:
    sim = Simulator(scenario, seed=5)
    sim.rov.release()
    sim.rov.set_effort(surge=0.6, heave=-0.3, yaw=-0.2)
    sim.rov.sonar.aim(-0.3)
    sim.advance(3.0)
    return sim


def observed(sim: Simulator, seconds: float = 1.0) -> Iterator[np.ndarray]:
    """Yield everything observable of every vehicle, every 0.1 s."""
    for _ in range(round(seconds / 0.1)):
        sim.advance(0.1)
        for vehicle in sim.vehicles.values():
            yield vehicle.pose.world_from_body
            yield np.concatenate([vehicle.velocity.linear_body_m_s, vehicle.velocity.angular_body_rad_s])
            for sensor in vehicle.sensors.values():
                sample = sensor.sample()
                values = [sample.value] if isinstance(sample.value, float) else vars(sample.value).values()
                yield np.concatenate([np.ravel(value) for value in values])
                yield np.array([sample.stamp_ns, sample.valid])
            if vehicle.sonars:
                yield vehicle.sonar.ping().ranges_m
            telemetry = vehicle.telemetry()
            yield np.array([telemetry.battery_percent, telemetry.mission_time_s, vehicle.collisions])


def test_a_fresh_simulator_continues_to_the_last_bit() -> None:
    sim = flown("pair")
    state = sim.save_state()
    fresh = Simulator("pair", seed=5)
    fresh.restore_state(state)
    assert fresh.time_ns == sim.time_ns
    assert fresh.rov.released
    np.testing.assert_array_equal(fresh.rov.effort, sim.rov.effort)
    for expected, got in zip(observed(sim), observed(fresh), strict=True):
        np.testing.assert_array_equal(got, expected)


def test_a_state_of_another_scenario_or_seed_is_refused() -> None:
    state = flown().save_state()
    for other in (Simulator("pool", seed=6), Simulator("pool", seed=5, mission_time_s=9.0), Simulator("pair", seed=5)):
        with pytest.raises(ValueError, match="another scenario, seed or vehicle"):
            other.restore_state(state)


def test_the_fingerprint_depends_on_the_content_of_files_that_the_scenario_names(tmp_path: Path) -> None:
    heights = assets_folder() / "terrains" / "jacksboro_srtm.asc"
    text = (assets_folder() / "scenarios" / "valley.yaml").read_text().replace("terrains/jacksboro_srtm.asc", "bed.asc")
    assert "bed.asc" in text
    (tmp_path / "valley.yaml").write_text(text)
    (tmp_path / "bed.asc").write_text(heights.read_text())
    before = scenario_fingerprint(load(tmp_path / "valley.yaml"))
    assert scenario_fingerprint(load(tmp_path / "valley.yaml")) == before
    (tmp_path / "bed.asc").write_text(heights.read_text().replace("2", "3", 1))
    assert scenario_fingerprint(load(tmp_path / "valley.yaml")) != before


SIM = flown()
STATE = SIM.save_state()


@given(st.integers(0, len(STATE) - 1), st.integers(0, 7))
def test_a_flipped_bit_is_refused_and_changes_nothing(byte: int, bit: int) -> None:
    damaged = bytearray(STATE)
    damaged[byte] ^= 1 << bit
    with pytest.raises(ValueError, match=r"state.* = .*: "):
        SIM.restore_state(bytes(damaged))
    assert SIM.save_state() == STATE


@given(st.integers(0, len(STATE) - 1))
def test_a_truncated_state_is_refused(size: int) -> None:
    with pytest.raises(ValueError, match=r"state.* = .*: "):
        SIM.restore_state(STATE[:size])


@pytest.mark.parametrize("state", [None, "text", b"", b"uwsim state\n", bytearray(STATE)])
def test_anything_but_a_state_is_refused(state: object) -> None:
    with pytest.raises(ValueError, match="state"):
        SIM.restore_state(state)
