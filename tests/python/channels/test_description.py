"""/robot_description is the vehicle: parsers that others wrote find its frames, joints, mass and hull in it."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from all_stop_world import DRIVES, scenario
from channel_tools import chain, table
from uwsim import Simulator
from uwsim.base import quaternions
from uwsim.bridges.ros_packages.description import described
from uwsim.bridges.rosbridge.parameters import Parameters
from uwsim.channels import Table
from uwsim.channels.families.description import descriptions, mesh_file
from uwsim.recording import Recorder
from uwsim.recording.replay import replay
from uwsim.scenario import load, vehicle_hull

TRIMMED = "  - {name: trimmed, model: bluerov2_heavy, start: {position_m: [0, 9, -5]}, trim: {net_buoyancy_n: 2}}\n"


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[Simulator]:
    path = scenario(tmp_path)
    path.write_text(path.read_text() + TRIMMED + "water: {density_kg_m3: 1000}\n")
    with Simulator(path) as sim:
        yield sim


def parsed(text: str) -> Any:
    return pytest.importorskip("urdf_parser_py.urdf").URDF.from_xml_string(text.encode())


def placed(origin: Any) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_euler("xyz", origin.rpy).as_matrix(), origin.xyz
    return pose


def test_frames_and_joints_are_those_of_tf(sim: Simulator) -> None:
    sim.vehicles["forces"].cameras["front"].aim(0.3, -0.4)
    sim.vehicles["forces"].sonar.aim(0.2)
    sim.vehicles["fins"].release()
    sim.vehicles["fins"].set_fins({"top": 0.1, "port": -0.2})
    sim.advance(2.0)
    found, turning = table(sim, joint_frames=True), set()
    everything = {t.child_frame_id for name in ("tf", "tf_static") for t in found[name].read(sim).transforms}
    for name in DRIVES:
        robot, base = parsed(found[f"{name}/robot_description"].read(sim).data), f"{name}/base_link"
        state = found[f"{name}/joint_states"].read(sim)
        angles = dict(zip(state.name, state.position.tolist(), strict=True))
        assert angles.keys() <= robot.joint_map.keys() and robot.get_root() == base
        about_it = {f"{name}/odom", f"{name}/base_footprint", f"{name}/chase_optical"}
        assert robot.link_map.keys() == {one for one in everything if one.startswith(f"{name}/")} - about_it
        for frame in robot.link_map:
            pose = np.eye(4)
            for joint in (robot.joint_map[one] for one in robot.get_chain(base, frame, links=False)):
                turn = np.eye(4)
                if joint.type == "revolute":
                    turning.add(joint.name)
                    assert joint.limit.lower <= angles[joint.name] <= joint.limit.upper
                    turn[:3, :3] = Rotation.from_rotvec(np.multiply(angles[joint.name], joint.axis)).as_matrix()
                pose = pose @ placed(joint.origin) @ turn
            np.testing.assert_allclose(pose, chain(sim, found, frame, base), atol=1e-12, err_msg=frame)
    axis = sim.scenario.vehicles[0].model.thrusters["rear_left"].axis
    ahead = chain(sim, found, "thrusters/rear_left_thruster_link", "thrusters/base_link")[:3, 0]
    np.testing.assert_allclose(ahead, axis / np.linalg.norm(axis), atol=1e-12)
    assert {"fins/top", "forces/front_tilt"} <= turning


def test_mass_is_that_of_the_trimmed_vehicle_and_follows_the_parameters(sim: Simulator) -> None:
    channel = table(sim)["trimmed/robot_description"]
    first = channel.read(sim)
    base = parsed(first.data).link_map["trimmed/base_link"].inertial
    assert base.mass == pytest.approx(1000.0 * 0.0134 - 2.0 / 9.80665, rel=1e-5)
    np.testing.assert_allclose([base.inertia.ixx, base.inertia.iyy, base.inertia.izz], [0.26, 0.23, 0.37], atol=1e-9)
    assert channel.read(sim) is first, "the same sample is sent once"
    sim.parameters["trimmed.ballast_kg"] = 1.5
    heavier = parsed(channel.read(sim).data).link_map["trimmed/base_link"].inertial
    assert heavier.mass == pytest.approx(base.mass + 1.5)


@pytest.mark.parametrize("name", ["paper", "pair"])
def test_the_mesh_lies_where_the_simulated_hull_is(name: str) -> None:
    """paper: a glTF file, whose y axis points up; pair: two OBJ files, of which one is scaled to its volume."""
    with Simulator(name) as sim:
        texts = descriptions(Table(sim).channels, sim)
    for entry, text in zip(sim.scenario.vehicles, texts.values(), strict=True):
        links, (hull, _) = parsed(text).link_map, vehicle_hull(entry.model)
        visual = next(iter(links.values())).visuals[0]
        mesh = trimesh.load(visual.geometry.filename.removeprefix("file://"), force="mesh")
        vertices = trimesh.transform_points(mesh.vertices * visual.geometry.scale, placed(visual.origin))
        np.testing.assert_allclose([vertices.min(0), vertices.max(0)], [hull.min(0), hull.max(0)], atol=1e-6)


@pytest.mark.parametrize("name", ["paper", "lake"])
def test_a_bow_along_another_axis_is_turned_forward(name: str) -> None:
    """paper: a glTF file, whose y axis points up."""
    given = load(name).vehicles[0].model.model_copy(update={"centre_of_buoyancy_m": None})
    as_given, _ = vehicle_hull(given)
    for forward, bow in {"-x": [-1.0, 0.0], "y": [0.0, 1.0], "-y": [0.0, -1.0]}.items():
        turned = given.model_copy(update={"mesh_forward": forward})
        hull, _ = vehicle_hull(turned)
        np.testing.assert_allclose(hull[:, 0], as_given[:, :2] @ bow, atol=1e-12)
        np.testing.assert_array_equal(hull[:, 2], as_given[:, 2])
        mesh = mesh_file(turned)
        in_file = np.asarray(trimesh.load(mesh.uri.removeprefix("file://"), force="mesh").vertices) * mesh.scale
        placed_m = quaternions.turned(mesh.orientation_xyzw, in_file) + mesh.position_m
        np.testing.assert_allclose([placed_m.min(0), placed_m.max(0)], [hull.min(0), hull.max(0)], atol=1e-6)


def test_the_packages_files_have_the_hull_and_are_read_by_urdfdom(tmp_path: Path) -> None:
    files = described("pair", "uwsim_description")
    hull, triangles = vehicle_hull(load("pair").vehicles[0].model)
    mesh = trimesh.load(trimesh.util.wrap_as_stream(files["meshes/rov.obj"]), file_type="obj", process=False)
    assert len(mesh.faces) == len(triangles)
    np.testing.assert_allclose(mesh.bounds, [hull.min(0), hull.max(0)], atol=1e-6)
    assert 'filename="package://uwsim_description/meshes/rov.obj"' in files["urdf/rov.urdf"]
    check = shutil.which("check_urdf")
    if check is None:
        pytest.skip("check_urdf, of Debian's liburdfdom-tools, is not installed")
    for path in ("urdf/rov.urdf", "urdf/scout.urdf"):
        (tmp_path / "one.urdf").write_text(files[path])
        result = subprocess.run([check, tmp_path / "one.urdf"], capture_output=True, text=True, env=os.environ)
        assert result.returncode == 0 and "Successfully Parsed" in result.stdout and not result.stderr


def test_clients_of_rosapi_read_it_as_a_parameter_and_may_replace_it(sim: Simulator) -> None:
    parameters = Parameters({}, described=lambda: descriptions(Table(sim).channels, sim))
    name = "fins/robot_description"
    assert name in parameters.names() and parameters.has(name)
    assert '<robot name=\\"fins\\">' in parameters.get_json(name)
    parameters.set_json(name, '"mine"')
    assert parameters.get_json(name) == '"mine"'


def test_a_recording_at_the_rate_of_the_imu_replays(tmp_path: Path) -> None:
    path = tmp_path / "fast.mcap"
    with Simulator("pool") as sim:
        shared = Table(sim, tf_rate_hz=200.0, joint_frames=True)
        with Recorder(sim, path, topics=["tf", "tf_static"], shared=shared):
            sim.advance(0.25)
    result = replay(path)
    assert result.difference is None and result.messages["tf"] == 51
    with pytest.raises(ValueError, match="tf_rate_hz = 201 Hz: must be in"):
        Table(sim, tf_rate_hz=201.0)
