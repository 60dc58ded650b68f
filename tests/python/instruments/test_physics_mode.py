"""Physics mode in the simulator: repeatable, with delays and motion; soundings with correct and wrong profiles."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from uwsim import Simulator, _core
from uwsim.instruments.sonars.soundings import SoundSpeedProfile, sound_points, sound_speed_profile
from uwsim.scenario import load
from uwsim.scenario.dump import plain

HEARD = ("ranges_m", "labels", "world_from_body")
ARRAYS = ("ranges_m", "points_sonar_m", "incidence_rad", "intensity_db", "snr_db", "travel_time_s", "labels")
BASIN = """
name: basin
water:
  profile: {kind: table, levels: [
    {depth_m: 0, temperature_deg_c: 20, salinity_psu: 0}, {depth_m: 40, temperature_deg_c: 5, salinity_psu: 0}]}
terrain: {source: noise, size_m: [400, 400], spacing_m: 10, bed_depth_m: 40}
station: {position_m: [0, 0, 0]}
vehicles:
  - {name: rov, model: rov, start: {position_m: [0, 0, -1]},
     sonar: {model: em2040-04, frequency_hz: 400000, mode: physics, bending: true, tilt_deg: 90}}
"""


def pool(seed: int = 0) -> Simulator:
    sim = Simulator("pool", seed=seed)
    sim.parameters["rov.sonar.mode"] = "physics"
    return sim


def same(a: _core.PhysicsPing, b: _core.PhysicsPing) -> bool:
    return all(np.array_equal(getattr(a, name), getattr(b, name), equal_nan=name != "labels") for name in ARRAYS)


def test_a_ping_is_a_function_of_scenario_seed_and_time() -> None:
    one, two, other = pool(seed=1), pool(seed=1), pool(seed=2)
    first = one.rov.sonar.ping()
    assert same(first, two.rov.sonar.ping()) and not same(first, other.rov.sonar.ping())
    assert same(one._core.acoustic_ping(0, 0, 1), one._core.acoustic_ping(0, 0, 2))
    one.step()
    assert not same(first, one.rov.sonar.ping())
    assert first.time_ns == 0 and one.rov.sonar.ping().time_ns == 5_000_000


def test_sonars_that_ping_together_hear_what_each_hears_alone() -> None:
    rov = plain(load("pool"))["vehicles"][0] | {"start": {"position_m": [-8, 0, -2]}}
    more = [rov | {"name": f"rov{k}", "start": {"position_m": [2.0 * k, 1, -1]}} for k in range(3)]
    more[1] = more[1] | {"sonar": rov["sonar"] | {"mode": "physics"}}
    together, alone = (Simulator(plain(load("pool")) | {"vehicles": [rov, *more]}, threads=n) for n in (2, 1))
    for _ in range(2):
        sonars = [vehicle.sonar for vehicle in together.vehicles.values()]
        pings = together.ping(*sonars, sonars[0])
        assert [type(ping) for ping in pings] == [_core.Ping, _core.Ping, _core.PhysicsPing, _core.Ping, _core.Ping]
        assert all(sonar.ping() is ping for sonar, ping in zip(sonars, pings, strict=False)) and pings[4] is pings[0]
        assert sum(np.isfinite(ping.ranges_m).sum() for ping in pings) > 1000
        for ping, vehicle in zip(pings, alone.vehicles.values(), strict=False):
            other = vehicle.sonar.ping()
            assert all(np.array_equal(getattr(ping, name), getattr(other, name)) for name in HEARD)
            assert ping.time_ns == other.time_ns
        for sim in (together, alone):
            sim.step(20)
    assert together.ping() == []
    with pytest.raises(ValueError, match="another simulator"):
        together.ping(alone.rov.sonar)


def test_a_ping_agrees_with_geometry_within_its_errors_and_its_arrays_with_each_other() -> None:
    sim = pool()
    exact, ping = Simulator("pool").rov.sonar.ping(), sim.rov.sonar.ping()
    assert isinstance(ping, _core.PhysicsPing)
    off_m = np.abs(ping.ranges_m - exact.ranges_m)[ping.valid & exact.valid]
    assert ping.valid.mean() > 0.98
    assert 0.0 < np.median(off_m) < 0.02
    found = ping.valid
    assert np.array_equal(found, np.isfinite(ping.ranges_m)) and np.array_equal(found, ping.detections > 0)
    assert np.array_equal(found, np.isfinite(ping.points_sonar_m).all(axis=1))
    assert np.array_equal(found, np.isfinite(ping.travel_time_s))
    np.testing.assert_allclose(np.linalg.norm(ping.points_sonar_m[found], axis=1), ping.ranges_m[found], rtol=1e-6)
    speed_m_s = sound_speed_profile(sim.world.water).at(-float(ping.world_from_sonar[2, 3]))
    np.testing.assert_allclose(ping.ranges_m[found], 0.5 * speed_m_s * ping.travel_time_s[found], rtol=1e-6)
    assert not ping.ranges_m.flags.writeable


def test_soundings_with_the_wrong_profile_bend_up_and_with_the_true_one_do_not() -> None:
    sim = Simulator(yaml.safe_load(BASIN))
    ping = sim.rov.sonar.ping()
    assert isinstance(ping, _core.PhysicsPing)
    profile = sound_speed_profile(sim.world.water)
    assert profile.at(0) - profile.at(40) > 50  # sound is slower at depth, so rays bend down
    depth = -float(ping.world_from_sonar[2, 3])
    right_m = sound_points(ping, profile)[:, 2]
    wrong_m = sound_points(ping, SoundSpeedProfile.even(profile.at(depth)))[:, 2]
    outer, inner = slice(0, 20), slice(180, 220)
    assert np.median(right_m[outer]) == pytest.approx(-40, abs=0.15)
    assert np.median(right_m[inner]) == pytest.approx(-40, abs=0.05)
    assert np.median(wrong_m[inner]) < -40.2  # the assumed speed is too high, so soundings are too deep
    assert np.median(wrong_m[outer]) - np.median(wrong_m[inner]) > 0.8  # outer beams are bent upwards


def test_invalid_soundings_are_refused() -> None:
    with pytest.raises(ValueError, match=r"sound_speed_profile.depths_m\[2\] = 5 m: must be deeper than the level"):
        SoundSpeedProfile([0, 10, 5], [1480, 1480, 1480])
    with pytest.raises(ValueError, match="ping is a Ping: must be of `mode: physics`"):
        sound_points(Simulator("pool").rov.sonar.ping(), SoundSpeedProfile.even(1480.0))
    with pytest.raises(ValueError, match=r"origin_world_m = .*: must be finite and under water"):
        _core.soundings([[1, 0, 0]], [0.1], (0, 0, 1), SoundSpeedProfile.even(1480.0))
    with pytest.raises(ValueError, match=r"travel_time_s\[0\] = -1: s: must be in"):
        _core.soundings([[1, 0, 0]], [-1.0], (0, 0, -1), SoundSpeedProfile.even(1480.0))
    with pytest.raises(ValueError, match=r"sonar\.mode = geometry: must be physics"):
        Simulator("pool")._core.acoustic_ping(0, 0)
