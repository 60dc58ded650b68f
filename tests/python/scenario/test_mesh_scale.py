"""A mesh not in metres is refused when it is read; the error states the values and the likely unit."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml

from command_line import error_line, uwsim
from uwsim import Simulator
from uwsim.evidence.scenario_check import check_file, check_part
from uwsim.scenario import ScenarioError, load_mesh
from uwsim.scenario.dump import new_scenario
from vehicle_files import box_mesh, scenario_file, vehicle_file

LENGTHS = {"millimetres": 1e3, "centimetres": 1e2, "inches": 1 / 0.0254, "feet": 1 / 0.3048}


def refusals(folder: Path, **changes: Any) -> list[str]:
    """Return the errors from the vehicle check, the scenario check and the simulator; empty if the vehicle is valid."""
    model = vehicle_file(folder, **changes)
    scenario = scenario_file(folder, model)
    told = [*check_part(model, "vehicle").mistakes, *check_file(scenario).mistakes]
    try:
        Simulator(scenario)
    except ScenarioError as error:
        told.append(str(error))
    return told


@pytest.mark.parametrize("unit", LENGTHS)
def test_a_hull_in_another_unit_is_refused_by_its_density_and_the_unit_is_asked_for(unit: str, tmp_path: Path) -> None:
    told = refusals(tmp_path, scale=LENGTHS[unit], mass_kg=672.0, without=("buoyancy",))
    assert len(told) == 3, told
    for message in told:
        assert f"is its mesh in {unit}? mesh_scale: {1 / LENGTHS[unit]:g}" in message
        assert "must be in [" in message and "box.yaml:" in message


def test_a_neutral_hull_has_no_density_to_betray_it_but_its_volume_does(tmp_path: Path) -> None:
    told = refusals(tmp_path, scale=1e3)
    assert len(told) == 3, told
    for message in told:
        assert "1200 x 800 x 700 m encloses 6.72e+08 m3: must be in [1e-06, 100000] m3" in message
        assert "millimetres" in message
    told = refusals(tmp_path, mesh_scale=0.001)
    assert len(told) == 3 and all("is mesh_scale = 0.001 too small?" in message for message in told)


def test_a_published_volume_betrays_the_unit(tmp_path: Path) -> None:
    told = refusals(tmp_path, scale=1e3, volume_m3=0.672)
    assert len(told) == 3, told
    assert all(
        "lengths would scale by 0.001" in message and "is its mesh in millimetres?" in message for message in told
    )


def test_one_cause_gives_one_message(tmp_path: Path) -> None:
    """A 600 m hull in a 200 m terrain also has an implausible density for a vehicle."""
    model = vehicle_file(tmp_path, size_m=(6.0, 0.1, 0.1), scale=1e2, mass_kg=60.0, without=("buoyancy",))
    mistakes = check_file(scenario_file(tmp_path, model)).mistakes
    assert len(mistakes) == 1 and "is its mesh in centimetres?" in mistakes[0]


def test_a_hull_that_has_no_room_in_its_world_is_refused(tmp_path: Path) -> None:
    """Hulls of plausible volume, but longer than the terrain's 200 m, or taller than the water is deep."""
    shallow = {"source": "noise", "size_m": [200, 200], "spacing_m": 2, "bed_depth_m": 30}
    for size_m, rule in (
        ((300.0, 2.0, 2.0), "hull of 300 x 2 x 2 m must be shorter than the terrain, 200 x 200 m: is its mesh in"),
        ((60.0, 40.0, 35.0), "must have room in the water, which is 30 m deep at most: is its mesh in"),
        ((60.0, 40.0, 25.0), ""),
    ):
        model = vehicle_file(tmp_path, size_m=size_m)
        mistakes = check_file(scenario_file(tmp_path, model, terrain=shallow)).mistakes
        assert (len(mistakes) == 1 and rule in mistakes[0]) if rule else mistakes == ()


@pytest.mark.parametrize(("mass_kg", "sound"), [(66, False), (68, True), (6710, True), (6730, False)])
def test_a_mean_density_is_between_100_and_10000_kg_m3(mass_kg: float, sound: bool, tmp_path: Path) -> None:
    """The hull displaces 0.672 m3."""
    told = refusals(tmp_path, mass_kg=mass_kg, without=("buoyancy",))
    assert (told == []) is sound, told
    assert all("must be in [100, 10000] kg/m3" in message for message in told)


def test_ballast_counts(tmp_path: Path) -> None:
    assert refusals(tmp_path, mass_kg=672.0, ballast_kg=6000.0, without=("buoyancy",)) == []
    told = refusals(tmp_path, mass_kg=672.0, ballast_kg=6100.0, without=("buoyancy",))
    assert told and all("mass, trim and ballast of 6772 kg" in message for message in told)


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e400"])
@pytest.mark.parametrize("kind", ["obj", "stl", "ply", "off"])
def test_a_vertex_that_is_no_number_is_refused(kind: str, value: str, tmp_path: Path) -> None:
    path = tmp_path / f"hull.{kind}"
    mesh = trimesh.creation.box((1.25, 0.75, 0.75))
    text = trimesh.exchange.stl.export_stl_ascii(mesh) if kind == "stl" else ""
    if kind != "stl":
        mesh.export(path, **({"encoding": "ascii"} if kind == "ply" else {}))
        text = path.read_text()
    before = next(word for word in text.split() if word.startswith("-0.625"))
    path.write_text(text.replace(before, value, 1))
    with pytest.raises(ScenarioError, match=r"not finite|not a readable"):
        load_mesh(path)


def test_an_obstacle_in_millimetres_is_refused_and_a_ship_is_not(tmp_path: Path) -> None:
    def told(size_m: tuple[float, float, float], scale: float) -> str:
        mesh = box_mesh(tmp_path / "obstacle.obj", size_m, scale)
        beside = [scale * size_m[0] / 2 + 5, 0, -30]
        obstacle = {"kind": "mesh", "name": "thing", "file": str(mesh), "position_m": beside}
        report = check_file(scenario_file(tmp_path, vehicle_file(tmp_path), obstacles=[obstacle]))
        return "\n".join((*report.mistakes, *report.warnings))

    assert "is it in millimetres? scale: 0.001" in told((3.0, 2.0, 1.0), 1e3)
    assert "200 x 200 m: is its mesh in metres?" in told((4.0, 2.0, 1.0), 1e2)
    assert "is only 0.003 x 0.002 x 0.001 m: is its mesh in metres?" in told((3.0, 2.0, 1.0), 1e-3)
    assert "metres" not in told((90.0, 20.0, 20.0), 1.0)
    pool = yaml.safe_load(new_scenario("mine", tmp_path / "mine.yaml", "pool").read_text())
    mesh = box_mesh(tmp_path / "ship.obj", (300.0, 40.0, 20.0))
    pool["obstacles"] = [{"kind": "mesh", "name": "ship", "file": str(mesh), "position_m": [160, 0, 8]}]
    (tmp_path / "harbour.yaml").write_text(yaml.safe_dump(pool))
    assert check_file(tmp_path / "harbour.yaml").mistakes == ()


def test_a_box_and_a_terrain_in_millimetres_are_warned_of(tmp_path: Path) -> None:
    box = {"kind": "box", "name": "thing", "size_m": [3000, 2, 1], "position_m": [0, 50, -30]}
    told = "\n".join(check_file(scenario_file(tmp_path, vehicle_file(tmp_path), obstacles=[box])).warnings)
    assert "is 3000 x 2 x 1 m, in a terrain of 200 x 200 m: are its sizes in metres?" in told

    def of_bed(heights: str) -> str:
        grid = "ncols 4\nnrows 4\nxllcorner 1000\nyllcorner 1000\ncellsize 100\n" + heights
        (tmp_path / "bed.asc").write_text(grid)
        terrain = {"source": "raster", "file": "bed.asc", "water_level_m": 0, "spacing_m": 2, "crs": "local"}
        report = check_file(scenario_file(tmp_path, vehicle_file(tmp_path), terrain=terrain))
        return "\n".join((*report.mistakes, *report.warnings))

    assert of_bed("-30 -31 -32 -33\n" * 4) == ""
    assert "its heights differ by" in of_bed("-3000 -3100 -3200 -4300\n" * 4)
    assert "must be within 12000 m of the water" in of_bed("-30000 -31000 -32000 -33000\n" * 4)


def test_collision_pieces_in_another_unit_than_the_mesh_are_refused(tmp_path: Path) -> None:
    box_mesh(tmp_path / "pieces.obj", scale=1e3)
    told = refusals(tmp_path, collision="pieces", collision_pieces="pieces.obj")
    assert len(told) == 3 and all("must be those of the hull of 1.2 x 0.8 x 0.7 m" in message for message in told)
    box_mesh(tmp_path / "pieces.obj")
    assert refusals(tmp_path, collision="pieces", collision_pieces="pieces.obj") == []


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    scenario = scenario_file(tmp_path, vehicle_file(tmp_path, scale=1e3))
    for arguments in (["scenario", "check", str(scenario)], ["scenario", "sonar", str(scenario), "--out", "out.png"]):
        done = uwsim(*arguments, cwd=tmp_path)
        assert done.returncode == 1
        assert "is its mesh in millimetres" in error_line(done)
    assert not (tmp_path / "out.png").exists()


def test_what_is_large_by_nature_is_accepted(tmp_path: Path) -> None:
    """A submarine of 170 m and 20,000 t in a 200 m terrain; the simulator can step it."""
    model = vehicle_file(tmp_path, size_m=(170.0, 12.0, 10.0))
    report = check_file(scenario_file(tmp_path, model))
    assert report.mistakes == ()
    assert report.scene is not None and np.isfinite(report.scene.vehicles[0].altitude_m)
    with Simulator(scenario_file(tmp_path, model)) as sim:
        sim.step(3)
