"""The packaged scenarios have the documented features, and the built worlds match the scenarios."""

import math
import os
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from matplotlib.path import Path as Polygon
from scipy.ndimage import binary_dilation

from uwsim import Simulator
from uwsim.scenario import (
    RepairWarning,
    ScenarioError,
    Terrain,
    build_terrain,
    build_world,
    load,
    load_vehicle,
    rigid_body,
)
from uwsim.scenario import start_pose as start
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.spec.optics import Optics


@cache
def terrain_of(name: str) -> Terrain:
    return build_terrain(load(name).terrain)


def points_within(terrain: Terrain, area_m: tuple[tuple[float, float], ...], margin_m: float = 0) -> np.ndarray:
    """Return the terrain nodes (n, 3) inside the polygon or, with a margin, in a band of that width around it."""
    ny, nx = terrain.heights_m.shape
    x, y = np.meshgrid(np.arange(nx), np.arange(ny))
    xy = np.column_stack([x.ravel(), y.ravel()]) * terrain.spacing_m + terrain.origin_m
    low, high = np.min(area_m, axis=0) - margin_m, np.max(area_m, axis=0) + margin_m
    inside = Polygon(area_m).contains_points(xy)
    chosen = ((xy >= low) & (xy <= high)).all(axis=1) & ~inside if margin_m else inside
    return np.column_stack([xy, terrain.heights_m.ravel()])[chosen]


def test_the_lake_is_40_m_deep_and_ringed_by_hills() -> None:
    z = terrain_of("lake").heights_m
    assert -42 < z.min() < -38
    assert min(z[0].min(), z[-1].min(), z[:, 0].min(), z[:, -1].min()) > 5


@pytest.mark.parametrize("name", ["lake", "valley"])
def test_the_survey_area_has_hills_a_pipeline_and_a_gate_below_the_flying_height(name: str) -> None:
    scenario, terrain = load(name), terrain_of(name)
    survey = scenario.survey
    assert survey is not None
    bed = points_within(terrain, survey.area_m)
    size = np.ptp(survey.area_m, axis=0)
    assert (size >= ([150, 100] if name == "lake" else [120, 80])).all()
    assert np.ptp(bed[:, 2]) > 5
    assert bed[:, 2].max() < -12
    beside = points_within(terrain, survey.area_m, margin_m=15)
    # The vehicle turns here at its usual height above the bed, so nothing may be close to its sides.
    assert beside[:, 2].max() < -12
    for kind in ("pipeline", "gate"):
        inside = [
            Polygon(survey.area_m).contains_points(obstacle_solid(o, terrain).vertices[:, :2]).any()
            for o in scenario.obstacles
            if o.kind == kind
        ]
        assert any(inside)
    for obstacle in scenario.obstacles:
        vertices = obstacle_solid(obstacle, terrain).vertices
        assert (vertices[:, 2] - terrain.height_at(vertices[:, :2])).max() < survey.altitude_m - 1


AHEAD, ASTERN, PORT, STARBOARD, DOWN = ([5, 0, 0], [-5, 0, 0], [0, 5, 0], [0, -5, 0], [0, 0, -5])


@pytest.mark.parametrize("way_m", [AHEAD, ASTERN, PORT, STARBOARD, DOWN])
@pytest.mark.parametrize("name", ["lake", "valley"])
def test_the_docked_vehicle_can_leave_in_every_direction_but_up(name: str, way_m: list[float]) -> None:
    """The hull's bounding box, swept 5 m from the dock, touches neither the station nor the bed."""
    scenario = load(name)
    (x, y, z), yaw_rad = start(scenario, scenario.vehicles[0])
    assert z == pytest.approx(-5)
    assert np.degrees(yaw_rad) == pytest.approx(scenario.station.yaw_deg)
    assert scenario.station.mesh is not None
    station = trimesh.Trimesh(*load_mesh(scenario.station.mesh), process=False)
    low, high = (np.array(f(vehicle_hull(scenario.vehicles[0].model)[0], axis=0)) for f in (np.min, np.max))
    low = low + scenario.station.dock_m - 0.1 + np.minimum(way_m, 0.0)
    high = high + scenario.station.dock_m + 0.1 + np.maximum(way_m, 0.0)
    corners = station.triangles
    apart = (corners.max(axis=1) < low) | (corners.min(axis=1) > high)
    assert apart.any(axis=1).all()
    assert z - terrain_of(name).height_at([[x, y]])[0] > 10


def test_the_world_has_the_scenarios_terrain_solids_and_water() -> None:
    world = build_world(load("valley"))
    terrain = terrain_of("valley")
    assert world.label_names == ["nothing", "terrain", "pipeline_main", "gate_main", "gate_west", "station"]
    assert world.terrain_extent_m == terrain.extent_m
    xy = np.random.default_rng(1).uniform(-150, 150, (500, 2))
    np.testing.assert_allclose(world.height_at(xy), terrain.height_at(xy), atol=1e-4)
    water = world.water
    assert water.temperature_deg_c(0.0) == pytest.approx(14)
    assert water.temperature_deg_c(terrain.lowest_m) == pytest.approx(8)


def test_a_start_below_the_bed_or_outside_the_terrain_is_refused() -> None:
    pool = load("pool")

    def moved(position_m: tuple[float, float, float]) -> None:
        build_world(pool.model_copy(update={"station": pool.station.model_copy(update={"position_m": position_m})}))

    with pytest.raises(ScenarioError, match=r"vehicle 'rov' starts at \(0, 0, -6\) m: must be above the bed"):
        moved((0, 0, -4))
    with pytest.raises(ScenarioError, match=r"vehicle 'rov' starts at \(11, 0\) m: outside the terrain"):
        moved((11, 0, 0))


def test_a_start_inside_an_obstacle_is_refused(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    path = tmp_path / "blocked.yaml"
    path.write_text(text.replace("position_m: [3, 0, -4.5]", "position_m: [-5.8, 0.1, -2.2]"))
    with pytest.raises(
        ScenarioError, match=r"blocked.yaml:\d+: vehicle 'rov' starts at \(-6, 0, -2\) m: .*outside 'box'"
    ):
        build_world(load(path))


FAR_GATE = "{kind: gate, name: far, position_m: [0, 50], width_m: 2, height_m: 1}"


@pytest.mark.parametrize(
    ("given", "instead", "culprit", "message"),
    [
        ("[4, 4]", "[400, 4]", "[400, 4]", "survey.area_m[2] = (400, 4) m: outside the terrain"),
        ("start: station", "start: {position_m: [0, 0, -9]}", "start: {", "vehicle 'rov' starts at (0, 0, -9) m: must"),
        ("start: station", "start: {position_m: [0, 50, -1]}", "start: {", "vehicle 'rov' starts at (0, 50) m: out"),
        ("obstacles:", f"obstacles:\n  - {FAR_GATE}", "name: far", "obstacle 'far': (0, 49) m lies outside the"),
        ("bed_depth_m: 5", "bed_depth_m: 0", "terrain:", "terrain: its lowest point is at z = "),
    ],
)
def test_a_value_that_does_not_fit_the_world_is_reported_with_file_and_line(
    given: str, instead: str, culprit: str, message: str, tmp_path: Path
) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text().replace(given, instead, 1)
    text = text.replace("hill_height_m", "# hill_height_m")
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        build_world(load(path))
    line = text[: text.index(culprit)].count("\n") + 1
    assert str(caught.value).startswith(f"{path}:{line}: {message}")


def test_a_hull_is_read_once_until_its_file_changes(tmp_path: Path) -> None:
    def write(size_m: float) -> None:
        mesh = trimesh.creation.box((size_m, 1, 1))
        trimesh.Trimesh(mesh.vertices, mesh.faces[1:], process=False).export(path)
        os.utime(path, ns=(0, int(size_m)))

    path = tmp_path / "hull.obj"
    write(1.0)
    model = load_vehicle("rov").model_copy(update={"mesh": path})
    with pytest.warns(RepairWarning, match="filled holes"):
        vertices, triangles = vehicle_hull(model)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert vehicle_hull(model)[0] is vertices
        assert rigid_body(model, 1000.0).volume_m3 == pytest.approx(1.0)
    for array in (vertices, triangles):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    write(2.0)
    with pytest.warns(RepairWarning):
        assert rigid_body(model, 1000.0).volume_m3 == pytest.approx(2.0)
    with pytest.warns(RepairWarning):
        larger, _ = vehicle_hull(model.model_copy(update={"mesh_scale": 3.0}))
    assert np.ptp(larger[:, 0]) == pytest.approx(6.0)
    path.unlink()
    with pytest.raises(ScenarioError, match="no such file"):
        vehicle_hull(model)


def test_the_rov_is_neutral_upright_and_reaches_its_stated_speeds() -> None:
    model = load_vehicle("rov")
    vertices, triangles = vehicle_hull(model)
    assert len(triangles) <= 2000
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [1.2, 0.8, 0.7], atol=1e-3)
    body = rigid_body(model, 1025.0)
    assert body.mass_kg == pytest.approx(1025 * body.volume_m3)
    np.testing.assert_allclose(body.centre_of_buoyancy_m - body.centre_of_mass_m, [0, 0, 0.1], atol=1e-3)
    effort = np.array([*model.max_force_n, *model.max_torque_nm])
    linear, quadratic = np.array(model.linear_damping), np.array(model.quadratic_damping)
    speed = (np.sqrt(linear**2 + 4 * quadratic * effort) - linear) / (2 * quadratic)
    np.testing.assert_allclose(speed[[0, 1, 2, 5]], [1.6, 0.8, 0.8, 0.7], rtol=0.02)


def test_mass_properties_that_a_model_leaves_out_come_from_its_hull() -> None:
    model = load_vehicle("rov").model_copy(update={"buoyancy": None, "density_kg_m3": 500.0, "inertia_kg_m2": None})
    body = rigid_body(model, 1000.0)
    assert body.mass_kg == pytest.approx(500 * body.volume_m3)
    hull = trimesh.Trimesh(*vehicle_hull(model), process=False)
    np.testing.assert_allclose(body.inertia_kg_m2, 500 * np.diagonal(hull.moment_inertia))


AHEAD_M = 11.7


@pytest.mark.parametrize(("scenario", "least"), [("tarn", 30.0), ("lake", 10.0)])
def test_a_yellow_gate_11_7_m_ahead_is_seen_without_lamps(scenario, least):
    with Simulator(scenario, seed=7) as sim:
        gate = next(each for each in sim.scenario.obstacles if each.name == "gate_main")
        (x, y), half = gate.position_m, math.radians(gate.yaw_deg) / 2
        away_m = AHEAD_M + sim.rov.cameras["front"].mount.position_m[0]
        place = (x - away_m * math.cos(2 * half), y - away_m * math.sin(2 * half))
        z = sim.world.height_at([[x, y]])[0] + 0.5 * gate.height_m
        sim.rov.place((*place, z), (0.0, 0.0, math.sin(half), math.cos(half)))
        frame = sim.rov.cameras["front"].resized(320).capture()
        bars = frame.labels == sim.label_names.index("gate_main")
        around = binary_dilation(bars, iterations=3) & ~bars
        assert np.abs(frame.rgb[bars].mean(axis=0) - frame.rgb[around].mean(axis=0)).max() > least  # of 255


def test_the_training_pool_has_a_wall_in_every_direction():
    with Simulator("training_pool") as sim:
        turns = np.radians(np.arange(0.0, 360.0, 5.0))
        rays = np.column_stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)])
        ranges_m = np.asarray(sim.scene.cast(np.tile([0.0, 0.0, -2.0], (len(rays), 1)), rays, 100.0).ranges_m)
    walls_m = np.minimum(12.5 / np.abs(rays[:, 0]).clip(1e-9), 10.0 / np.abs(rays[:, 1]).clip(1e-9))
    np.testing.assert_allclose(ranges_m, walls_m, atol=0.06)  # targets and lamps stand out by up to 5 cm


def test_a_visibility_that_no_such_water_has_is_refused_before_a_picture() -> None:
    with pytest.raises(ScenarioError, match=r"visibility_m = 0.1 m: impossible in this water: optics.diffuse_atten"):
        Optics(jerlov="III").with_changes({"jerlov": "I", "visibility_m": 0.1})
