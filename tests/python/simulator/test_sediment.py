"""Propellers lift the bed's sediment, which cameras and a multibeam in physics mode meet."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.evidence.scenario_check import check_file
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.dump import plain, write_scenario
from uwsim.scenario.read.validated import validated

HEIGHT_M = 1.0
BED_Z_M = -5.0
VOLUME_DB = -50.0
GRAIN_RADIUS_M = 5e-6
WAVE_NUMBER_RAD_M = 2 * np.pi * 700e3 / 1482  # of the EM 2040 with 513 beams
KILOGRAM_DB = 10 * np.log10(  # of 1 kg/m3: the form function of Thorne and Meral 2008 for k a << 1
    3 * (1.25 * (WAVE_NUMBER_RAD_M * GRAIN_RADIUS_M) ** 2) ** 2 / (16 * np.pi * 2650 * GRAIN_RADIUS_M)
)


def basin(**sediment: Any) -> Scenario:
    """Return the pool with an ROV whose vertical thrusters blow at the bed, and a multibeam in physics mode."""
    values = plain(load("pool"))
    del values["survey"]
    vehicle: dict[str, Any] = {"name": "rov", "model": "bluerov2_heavy_outfit", "start": "station"}
    values["vehicles"] = [vehicle | {"sonar": {"model": 2, "mode": "physics", "tilt_deg": 90}}]
    values["ground"] = {"sediment": sediment}
    return validated(Scenario, values)


def stirred(periods: int, **sediment: Any) -> Simulator:
    """Return a simulator whose ROV has been held over the bed, with thrust upward, for so many half seconds."""
    sim = Simulator(basin(**sediment))
    sim.rov.undock()
    for _ in range(periods):
        hold(sim)
    return sim


def hold(sim: Simulator) -> None:
    sim.rov.place([-5.0, 0.0, BED_Z_M + HEIGHT_M])
    sim.rov.set_effort(heave=0.5)
    sim.step(round(0.5 / sim.step_s))


@pytest.fixture(scope="module")
def cloudy() -> Iterator[tuple[Simulator, bytes]]:
    """A simulator that has stirred for half a minute, and its state then."""
    sim = stirred(60, rate_kg_m2_s=1e-3)
    yield sim, sim.save_state()


def table(sim: Simulator) -> Any:
    clouds = sim.sediment_clouds
    assert clouds is not None
    return clouds.table


def test_jets_that_blow_at_the_bed_lift_it_and_weak_or_distant_ones_do_not() -> None:
    sim = stirred(8)
    mass_kg = table(sim)[:, 5].sum()
    assert mass_kg > 0
    np.testing.assert_allclose(table(sim)[:, 2], BED_Z_M, atol=1e-6)
    assert table(stirred(8, critical_pa=50)).shape == (0, 6)
    down = Simulator(basin())
    down.rov.undock()
    for _ in range(8):
        down.rov.place([-5.0, 0.0, BED_Z_M + HEIGHT_M])
        down.rov.set_effort(heave=-0.5)  # its jets go up
        down.step(round(0.5 / down.step_s))
    assert table(down).shape == (0, 6)
    twice = stirred(8, rate_kg_m2_s=2e-4)
    assert table(twice)[:, 5].sum() == pytest.approx(2 * mass_kg, rel=0.02)  # but for what has settled


def test_clouds_spread_and_settle_after_the_vehicle_has_gone() -> None:
    sim = stirred(10, grain_m=5e-5)
    sim.rov.place([6.0, 6.0, -1.0])
    sim.rov.set_effort()
    sim.step(round(0.5 / sim.step_s))
    before = table(sim)
    sim.step(round(60 / sim.step_s))
    after = table(sim)
    assert after[:, 5].sum() < 0.7 * before[:, 5].sum()
    np.testing.assert_allclose(after[:, 3] ** 2 - before[:, 3] ** 2, 2 * 1e-3 * 60, rtol=1e-6)


def test_a_restored_run_has_the_same_clouds() -> None:
    sim = stirred(4)
    state = sim.save_state()
    hold(sim)
    once = table(sim)
    sim.restore_state(state)
    hold(sim)
    np.testing.assert_array_equal(table(sim), once)


def test_a_cloud_hides_what_is_behind_it_by_beer_and_lambert(cloudy: tuple[Simulator, bytes]) -> None:
    sim, state = cloudy
    sim.restore_state(state)
    sim.rov.place([-7.5, 0.0, BED_Z_M + HEIGHT_M])
    camera, clouds = sim.rov.cameras["front"], sim.sediment_clouds
    assert clouds is not None
    plain_effects = ("noise", "particles", "exposure", "wobble", "vignetting", "shafts")

    def ripple(*without: str) -> Any:
        """Return the difference that the sun's caustics make to each pixel's radiance."""
        lit = camera.capture(without=(*plain_effects, *without), radiance=True).radiance
        dull = camera.capture(without=(*plain_effects, "caustics", *without), radiance=True).radiance
        assert lit is not None and dull is not None
        return lit[..., 1] - dull[..., 1]

    seen, clear = ripple(), ripple("sediment")
    depth_m = camera.capture("off", geometry_only=True).depth_m
    across = camera.ray_table()
    ahead = np.ones(depth_m.shape)
    optical = np.stack([ahead, -across[..., 0], -across[..., 1]], axis=-1)  # x ahead, y left, z up
    pose = camera.world_from_camera
    used = np.isfinite(depth_m) & (np.abs(clear) > 0.02 * np.abs(clear).max())
    ends_m = pose[:3, 3] + depth_m[used][:, None] * (optical[used] @ pose[:3, :3].T)
    eyes_m = np.broadcast_to(pose[:3, 3], ends_m.shape)
    thickness = clouds.extinction_m2_kg * clouds.columns_kg_m2(eyes_m, ends_m)
    assert (thickness > 1).mean() > 0.05 and (thickness < 0.01).any()
    np.testing.assert_allclose(seen[used], clear[used] * np.exp(-thickness), atol=2e-3 * np.abs(clear).max())


def test_a_multibeam_hears_a_cloud_as_water_that_scatters_as_much(cloudy: tuple[Simulator, bytes]) -> None:
    (sim, state), calm = cloudy, Simulator(basin())
    sim.restore_state(state)
    values = plain(basin())
    values["water"]["volume_strength_db"] = VOLUME_DB
    murky = Simulator(validated(Scenario, values))
    pings: list[Any] = []
    for each in (sim, calm, murky):
        if each is not sim:
            each.rov.undock()
            each.step(sim.tick)  # for the same noise
        each.rov.place([-5.0, 0.0, BED_Z_M + 4.0])
        pings.append(each.rov.sonar.ping(water_column=True))
    ranges_m = pings[0].water_column_ranges_m
    beams = np.abs(pings[0].angles_rad) < np.radians(3)
    within = (ranges_m > 2.5) & (ranges_m < 3.7)
    cloud, still, volume = (10.0 ** (ping.water_column[beams].astype(float) / 10) for ping in pings)
    np.testing.assert_array_equal(cloud[:, ranges_m < 2], still[:, ranges_m < 2])
    assert sim.sediment_clouds is not None
    at, end = ([[-5.0, 0.0, BED_Z_M + 4.0 - range_m]] for range_m in (2.5, 3.7))
    column_kg_m2 = sim.sediment_clouds.columns_kg_m2(at, end)[0]
    expected = 10 * np.log10(column_kg_m2 / 1.2) + KILOGRAM_DB - VOLUME_DB  # above the volume's level
    power = (cloud - still)[:, within].mean() / (volume - still)[:, within].mean()
    assert 10 * np.log10(power) == pytest.approx(expected, abs=1.5)


def test_a_check_reports_a_bed_that_nothing_can_stir(tmp_path: Path) -> None:
    path = tmp_path / "still.yaml"
    values = plain(basin())
    values["vehicles"][0] = {"name": "rov", "model": "paper"}
    write_scenario(path, validated(Scenario, values))
    assert any("no vehicle has propellers" in line for line in check_file(path).warnings)


@pytest.mark.parametrize(
    ("values", "rule"),
    [({"grain_m": 0.1}, "grain_m"), ({"critical_pa": 0}, "critical_pa"), ({"rate": 1}, "rate")],
)
def test_what_is_no_sediment_is_refused(values: dict[str, Any], rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        basin(**values)
