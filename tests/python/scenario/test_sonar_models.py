"""Sonar models: their YAML files, a scenario's choice of frequency and mode, and errors."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from uwsim import Simulator, _core
from uwsim.mapping import ranging
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.build.multibeam import acoustic_spec, backscatter_by_label, label_names, multibeam_model
from uwsim.scenario.build.world import build_world
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.material import BACKSCATTER
from uwsim.scenario.spec.sonar import load_sonar

POOL = (assets_folder() / "scenarios" / "pool.yaml").read_text()
MODEL = """
name: mine
beams: 101
noise: {level_db: 40}
frequencies:
  - frequency_hz: 450000
    field_of_view_deg: 120
    range_max_m: 60
    beam_width_along_deg: 1.0
    beam_width_across_deg: 1.0
    pulse_length_s: 2.0e-5
    bandwidth_hz: 50000
    source_level_db: 205
    directivity_index_db: 20
"""


def pool(folder: Path, sonar: str, *, more: str = "") -> Path:
    path = folder / "pool.yaml"
    path.write_text(POOL.replace("{model: 2, tilt_deg: 30}", sonar) + more)
    return path


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_the_files_of_the_four_models_on_the_wire_agree_with_the_core(number: int) -> None:
    file, core = multibeam_model(load_sonar(number)), _core.multibeam_model(number)
    for field in ("number", "beams", "range_max_m", "range_limit_m", "frequency_hz", "dual_swath"):
        assert getattr(file, field) == getattr(core, field)
    assert file.field_of_view_rad == pytest.approx(core.field_of_view_rad, rel=1e-12)
    assert file.receiver_tilt_rad == pytest.approx(core.receiver_tilt_rad, rel=1e-12)
    assert file.tilt_rate_rad_s == pytest.approx(core.tilt_rate_rad_s, rel=1e-5)


@pytest.mark.parametrize("name", ["em2040-04", "em2040-07"])
def test_the_physical_instruments_have_acoustic_values_at_five_frequencies(name: str) -> None:
    model = load_sonar(name)
    assert [band.frequency_hz for band in model.frequencies] == [200e3, 300e3, 400e3, 600e3, 700e3]
    for band in model.frequencies:
        assert acoustic_spec(model, band.frequency_hz).parameters.frequency_hz == band.frequency_hz
        assert multibeam_model(model, band.frequency_hz).number == 0
    with pytest.raises(ValueError, match=r"frequency_hz: missing: em2040-0. works at 200000, 300000, .*, 700000 Hz"):
        multibeam_model(model)


def test_a_scenario_chooses_model_frequency_and_mode(tmp_path: Path) -> None:
    path = pool(tmp_path, "{model: em2040-04, frequency_hz: 300000, mode: physics, tilt_deg: 40}")
    sonar = Simulator(path).rov.sonar
    assert (sonar.mode, sonar.model.beams, sonar.model.frequency_hz) == ("physics", 400, 300e3)
    ping = sonar.ping()
    assert isinstance(ping, _core.PhysicsPing) and ping.ranges_m.shape == (400,)
    assert Simulator("pool").rov.sonar.mode == "geometry"


def test_a_users_own_model_is_found_beside_the_scenario_and_mounted_as_given(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(
        MODEL + "mounting: {position_m: [0, 0, -0.5], yaw_pitch_roll_deg: [90, 0, 0]}\n"
    )
    sim = Simulator(pool(tmp_path, "{model: mine.yaml}"))
    ping = sim.rov.sonar.ping()
    assert sim.rov.sonar.model.beams == 101
    mount = load(pool(tmp_path, "{model: 2}")).vehicles[0].model.sonar
    assert mount is not None
    body_from_sonar = np.linalg.inv(sim.rov.pose.world_from_body) @ ping.world_from_sonar
    assert body_from_sonar[:3, 3] == pytest.approx(np.add(mount.position_m, (0, 0, -0.5)))
    assert body_from_sonar[:3, 0] == pytest.approx([0, 1, 0], abs=1e-12)  # yaw 90: looks to port


@pytest.mark.parametrize(
    ("given", "instead", "message"),
    [
        ("beams: 101", "beams: 0", "mine.yaml:3: beams = 0: must be in [2, 8192]"),
        ("field_of_view_deg: 120", "field_of_view_deg: 361", ":7: frequencies[0].field_of_view_deg = 361 deg: must be"),
        (
            "frequency_hz: 450000",
            "frequency_hz: -450000",
            ":6: frequencies[0].frequency_hz = -450000 Hz: must be in [1000",
        ),
        ("range_max_m: 60", "range_max_m: 0", ":8: frequencies[0].range_max_m = 0 m: must be in [0.1, 12000] m"),
        ("range_max_m: 60", "range_max_m: .nan", ":8: frequencies[0].range_max_m = nan m: must be in"),
        (
            "range_max_m: 60",
            "range_max_m: 60\n    range_limit_m: 61",
            "range_limit_m = 61 m: must be at most range_max",
        ),
        ("beam_width_along_deg: 1.0", "beam_width_along_deg: 0", "beam_width_along_deg = 0 deg: must be in [0.01"),
        ("    source_level_db: 205\n", "", "frequencies[0].source_level_db: missing: physics mode needs it"),
        (
            "pulse_length_s: 2.0e-5",
            "pulse_length_s: 1.0e-6",
            "pulse_length_s = 1e-06 s: must be at least 1 / bandwidth",
        ),
        ("bandwidth_hz: 50000", "bandwidth_hz: 500000", "bandwidth_hz = 500000 Hz: must be at most the frequency"),
        ("{level_db: 40}", "{levl_db: 40}", ":4: noise.levl_db: unknown key; did you mean 'level_db'?"),
        ("beams: 101", "beams: many", ":3: beams = 'many': must be a whole number"),
        ("name: mine", "name: mine\nping_rate_max_hz: -5", "ping_rate_max_hz = -5 Hz: must be in [0.01, 1000] Hz"),
        ("frequencies:", "frequencis:", "frequencis: unknown key; did you mean 'frequencies'?"),
    ],
)
def test_an_error_in_a_model_names_file_line_value_unit_and_rule(
    given: str, instead: str, message: str, tmp_path: Path
) -> None:
    assert given in MODEL
    path = tmp_path / "mine.yaml"
    path.write_text(MODEL.replace(given, instead, 1))
    with pytest.raises(ScenarioError) as error:
        load_sonar(path)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("sonar", "message"),
    [
        ("{model: em2040-05}", "unknown sonar 'em2040-05': expected one of"),
        ("{model: nowhere/mine.yaml}", "nowhere/mine.yaml: no such file"),
        ("{model: em2040-04}", "frequency_hz: missing: em2040-04 works at 200000, 300000"),
        ("{model: em2040-04, frequency_hz: 500000}", "frequency_hz = 500000 Hz: em2040-04 works at 200000, 300000"),
        ("{model: 2, frequency_hz: 600000}", "frequency_hz = 600000 Hz: em2040-2 works at 700000 Hz"),
        ("{model: 2, mode: phsics}", "sonar.mode = 'phsics': must be 'geometry' or 'physics'"),
        ("{model: em2040-04, frequency_hz: 700000, receivers: 2}", "29 deg, 80 deg apart, do not meet"),
        ("{model: 2, receivers: 2}", "receivers = 2: em2040-2 has 1"),
        ("{model: 3, receivers: 1}", "receivers = 1: em2040-3 has 2"),
        ("{model: em2040-04, frequency_hz: 400000, receivers: 3}", "sonar.receivers = 3: must be 1 or 2"),
        ("{model: 2, bending: true}", "sonar.bending = true: is for `mode: physics` only"),
        ("{model: 2, mode: physics, rays_per_beam: 2}", "rays_per_beam = 2: must be in [4, 64]"),
    ],
)
def test_an_error_in_a_scenarios_sonar_is_named(sonar: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as error:
        load(pool(tmp_path, sonar))
    assert message in str(error.value) and "pool.yaml:" in str(error.value)


def test_two_receivers_widen_the_fan_and_steer_less(tmp_path: Path) -> None:
    def widest(receivers: int) -> tuple[float, float]:
        sonar = f"{{model: em2040-04, frequency_hz: 200000, receivers: {receivers}, mode: physics, tilt_deg: 90}}"
        model = Simulator(pool(tmp_path, sonar)).rov.sonar.model
        return math.degrees(model.field_of_view_rad), math.degrees(model.receiver_tilt_rad)

    assert widest(1) == pytest.approx((140.0, 0.0))
    assert widest(2) == pytest.approx((220.0, 40.0))  # "up to 220 degrees": the manufacturer's installation manual
    (tmp_path / "mine.yaml").write_text(MODEL + "receivers: 2\n")
    with pytest.raises(ScenarioError, match="receiver_tilt_deg: missing: two receivers need it"):
        load(pool(tmp_path, "{model: mine.yaml}"))


def test_a_model_without_acoustics_is_for_geometry_mode_only(tmp_path: Path) -> None:
    (tmp_path / "fan.yaml").write_text(MODEL[: MODEL.index("    beam_width_along_deg")])
    assert Simulator(pool(tmp_path, "{model: fan.yaml}")).rov.sonar.model.beams == 101
    with pytest.raises(ScenarioError, match="mine at 450000 Hz: beam_width_along_deg: missing: physics mode needs it"):
        load(pool(tmp_path, "{model: fan.yaml, mode: physics}"))


def test_echo_levels_follow_the_materials_of_surfaces(tmp_path: Path) -> None:
    physics = "{model: 2, mode: physics, tilt_deg: 90}"

    def levels(ground: str) -> float:
        sim = Simulator(pool(tmp_path, physics, more=f"ground: {ground}\n"))
        sim.rov.release()
        sim.rov.place((-6.5, 5.0, -2.0))
        return float(np.median(sim.rov.sonar.ping().intensity_db))

    assert levels("{bed: rock}") - levels("{bed: mud}") == pytest.approx(14.0, abs=1.5)
    assert levels("{bed: sand, strength_db: -20, relief: 0.1}") - levels("{bed: rock}") == pytest.approx(10.0, abs=0.5)
    for ground, message in (
        ("{bed: sandd}", "ground.bed = 'sandd': must be one of plain, sand"),
        ("{strength_db: 50}", "ground.strength_db = 50 dB: must be in [-100, 30] dB"),
    ):
        with pytest.raises(ScenarioError) as error:
            load(pool(tmp_path, physics, more=f"ground: {ground}\n"))
        assert message in str(error.value)


def test_exact_rays_return_levels_by_material_too(tmp_path: Path) -> None:
    def levels(bed: str) -> NDArray[np.float32]:
        sim = Simulator(pool(tmp_path, "{model: 2, tilt_deg: 90}", more=f"ground: {{bed: {bed}}}\n"))
        sim.rov.release()
        sim.rov.place((-6.5, 5.0, -2.0))
        ping = sim.rov.sonar.ping()
        return ping.intensity_db[ping.labels == 1]

    np.testing.assert_allclose(levels("rock") - levels("mud"), 14.0, atol=1e-4)
    assert len(levels("sand")) > 100


def test_each_label_scatters_as_its_material() -> None:
    scenario = load("lake")
    by_name = dict(zip(label_names(scenario), backscatter_by_label(scenario), strict=True))
    assert by_name["terrain"] == BACKSCATTER[scenario.ground.bed]
    assert by_name["pipeline_main"] == BACKSCATTER["concrete"]
    assert by_name["station"] == scenario.station.material.backscatter


@pytest.mark.parametrize("name", ["pool", "lake", "pair"])
def test_labels_are_known_before_the_world_is_built(name: str) -> None:
    scenario = load(name)
    vehicles = [entry.name for entry in scenario.vehicles]
    assert label_names(scenario) == [*build_world(scenario).label_names, *vehicles]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("beams", 0),
        ("field_of_view_rad", 7.0),
        ("frequency_hz", -1.0),
        ("range_max_m", math.nan),
        ("ping_rate_max_hz", 0.0),
    ],
)
def test_the_core_refuses_an_invalid_fan(field: str, value: float) -> None:
    figures = {"name": "x", "beams": 3, "field_of_view_rad": 1.0, "range_max_m": 50.0, "frequency_hz": 4e5}
    with pytest.raises(ValueError, match=f"sonar.{field} = "):
        _core.MultibeamModel(**{**figures, field: value})  # type: ignore[arg-type]


def test_a_sonar_that_is_not_on_the_wire_works_through_the_same_chain(tmp_path: Path) -> None:
    sim = Simulator(pool(tmp_path, "{model: em2040-07, frequency_hz: 700000, mode: physics, tilt_deg: 40}"))
    model, ping = sim.rov.sonar.model, sim.rov.sonar.ping()
    decoded = ranging.decode_depth_string(ranging.encode_depth_string(ping.ranges_m, model), model)
    scan = ranging.to_laser_scan(decoded, model)
    assert scan.angle_increment == pytest.approx(np.radians(29) / 399)
    points = ranging.to_point_cloud(scan)
    np.testing.assert_allclose(points, ping.points_sonar_m[ping.valid], atol=1e-5)
    with pytest.raises(ValueError, match="for model EM 2040 MKII"):
        ranging.encode_depth_string(ping.ranges_m[:5], model)


def test_a_smaller_range_set_by_the_operator_raises_the_ping_rate_and_limits_the_echoes(tmp_path: Path) -> None:
    whole = Simulator(pool(tmp_path, "{model: em2040-07, frequency_hz: 700000, tilt_deg: 40}")).rov.sonar
    far = whole.ping().ranges_m
    reach = round(float(np.median(far)), 2)
    mount = f"{{model: em2040-07, frequency_hz: 700000, range_max_m: {reach}, tilt_deg: 40}}"
    shorter = Simulator(pool(tmp_path, mount)).rov.sonar
    assert shorter.model.range_max_m == reach < whole.model.range_max_m
    assert shorter.ping_rate_max_hz > whole.ping_rate_max_hz
    near = shorter.ping().ranges_m
    assert 0 < np.isfinite(near).sum() < len(near)
    np.testing.assert_array_equal(near, np.where(far < reach, far, np.inf))
    with pytest.raises(ScenarioError, match=r"range_max_m = 4 m: must be left out for em2040-2, whose range is fixed"):
        load(pool(tmp_path, "{model: 2, range_max_m: 4}"))


def test_the_values_of_a_scenarios_own_sonar_change_its_fingerprint(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(MODEL)
    before = scenario_fingerprint(load(pool(tmp_path, "{model: mine.yaml}")))
    (tmp_path / "mine.yaml").write_text(MODEL.replace("beams: 101", "beams: 102"))
    assert scenario_fingerprint(load(pool(tmp_path, "{model: mine.yaml}"))) != before
