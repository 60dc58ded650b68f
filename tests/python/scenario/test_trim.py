"""A trimmed vehicle has its stated net buoyancy in any water; obstacles rest on the bed; a station is optional."""

from pathlib import Path

import numpy as np
import pytest

from uwsim import Scenario, ScenarioError, Simulator
from uwsim.scenario import build_terrain, load
from uwsim.scenario.build.solids import obstacle_solid, surface_points
from uwsim.scenario.read.assets import assets_folder

COVE = (assets_folder() / "scenarios" / "cove.yaml").read_text()


def cove(tmp_path: Path, *edits: tuple[str, str]) -> Path:
    text = COVE
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "cove.yaml"
    path.write_text(text)
    return path


def deep(trim: str, density: float, tmp_path: Path) -> Path:
    return cove(
        tmp_path,
        ("model: rov\n    start: station", f"model: bluerov2_heavy\n    start: {{position_m: [-16, -4, -4]}}{trim}"),
        ("  density_kg_m3: 1000\n", f"  density_kg_m3: {density}\n  compressible: false\n"),
        ("    sonar: {model: 2, tilt_deg: 20}\n", ""),
    )


@pytest.mark.parametrize("density", [1000.0, 1025.0])
@pytest.mark.parametrize("net_n", [2.0, -3.0])
def test_a_trimmed_vehicle_has_that_net_buoyancy_in_any_water(density: float, net_n: float, tmp_path: Path) -> None:
    sim = Simulator(deep(f"\n    trim: {{net_buoyancy_n: {net_n}}}", density, tmp_path))
    mass_kg = 1.025 * 13.4 if density > 1010 else 13.4
    mass_kg -= net_n / 9.80665
    sim.advance(0.5)
    accelerating_kg = mass_kg + 18.6863  # including the added mass in heave
    assert sim.rov.velocity.linear_body_m_s[2] == pytest.approx(net_n / accelerating_kg * 0.5, rel=0.35)
    assert np.sign(sim.rov.velocity.linear_body_m_s[2]) == np.sign(net_n)


def test_a_trim_that_no_operator_could_make_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"trim\.net_buoyancy_n = 100 N: must be at most 65\.2. N in this water"):
        Simulator(deep("\n    trim: {net_buoyancy_n: 100}", 1000.0, tmp_path))


SHAPES = [
    "kind: box, size_m: [4, 3, 1]",
    "kind: sphere, radius_m: 1.5",
    "kind: cylinder, radius_m: 0.5, length_m: 3, yaw_pitch_roll_deg: [20, 70, 0]",
    "kind: mesh, file: meshes/remus100.obj, yaw_pitch_roll_deg: [0, 10, 0]",
]


@pytest.mark.parametrize("shape", SHAPES)
def test_what_stands_on_the_bed_touches_it_and_is_not_in_it(shape: str, tmp_path: Path) -> None:
    stone = f"  - {{{shape}, name: stone, position_m: [-6, -16, 0], on_bed: true}}\n"
    path = cove(tmp_path, ("obstacles:\n", f"obstacles:\n{stone}"))
    scenario = load(path)
    terrain = build_terrain(scenario.terrain)
    vertices, triangles, _ = obstacle_solid(scenario.obstacles[0], terrain)
    points = np.concatenate([vertices, surface_points(vertices, triangles)])
    clear_m = points[:, 2] - terrain.height_at(points[:, :2])
    assert clear_m.min() == pytest.approx(0.0, abs=1e-9)
    assert clear_m.max() > 0.1
    sunk = scenario.obstacles[0].model_copy(update={"position_m": (-6.0, -16.0, -0.2)})
    assert obstacle_solid(sunk, terrain).vertices[:, 2] == pytest.approx(vertices[:, 2] - 0.2)


FOLLOWERS = [
    "kind: pipeline, points_m: [[-6, -16], [-3, -14]], radius_m: 0.2",
    "kind: gate, position_m: [-6, -16], width_m: 2, height_m: 1",
]


@pytest.mark.parametrize("shape", FOLLOWERS)
def test_what_always_stands_on_the_bed_may_say_so(shape: str, tmp_path: Path) -> None:
    def scenario(on_bed: str) -> Scenario:
        line = f"  - {{{shape}, name: thing{on_bed}}}\n"
        return load(cove(tmp_path, ("obstacles:\n", f"obstacles:\n{line}")))

    assert scenario(", on_bed: true") == scenario("")
    with pytest.raises(ScenarioError, match="on_bed = false: must be true"):
        scenario(", on_bed: false")


def test_points_are_spread_evenly_over_a_surface() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    points = surface_points(corners, np.array([[0, 1, 2], [0, 2, 3]]), 2000)
    counts, _, _ = np.histogram2d(points[:, 0], points[:, 1], bins=5)
    assert counts == pytest.approx(80, rel=0.2)


def test_a_scenario_needs_no_station(tmp_path: Path) -> None:
    start = COVE.index("station:\n")
    text = COVE[:start] + COVE[COVE.index("obstacles:\n") :]
    path = tmp_path / "cove.yaml"
    path.write_text(text)
    with Simulator(path) as sim:
        assert sim.rov.pose.position_world_m.tolist() == [0.0, 0.0, -2.0]
        sim.rov.undock()
        sim.advance(0.1)
