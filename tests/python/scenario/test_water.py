"""The native water has the scenario's values; errors name the invalid key."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import _core
from uwsim.scenario import ScenarioError
from uwsim.scenario.build.water import build_water, surface_density_kg_m3
from uwsim.scenario.read.current_grid import read_current_grid
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.water import Water

BOTTOM_M = 30.0


def built(values: dict[str, Any], seed: int = 0, folder: Path | None = None) -> _core.Water:
    return build_water(validated(Water, values, folder=folder), bottom_depth_m=BOTTOM_M, seed=seed)


def refusal(values: dict[str, Any], folder: Path | None = None) -> str:
    with pytest.raises(ScenarioError) as caught:
        built(values, folder=folder)
    return str(caught.value)


def test_water_without_surface_current_and_profile_is_still_and_uniform() -> None:
    water = built({"density_kg_m3": 1010.0, "current_world_m_s": [0.1, 0.0, 0.0], "surface_temperature_deg_c": 12.0})
    assert water.waves is None
    assert water.profile is None
    assert water.pressure_pa(-10.0) == pytest.approx(101325 + 1010 * 9.80665 * 10, rel=3e-5)
    np.testing.assert_allclose(water.velocity_m_s([[0, 0, -3]]), [[0.1, 0, 0]])


def test_an_airy_wave_travels_at_its_phase_speed() -> None:
    water = built({"surface": {"kind": "airy", "amplitude_m": 0.2, "period_s": 3.0, "heading_deg": 90.0}})
    there = [[0.0, 1.5 * 9.80665 * 3 / (2 * np.pi)]]
    assert water.surface_height_m([[0, 0]]) == pytest.approx(0.2)
    assert water.surface_height_m(there, 1.5) == pytest.approx(0.2, abs=1e-6)


def test_a_jonswap_sea_depends_on_the_scenarios_seed() -> None:
    surface = {"kind": "jonswap", "significant_height_m": 0.8, "peak_period_s": 4.0, "spreading_exponent": 4.0}
    first, same, other = (built({"surface": surface}, seed) for seed in (1, 1, 2))
    assert first.waves is not None
    assert first.waves.significant_height_m == pytest.approx(0.8)
    xy = np.random.default_rng(0).uniform(-50, 50, (20, 2))
    np.testing.assert_array_equal(first.surface_height_m(xy, 7.0), same.surface_height_m(xy, 7.0))
    assert not np.allclose(first.surface_height_m(xy, 7.0), other.surface_height_m(xy, 7.0))


def test_currents_add_up() -> None:
    levels = [{"depth_m": 0.0, "velocity_m_s": [0.4, 0.0, 0.0]}, {"depth_m": 20.0, "velocity_m_s": [0.0, 0.0, 0.0]}]
    water = built(
        {
            "current_world_m_s": [0.0, 0.0, 0.01],
            "current": [
                {"kind": "uniform", "velocity_m_s": [0.0, 0.1, 0.0]},
                {"kind": "layers", "levels": levels},
                {"kind": "tidal", "amplitude_m_s": [0.5, 0.0, 0.0], "period_s": 1000.0},
            ],
        }
    )
    np.testing.assert_allclose(water.velocity_m_s([[3, 4, -5]], 250.0), [[0.3 + 0.5, 0.1, 0.01]])


def test_gusts_vary_about_their_mean_and_depend_on_the_seed() -> None:
    current = {"kind": "gusts", "mean_m_s": [0.3, 0.0, 0.0], "sigma_m_s": [0.1, 0.0, 0.0], "correlation_time_s": 5.0}
    gusts = {"current": current}
    water, other = built(gusts, 3), built(gusts, 4)
    speeds = np.array([water.velocity_m_s([[0, 0, -1]], 5.0 * k)[0, 0] for k in range(4000)])
    assert speeds.mean() == pytest.approx(0.3, abs=0.01)
    assert speeds.std() == pytest.approx(0.1, rel=0.05)
    assert speeds[7] != other.velocity_m_s([[0, 0, -1]], 35.0)[0, 0]


def write_grid(path: Path) -> None:
    """Write a current that is linear in each direction, as .npz or .csv."""
    x, y, z = np.array([-5.0, 0, 10]), np.array([0.0, 4]), np.array([-20.0, -10, 0])
    zz, yy, xx = np.meshgrid(z, y, x, indexing="ij")
    velocity = np.stack([0.01 * xx, 0.02 * yy + 0.001 * xx, 0.001 * zz], axis=-1)
    if path.suffix == ".npz":
        np.savez(path, x_m=x, y_m=y, z_m=z, velocity_m_s=velocity)
    else:
        rows = np.column_stack([xx.ravel(), yy.ravel(), zz.ravel(), velocity.reshape(-1, 3)])
        shuffled = np.random.default_rng(0).permutation(rows)
        np.savetxt(path, shuffled, delimiter=",", header="x_m,y_m,z_m,u_m_s,v_m_s,w_m_s", comments="")


@pytest.mark.parametrize("suffix", ["npz", "csv"])
def test_a_grid_file_is_trilinear_between_its_points(suffix: str, tmp_path: Path) -> None:
    write_grid(path := tmp_path / f"field.{suffix}")
    water = built({"current": {"kind": "grid", "file": path.name}}, folder=tmp_path)
    np.testing.assert_allclose(water.velocity_m_s([[2.0, 1.0, -13.0]]), [[0.02, 0.022, -0.013]], atol=1e-12)


def test_a_table_gives_density_pressure_and_sound_speed(tmp_path: Path) -> None:
    (tmp_path / "cast.csv").write_text(
        "# a cast\ndepth_m,temperature_deg_c,salinity_psu\n0,15,34\n10,13,34.5\n30,8,35\n"
    )
    inline = [
        {"depth_m": d, "temperature_deg_c": t, "salinity_psu": s}
        for d, t, s in ((0.0, 15.0, 34.0), (10.0, 13.0, 34.5), (30.0, 8.0, 35.0))
    ]
    waters = [
        built({"profile": {"kind": "table", "file": "cast.csv"}}, folder=tmp_path),
        built({"profile": {"kind": "table", "levels": inline}}),
    ]
    top, middle = (_core.sea_water_density_kg_m3(t, s) for t, s in ((15.0, 34.0), (13.0, 34.5)))
    for water in waters:
        assert water.density_at_kg_m3(-5.0) == pytest.approx((top + middle) / 2)
        assert water.pressure_pa(-10.0) == pytest.approx(101325 + 9.80665 * 10 * (top + middle) / 2, rel=3e-5)
        assert water.temperature_deg_c(-20.0) == pytest.approx(10.5)
        assert water.sound_speed_m_s(-20.0) == pytest.approx(_core.sound_speed_m_s(10.5, 34.75, 20.0))
    given = [{**level, "sound_speed_m_s": 1500.0 - level["depth_m"]} for level in inline]
    assert built({"profile": {"kind": "table", "levels": given}}).sound_speed_m_s(-20.0) == pytest.approx(1480)


def test_pressure_includes_compression_unless_the_scenario_says_otherwise() -> None:
    still = {"density_kg_m3": 1000.0, "bottom_temperature_deg_c": 15.0}
    squeezed, stiff = built(still), built({**still, "compressible": False})
    depth_m = 1000.0
    weight_pa = 1000 * 9.80665 * depth_m
    assert stiff.pressure_pa(-depth_m) == pytest.approx(101325 + weight_pa, rel=1e-12)
    more_m = (squeezed.pressure_pa(-depth_m) - stiff.pressure_pa(-depth_m)) / (1000 * 9.80665)
    ratio = _core.sea_water_density_kg_m3(15.0, 0.0, weight_pa) / _core.sea_water_density_kg_m3(15.0, 0.0)
    heavier = 2.26e-7 * depth_m  # gravity at the foot, over the surface's
    assert more_m == pytest.approx(depth_m * (ratio - 1 + heavier) / 2, rel=0.01), "means over the column"


def test_the_sound_speed_equation_is_the_best_or_the_named_one() -> None:
    assert built({}).sound_speed_equation == "belogolskii"
    assert built({"salinity_psu": 35.0}).sound_speed_equation == "unesco"
    named = built({"salinity_psu": 35.0, "sound_speed_equation": "mackenzie"})
    assert named.sound_speed_m_s(0.0) == pytest.approx(_core.sound_speed_m_s(15.0, 35.0, 0.0, "mackenzie"), abs=1e-9)
    got = refusal({"sound_speed_equation": "mackenzie"})
    assert "sound_speed_equation = mackenzie: is valid for 2 to 30 deg C, 25 to 40 psu" in got and "0 to 0 psu" in got
    assert "sound_speed_equation" in refusal({"sound_speed_equation": "wilson"})
    levels = [{"depth_m": 0.0, "temperature_deg_c": 9.0, "sound_speed_m_s": 1450.0}]
    got = refusal({"profile": {"kind": "table", "levels": levels}, "sound_speed_equation": "unesco"})
    assert "must not be given beside a profile that gives sound_speed_m_s" in got


@pytest.mark.parametrize("bad", [float("nan"), -3.0, float("inf")])
def test_sound_in_impossible_water_is_refused(bad: float) -> None:
    for arguments in ((bad, 35.0, 10.0), (10.0, bad, 10.0), (10.0, 35.0, bad)):
        with pytest.raises(ValueError, match="must be in"):
            _core.sound_speed_m_s(*arguments)
        with pytest.raises(ValueError, match="must be in"):
            _core.absorption_db_km(3e5, *arguments)
    with pytest.raises(ValueError, match="frequency_hz"):
        _core.absorption_db_km(bad, 10.0, 35.0, 10.0)


def test_the_density_of_a_linear_profile_follows_eos_80_to_the_bottom() -> None:
    ends = {"surface": {"temperature_deg_c": 20.0}, "bottom": {"temperature_deg_c": 6.0, "salinity_psu": 10.0}}
    water = built({"profile": {"kind": "linear", **ends}})
    assert water.temperature_deg_c(-BOTTOM_M / 2) == pytest.approx(13)
    for depth in (0.0, 7.3, 15.0, 30.0):
        t, s = 20 - 14 * depth / BOTTOM_M, 10 * depth / BOTTOM_M
        assert water.density_at_kg_m3(-depth) == pytest.approx(_core.sea_water_density_kg_m3(t, s), abs=2e-3)
    spec = validated(Water, {"profile": {"kind": "linear", **ends}})
    assert surface_density_kg_m3(spec) == pytest.approx(water.density_at_kg_m3(0.0))


def test_invalid_water_is_refused_by_its_key(tmp_path: Path) -> None:
    assert "surface.period_s = 0 s: must be in" in refusal(
        {"surface": {"kind": "airy", "amplitude_m": 1, "period_s": 0}}
    )
    assert "'airy'" in refusal({"surface": {"kind": "air", "amplitude_m": 1.0}})
    assert "the wave would break" in refusal({"surface": {"kind": "airy", "amplitude_m": 3.0, "period_s": 2.0}})
    assert "current[0].sigma_m_s[1] = -1 m/s" in refusal(
        {"current": [{"kind": "gusts", "sigma_m_s": [0.1, -1.0, 0.0], "correlation_time_s": 3.0}]}
    )
    assert "surface.depth_m = 100 m: must be at most 30 m, as deep as the terrain is" in refusal(
        {"surface": {"kind": "airy", "amplitude_m": 0.1, "period_s": 3.0, "depth_m": 100.0}}
    )
    levels = [{"depth_m": 3.0, "temperature_deg_c": 9.0}, {"depth_m": 3.0, "temperature_deg_c": 8.0}]
    got = refusal({"profile": {"kind": "table", "levels": levels}})
    assert "profile.levels[1].depth_m = 3 m: must be deeper than the level before" in got
    assert "density_kg_m3 = 1020: must not be given beside profile" in refusal(
        {"density_kg_m3": 1020.0, "profile": {"kind": "table", "levels": levels[:1]}}
    )
    (tmp_path / "bad.csv").write_text("x_m,y_m,z_m,u_m_s,v_m_s,w_m_s\n0,0,0,1,0,0\n1,1,0,1,0,0\n")
    got = refusal({"current": {"kind": "grid", "file": "bad.csv"}}, tmp_path)
    assert "2 rows for 2 x 2 x 1 points" in got and got.count("bad.csv") == 1
    (tmp_path / "bad.npz").write_bytes(b"no")
    assert "not a .npz file" in refusal({"current": {"kind": "grid", "file": "bad.npz"}}, tmp_path)


STEADY = {"kind": "uniform", "velocity_m_s": [4.0, 0.0, 0.0]}
TIDE = {"kind": "tidal", "amplitude_m_s": [4.0, 0.0, 0.0]}


@pytest.mark.parametrize(
    "more",
    [
        {"kind": "tidal", "amplitude_m_s": [0.0, 4.0, 0.0]},
        {"kind": "gusts", "sigma_m_s": [1.0, 0.0, 0.0], "correlation_time_s": 3.0},
        {
            "kind": "layers",
            "levels": [{"depth_m": 0.0, "velocity_m_s": [0, 0, 0]}, {"depth_m": 9, "velocity_m_s": [3, 0, 0]}],
        },
    ],
    ids=lambda more: more["kind"],
)
def test_varying_and_steady_currents_are_bounded_together(more: dict[str, Any]) -> None:
    built({"current": [STEADY, TIDE]})
    built({"current": [STEADY, more]})
    got = refusal({"current": [STEADY, TIDE, more]})
    assert re.match(r"water\.current = 1[12](\.\d+)? m/s, the sum .*: must be at most 10 m/s", got)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("cut.npz", b"PK\x03\x04 and no more", "not a .npz file"),
        ("twice.csv", b"x_m,y_m,z_m,u_m_s,v_m_s,w_m_s,u_m_s\n0,0,0,1,0,0,2\n", "column 'u_m_s' is named twice"),
    ],
)
def test_a_malformed_current_file_is_refused_in_one_line(
    name: str, content: bytes, message: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ScenarioError, match=message):
        read_current_grid(tmp_path / name)


def test_complex_currents_are_refused(tmp_path: Path) -> None:
    axis = np.array([0.0, 1.0])
    np.savez(tmp_path / "c.npz", x_m=axis, y_m=axis, z_m=axis, velocity_m_s=np.zeros((2, 2, 2, 3), complex))
    with pytest.raises(ScenarioError, match="real numbers"):
        read_current_grid(tmp_path / "c.npz")


def test_water_is_shown_with_its_properties() -> None:
    water = _core.Water()
    water.density_kg_m3, water.salinity_psu, water.current_world_m_s = 1025.0, 35.0, [0.3, 0.0, 0.4]
    assert repr(water) == "<Water: 1025 kg/m3, 15 deg C, 35 psu at the surface; a current of 0.5 m/s>"
