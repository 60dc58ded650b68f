"""A scenario written for Gazebo and for Stonefish is the same world and vehicle when it is read back."""

import io
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest

from uwsim.base.options import OptionError
from uwsim.evidence.export.from_scenario import exported
from uwsim.evidence.export.write import write_export
from uwsim.evidence.robots.sdf import read_sdf
from uwsim.evidence.robots.stonefish import read_stonefish
from uwsim.operator.station.editor import Editor
from uwsim.scenario import load
from uwsim.scenario.read.assets import find_yaml

WORLD = """\
name: bay
terrain: {{source: noise, size_m: [40, 60], spacing_m: 1, bed_depth_m: 15}}
water: {{density_kg_m3: 1025, current_world_m_s: [0.1, 0.2, 0]}}
wind: {{speed_m_s: 4}}
obstacles:
  - {{kind: cylinder, name: post, position_m: [5, 2, -6], radius_m: 1, length_m: 3, yaw_pitch_roll_deg: [20, 30, 0]}}
vehicles:
  - {{name: one, model: {0}, start: {{position_m: [1, 2, -3], yaw_deg: 40}}}}
"""
READERS = {"sdf": read_sdf, "scn": read_stonefish}


def written(tmp_path, vehicle, suffix):
    """Return a scenario as it is, as it is read back, and the notes of its export."""
    path = tmp_path / "bay.yaml"
    path.write_text(WORLD.format(vehicle))
    notes = write_export(str(path), tmp_path / f"bay.{suffix}")
    return exported(load(path)), READERS[suffix](tmp_path / f"bay.{suffix}"), notes


@pytest.mark.parametrize("suffix", READERS)
@pytest.mark.parametrize("vehicle", ["bluerov2_heavy", "lauv", "bluerov2_heavy_alpha5"])
def test_what_is_written_reads_back_as_the_same_vehicle_in_the_same_world(tmp_path, vehicle, suffix):
    own, back, notes = written(tmp_path, vehicle, suffix)
    mine, robot = own.found.robots[0], back.robots[0]
    np.testing.assert_allclose(robot.place.position_m, [1, 2, -3], atol=1e-6)
    np.testing.assert_allclose(robot.place.turn, mine.place.turn, atol=1e-6)
    whole, other = mine.whole(), robot.whole()
    assert other.mass_kg == pytest.approx(whole.mass_kg)
    np.testing.assert_allclose(other.centre_m, whole.centre_m, atol=1e-6)
    moments = np.diagonal(whole.inertia_kg_m2)
    np.testing.assert_allclose(np.diagonal(other.inertia_kg_m2), moments, rtol=1e-4)
    assert robot.volume_m3 == pytest.approx(mine.volume_m3, rel=1e-5)
    np.testing.assert_allclose(robot.centre_of_buoyancy_m, mine.centre_of_buoyancy_m, atol=1e-5)
    if suffix == "sdf":
        for key in ("added_mass", "linear", "quadratic"):
            np.testing.assert_allclose(getattr(robot, key), getattr(mine, key), rtol=1e-8)
    else:
        for found, matrix in zip(robot.drag(np.zeros(3)), (mine.linear, mine.quadratic), strict=True):
            np.testing.assert_allclose(found[:3], np.diagonal(matrix)[:3], rtol=1e-4, atol=1e-3)
    assert [each.name for each in robot.thrusters] == [each.name for each in mine.thrusters]
    for found, stated in zip(robot.thrusters, mine.thrusters, strict=True):
        np.testing.assert_allclose(found.position_m, stated.position_m, atol=1e-6)
        np.testing.assert_allclose(found.axis, stated.axis, atol=1e-6)
        assert found.clockwise == stated.clockwise
        at = np.linspace(-1, 1, 2 if suffix == "sdf" else 31)  # between its ends, SDF states none
        np.testing.assert_allclose(
            *(np.interp(at, *np.array(sorted(each.thrust_n)).T) for each in (found, stated)), atol=1e-6
        )
    assert back.density_kg_m3 == 1025
    np.testing.assert_allclose(back.current_m_s, [0.1, 0.2, 0], atol=1e-9)
    for name in ("bed", "post"):
        for edge in (np.min, np.max):
            np.testing.assert_allclose(edge(back.meshes[name][0], axis=0), edge(own.found.meshes[name][0], axis=0),
                                       atol=1e-4)  # fmt: skip
    assert "left out: wind" in notes and "left out: vehicle 'one': control" in notes


@pytest.mark.parametrize("suffix", READERS)
def test_a_camera_and_the_multibeam_look_the_same_way(tmp_path, suffix):
    (tmp_path / "own.yaml").write_text(
        "builds_on: bluerov2_heavy\nname: own\ncameras:\n  bow: {position_m: [0.2, 0.1, -0.05], "
        "yaw_pitch_roll_deg: [30, 20, 10], width: 320, height: 240, field_of_view_deg: 70}\n"
    )
    _, back, _ = written(tmp_path, "own.yaml", suffix)
    camera, sonar = back.robots[0].cameras["bow"], back.robots[0].sonar
    np.testing.assert_allclose(camera["position_m"], [0.2, 0.1, -0.05], atol=1e-6)
    np.testing.assert_allclose(camera["yaw_pitch_roll_deg"], [30, 20, 10], atol=1e-3)
    assert (camera["width"], camera["height"]) == (320, 240) and camera["field_of_view_deg"] == pytest.approx(70)
    np.testing.assert_allclose(sonar, [0.24, 0, -0.06], atol=1e-6)


@pytest.mark.parametrize("suffix", READERS)
def test_a_body_with_a_name_that_scenarios_reserve_is_read_under_another(tmp_path, suffix):
    written(tmp_path, "bluerov2_heavy", suffix)
    path = tmp_path / f"bay.{suffix}"
    path.write_text(path.read_text().replace('name="post"', 'name="terrain"'))
    assert [each["name"] for each in READERS[suffix](path).obstacles] == ["bed", "terrain_2"]


def test_libsdformat_reads_it(tmp_path):
    drake = pytest.importorskip("pydrake.all", reason="pip install drake, which reads SDF by libsdformat")
    own, _, _ = written(tmp_path, "bluerov2_heavy", "sdf")
    plant, _ = drake.AddMultibodyPlantSceneGraph(drake.DiagramBuilder(), 0.001)
    names = [plant.GetModelInstanceName(model) for model in drake.Parser(plant).AddModels(str(tmp_path / "bay.sdf"))]
    plant.Finalize()
    assert names == ["bed", "post", "one"]
    bodies = [plant.get_body(each) for each in plant.GetBodyIndices(plant.GetModelInstanceByName("one"))]
    mass = sum(body.default_mass() for body in bodies)
    assert len(bodies) == 9 and mass == pytest.approx(own.found.robots[0].whole().mass_kg)


def test_nothing_of_others_is_replaced_and_the_format_is_that_of_the_suffix(tmp_path):
    (tmp_path / "bay.sdf").write_text("mine")
    with pytest.raises(OSError, match=r"bay\.sdf"):
        write_export("pool", tmp_path / "bay.sdf")
    assert [each.name for each in tmp_path.iterdir()] == ["bay.sdf"]
    with pytest.raises(OptionError, match=r"must end in \.sdf"):
        write_export("pool", Path("pool.urdf"))


@pytest.mark.parametrize("suffix", READERS)
def test_the_scene_editor_exports_the_files_of_the_command_with_a_list_of_all_left_out(tmp_path, suffix):
    write_export("pool", tmp_path / f"pool.{suffix}")
    editor = Editor(tmp_path, None)
    editor.open("anna", "pool", find_yaml("pool", "scenarios"), is_of_same=False)
    made = editor.export(suffix)
    name = made["file"].removeprefix(f"{editor.address}/export/")
    with ZipFile(io.BytesIO(editor.archive(name))) as archive:
        files = {each: archive.read(each) for each in archive.namelist()}
    assert files == {each: (tmp_path / each).read_bytes() for each in files}
    assert f"pool_{suffix}/bed.obj" in files and any("survey" in note for note in made["notes"])
    editor.export(next(each for each in READERS if each != suffix))
    with pytest.raises(ValueError, match="is no more: export it again"):
        editor.archive(name)
    with pytest.raises(ValueError, match=r"must end in \.sdf, for Gazebo or \.scn, for Stonefish"):
        editor.export("urdf")
