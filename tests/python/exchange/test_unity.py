"""`uwsim scenario from`: a small Unity project of our own becomes a scenario; what is left out is named."""

import csv
import hashlib
import json
import os
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import error_line
from command_line import uwsim as command
from fbx_file import write_blender_fbx
from uwsim.evidence.reproduce import scenes
from uwsim.evidence.reproduce.beside import reproduce_beside
from uwsim.evidence.reproduce.deposit import write_deposit
from uwsim.evidence.reproduce.number import Number
from uwsim.evidence.reproduce.paper import Subject
from uwsim.evidence.reproduce.their_world import START_SCREEN, TheirWorld, inputs, their_world
from uwsim.exchange.unity.project import Project
from uwsim.exchange.unity.scenario import scenario_from
from uwsim.exchange.unity.scene import _number, read_scene
from uwsim.scenario import load
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.note import Note
from uwsim.scenario.read.textures import triangle_means
from uwsim.scenario.spec.camera import CameraMount
from uwsim.simulator.simulator import Simulator

pytest.importorskip("xxhash", reason="the extra unity")
GUID = "0123456789abcdef0123456789abcdef"
CHECKOUTS = "UWSIM_CHECKOUTS"
PAIR = Path(__file__).parents[1] / "data" / "pair.fbx"
"""Two nodes, Left and Right, at x = 10 and 20 m, each a tetrahedron with edges of 1, 2 and 3 m."""


def thing(number: int, name: str, mesh: str, position: str, *, more: str = "", scale: str = "1, y: 1, z: 1",
          on: int = 1, active: int = 1, turn: str = "0, y: 0, z: 0, w: 1") -> str:  # fmt: skip
    """An object with a mesh, as Unity writes it."""
    return f"""--- !u!1 &{number}
GameObject:
  m_Component:
  - 4: {{fileID: {number + 1}}}
  - component: {{fileID: {number + 2}}}
  m_Name: {name}
  m_IsActive: {active}
--- !u!4 &{number + 1}
Transform:
  m_GameObject: {{fileID: {number}}}
  m_LocalRotation: {{x: {turn}}}
  m_LocalPosition: {{x: {position}}}
  m_LocalScale: {{x: {scale}}}
  m_Children: []
  m_Father: {{fileID: 0}}
--- !u!33 &{number + 2}
MeshFilter:
  m_GameObject: {{fileID: {number}}}
  m_Mesh: {{{mesh}}}
--- !u!23 &{number + 3}
MeshRenderer:
  m_GameObject: {{fileID: {number}}}
  m_Enabled: {on}
{more}"""


CUBE, PLANE = (f"fileID: {number}, guid: 0000000000000000e000000000000000, type: 0" for number in (10202, 10209))
BODY = "--- !u!54 &204\nRigidbody:\n  m_GameObject: {fileID: 200}\n  m_Mass: 47000\n"
INSTANCE = f"""--- !u!1001 &900
PrefabInstance:
  m_Modification:
    m_TransformParent: {{fileID: 0}}
    m_Modifications:
    - {{target: {{fileID: 7, guid: {GUID}, type: 3}}, propertyPath: m_RootOrder, value: 0}}
    - {{target: {{fileID: 7, guid: {GUID}, type: 3}}, propertyPath: m_LocalPosition.y, value: 70}}
    - {{target: {{fileID: 8, guid: {GUID}, type: 3}}, propertyPath: m_Name, value: Pair}}
  m_SourcePrefab: {{fileID: 100100000, guid: {GUID}, type: 3}}
"""


@pytest.fixture
def project(tmp_path: Path, panels_left_out: None) -> Path:
    folder = tmp_path / "checkout"
    (folder / "Assets").mkdir(parents=True)
    shutil.copy(PAIR, folder / "Assets" / "Pair.fbx")
    (folder / "Assets" / "Pair.fbx.meta").write_text(f"fileFormatVersion: 2\nguid: {GUID}\n")
    right = f"fileID: {_number('Right')}, guid: {GUID}, type: 3"
    (folder / "Assets" / "LawnTest.unity").write_text(
        "%YAML 1.1\n%TAG !u! tag:unity3d.com,2011:\n"
        + thing(100, "SolidTerrain", PLANE, "0, y: 55.3, z: 0", scale="40, y: 1, z: 40")
        + thing(200, "ROV", CUBE, "0, y: 70, z: 0", scale="3, y: 1, z: 2", more=BODY)
        + thing(300, "Waterbox", CUBE, "0, y: 70, z: 0")
        + thing(
            400, "Turned", right, "20, y: 70.3, z: 130", turn="0, y: 0.7071067811865476, z: 0, w: 0.7071067811865476"
        )
        + thing(500, "Dark", CUBE, "0, y: 70, z: 0", on=0)
        + thing(600, "Away", CUBE, "0, y: 70, z: 0", active=0)
        + thing(700, "Lost", f"fileID: 1, guid: {GUID[::-1]}, type: 3", "0, y: 70, z: 0")
        + INSTANCE
    )
    return folder


def test_meshes_are_where_unity_shows_them(project: Path) -> None:
    scene = read_scene(Project(project), project / "Assets" / "LawnTest.unity")
    pieces = {piece.path: [] for piece in scene.pieces}
    for piece in scene.pieces:
        pieces[piece.path].append(piece)
    (turned,) = pieces[("Turned",)]
    # A file's x points to Unity's -x; a quarter turn about y, clockwise from above, takes x to -z and z to x.
    wanted = np.add([[0, 0, 0], [0, 0, 1], [0, 2, 0], [3, 0, 0]], (20.0, 70.3, 130.0))
    assert sorted(map(tuple, turned.vertices.round(6))) == sorted(map(tuple, wanted.round(6)))
    left, right = pieces[("Pair",)]  # an instance of the model: its nodes 10 and 20 m from its root
    assert left.vertices[:, 0].max() == pytest.approx(-10.0) and right.vertices[:, 0].max() == pytest.approx(-20.0)
    assert left.vertices[:, 1].min() == pytest.approx(70.0)
    for piece in (turned, left):  # outward in a right-handed frame
        a, b, c = (piece.vertices * (-1.0, 1.0, 1.0))[piece.triangles].transpose(1, 0, 2)
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(1.0)
    lost = "left out: Lost: its file is not in the checkout"
    assert sorted(map(str, scene.left_out)) == ["left out: Away: inactive", "left out: Dark: its renderer is off", lost]
    scene.drop(("Found", "Later"), "its file is not in the checkout")
    assert lost.replace("Lost", "Lost and 1 more") in map(str, scene.left_out)


def test_the_identifier_of_a_mesh_is_unity_s() -> None:
    assert _number("Landscape_plane") == 7836155707338945327  # in the published scene, of a mesh with this name


def test_the_scenario_can_be_flown_and_says_what_it_lacks(project: Path, tmp_path: Path) -> None:
    done = command("scenario", "from", project, "--out", tmp_path / "lake")
    assert done.returncode == 0, done.stderr
    for name in ("Dark: its renderer is off", "Waterbox: the water", "ControlStation: the scene has none"):
        assert f"left out: {name}" in done.stdout
    (tmp_path / "lake").rename(tmp_path / "moved")  # the folder is complete
    sim = uwsim.Simulator(tmp_path / "moved" / "lawntest.yaml")
    assert sim.world.height_at(np.array([[30.0, -120.0]])) == pytest.approx([-20.0], abs=1e-3)
    tip = np.array([[-20.0 - 2.9, -130.02, -4.95]])  # of `Turned`, whose long edge points west
    assert sim.scene.distance_m(tip) == pytest.approx([0.0], abs=0.1)
    hull = sim.scenario.vehicles[0].model
    assert hull.buoyancy == "neutral" or hull.mass_kg == pytest.approx(6.0 * 998.0, rel=0.01)  # a block of 3 x 2 x 1 m


@pytest.mark.parametrize("depth_m, across", [(20.0, 6), (20.0, 0.4), (1.5, 20)])
def test_a_bed_that_does_not_reach_the_paper_s_start_has_its_own(
    depth_m: float, across: float, project: Path, tmp_path: Path
) -> None:
    changed("y: 55.3", f"y: {75.3 - depth_m}")(project)
    changed("x: 40, y: 1, z: 40", f"x: {across}, y: 1, z: {across}")(project)
    done = command("scenario", "from", project, "--out", tmp_path / "lake")
    assert done.returncode == 0 and done.stdout.count("assumed: the vehicle starts at (") == 1, done.stderr
    sim = uwsim.Simulator(tmp_path / "lake/lawntest.yaml")
    x, y, z = sim.rov.pose.position_world_m
    assert sim.world.height_at(np.array([[x, y]])) == pytest.approx([-depth_m], abs=1e-3)
    assert -depth_m < z < 0.0
    assert (sim.scenario.survey is None) == (across == 0.4)  # of a pond 4 m wide


def hill_m(x, y):
    """The height of hills that fall to the north-east."""
    return 6.0 * np.cos(x / 15.0) * np.cos(y / 25.0) - 0.02 * x - 0.03 * y


@pytest.mark.parametrize("is_instance", [False, True], ids=["of an object", "an instance of the file"])
def test_hills_from_blender_are_the_bed(is_instance: bool, project: Path, tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(-150.0, 151.0, 2.0), np.arange(-180.0, 181.0, 2.0))
    number = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    points_m = np.column_stack([x.ravel(), y.ravel(), hill_m(x, y).ravel()])
    write_blender_fbx(project / "Assets" / "Hills.fbx", "Hills", points_m, quads)
    guid = "d" * 32
    (project / "Assets" / "Hills.fbx.meta").write_text(f"guid: {guid}\n")
    lawn = thing(100, "SolidTerrain", PLANE, "0, y: 55.3, z: 0", scale="40, y: 1, z: 40")
    hills = INSTANCE.replace("900", "950").replace(GUID, guid).replace("value: 70", "value: 45.3")
    hills = hills.replace("value: Pair", "value: SolidTerrain")
    if not is_instance:  # Unity keeps the node's turn and scale in the object
        half = np.sqrt(0.5)
        hills = thing(
            100, "SolidTerrain", f"fileID: {_number('Hills')}, guid: {guid}, type: 3", "0, y: 45.3, z: 0",
            scale="100, y: 100, z: 100", turn=f"{-half}, y: 0, z: 0, w: {half}",
        )  # fmt: skip
    changed(lawn, hills)(project)
    made = scenario_from(Project(project), project / "Assets/LawnTest.unity", tmp_path / "lake")
    places = np.array([[0.0, 0.0], [31.0, -22.0], [-44.0, 17.0], [12.5, 41.0], [-55.0, -45.0]])
    heights = uwsim.Simulator(made.path).world.height_at(places)
    # Blender's x and y are east and north; between points 2 m apart, the hills bend by 0.05 m at most.
    np.testing.assert_allclose(heights, hill_m(*places.T) - 30.0, atol=0.06)


ORANGE, TEAL = (1.0, 0.5, 0.0), (0.0, 0.5, 0.5)
CORNERS_M = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)])
SIDES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]], np.int32)
MATERIAL = """%YAML 1.1
--- !u!21 &2100000
Material:
  m_Name: Teal
  m_SavedProperties:
    m_TexEnvs:
    - _MainTex:
        m_Texture: {fileID: 0}
    m_Colors:
    - _Color: {r: 0, g: 0.5, b: 0.5, a: 1}
"""


def shade(colour):
    """Return an sRGB colour's share of each band in light, which no shading changes."""
    linear = np.array(colour) ** 2.2
    return linear / linear.sum()


@pytest.mark.parametrize("sides", [SIDES, SIDES[1:]], ids=["closed", "open below"])
def test_colours_of_models_and_materials_are_kept(sides, project: Path, tmp_path: Path) -> None:
    write_blender_fbx(project / "Assets" / "Block.fbx", "Block", CORNERS_M, sides, ORANGE)
    block, teal = "b" * 32, "c" * 32
    (project / "Assets" / "Block.fbx.meta").write_text(f"guid: {block}\n")
    (project / "Assets" / "Teal.mat").write_text(MATERIAL)
    (project / "Assets" / "Teal.mat.meta").write_text(f"guid: {teal}\n")
    vehicle = f"fileID: {_number('Block')}, guid: {block}, type: 3"
    rov = thing(200, "ROV", CUBE, "0, y: 70, z: 0", scale="3, y: 1, z: 2", more=BODY)
    changed(rov, thing(200, "ROV", vehicle, "0, y: 70, z: 0", scale="300, y: 100, z: 200", more=BODY))(project)
    painted = f"  m_Enabled: 1\n  m_Materials:\n  - {{fileID: 2100000, guid: {teal}, type: 2}}\n--- !u!1 &500"
    changed("  m_Enabled: 1\n--- !u!1 &500", painted)(project)
    made = scenario_from(Project(project), project / "Assets/LawnTest.unity", tmp_path / "lake")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it closes the open block
        sim = uwsim.Simulator(made.path)
    textures = {each.name: each.texture() for each in sim.scenario.obstacles}
    assert triangle_means(textures["turned"]) == pytest.approx(np.tile(np.array(TEAL) ** 2.2, (4, 1)), abs=0.02)
    assert textures["pair"] is None  # a file without colours
    sim.rov.place([0.0, 0.0, 6.0])
    station = np.array(sim.scenario.station.position_m)
    mount = CameraMount(position_m=tuple(np.array([-8.0, 0.0, 8.0]) - station), yaw_pitch_roll_deg=(0, 14, 0))
    frame = Simulator(scenes.with_cameras(sim.scenario, near=mount))
    frame.rov.place([0.0, 0.0, 6.0])
    seen = frame.cameras["near"].capture("off")
    pixels = seen.rgb[seen.labels == seen.label_names.index("rov")]
    assert len(pixels) > 500
    assert shade(pixels.mean(axis=0) / 255.0) == pytest.approx(shade(ORANGE), abs=0.05)


def test_a_bed_too_wide_is_cut_to_the_size_given(project: Path, tmp_path: Path) -> None:
    changed("x: 40, y: 1, z: 40", "x: 400, y: 1, z: 400")(project)  # 4 km wide
    scene = project / "Assets/LawnTest.unity"
    with pytest.raises(ValueError, match="4000 m wide: must be at most 2000 m; --size makes a part of it the bed"):
        scenario_from(Project(project), scene, tmp_path / "lake")
    with pytest.raises(ValueError, match="--size = 3000 m: must be at most 2000 m"):
        scenario_from(Project(project), scene, tmp_path / "lake", size_m=3000.0)
    assert not (tmp_path / "lake").exists()
    done = command("scenario", "from", project, "--size", 100, "--out", tmp_path / "lake")
    assert done.returncode == 0 and "left out: Turned: it lies beyond --size = 100 m" in done.stdout, done.stderr
    sim = uwsim.Simulator(tmp_path / "lake/lawntest.yaml")
    west, south, east, north = sim.world.terrain_extent_m
    assert (east - west, north - south) == pytest.approx((100.0, 100.0), abs=1.0)
    assert max(map(abs, (west, south, east, north))) <= 50.0
    there = ("--size", 100, "--centre", -20, -120)  # Turned stands at x = -20, y = -130 m
    done = command("scenario", "from", project, *there, "--out", tmp_path / "moved")
    assert done.returncode == 0 and "left out: Pair: it lies beyond --size = 100 m" in done.stdout, done.stderr
    moved = uwsim.Simulator(tmp_path / "moved/lawntest.yaml")
    (turned,) = (each for each in moved.scenario.obstacles if each.name == "turned")
    whole = scenario_from(Project(project), scene, tmp_path / "whole", size_m=400.0)
    (before,) = (each for each in uwsim.Simulator(whole.path).scenario.obstacles if each.name == "turned")
    shift = load_mesh(before.file)[0] - load_mesh(turned.file)[0]
    assert shift == pytest.approx(np.tile([-20.0, -120.0, 0.0], (len(shift), 1)), abs=1e-4)


def changed(old: str, new: str):
    def change(folder: Path) -> None:
        scene = folder / "Assets/LawnTest.unity"
        scene.write_text(scene.read_text().replace(old, new))

    return change


GATE = {"turn": "0, y: 0.3826834, z: 0, w: 0.9238795", "scale": "12, y: 12, z: 0.5"}


def test_the_paper_s_figures_have_a_place_in_a_project_that_has_a_gate(project: Path, tmp_path: Path) -> None:
    """A gate where that of `paper` is, 45 degrees to starboard of Unity's z; the start screen loses 0.1 % a second."""
    gate = thing(800, "Gate (3)", CUBE, "-38.98, y: 61.61, z: 146.9", **GATE)
    lawn = project / "Assets/LawnTest.unity"
    lawn.write_text(lawn.read_text() + gate)
    (project / "Assets/Scripts").mkdir()
    (project / START_SCREEN).write_text("batteryTime=0.1f;")
    world = their_world(project, tmp_path / "scenario", {})
    assert world.missing_m["gate_1"] == pytest.approx(0.0, abs=1e-3) and world.missing_m["gate_4"] > 20.0
    assert world.mission_time_s == pytest.approx(1000.0)
    assert world.gates["gate_1"].ahead == pytest.approx((np.sqrt(0.5), np.sqrt(0.5), 0.0), abs=1e-6) or (
        world.gates["gate_1"].ahead == pytest.approx((np.sqrt(0.5), -np.sqrt(0.5), 0.0), abs=1e-6)
    )
    (x, y, z), yaw_deg = world.subject.before_the_gate
    assert np.hypot(x - 38.98, y + 146.9) == pytest.approx(9.0) and z == pytest.approx(-13.69)
    sim = uwsim.Simulator(world.subject.scenario)
    sim.rov.place([x, y, z], [0.0, 0.0, np.sin(0.5 * np.radians(yaw_deg)), np.cos(0.5 * np.radians(yaw_deg))])
    frame = sim.rov.cameras["front"].capture("off", geometry_only=True)
    assert frame.label_names[frame.labels[180, 320]] == "gate__3"  # straight ahead, beyond the hull
    assert {path.name for path in inputs(project)} == {"LawnTest.unity", "Pair.fbx", "StartScreen.cs"}


def test_a_deposit_is_one_whole_with_the_hash_of_every_file(project: Path, tmp_path: Path) -> None:
    (tmp_path / "out/ours").mkdir(parents=True)
    (tmp_path / "out/ours/fig01.png").write_bytes(b"picture")
    with pytest.raises(FileExistsError, match="the folder is not empty"):
        reproduce_beside(project, tmp_path / "out", {}, "uwsim", print)
    theirs = TheirWorld(
        Subject(load("paper")), [Note("left out", "SolidTerrain/A: B.fbx is missing")], {}, {}, None, 0, "SolidTerrain"
    )
    number = Number(1, "distance", "m", 0.0, 2.0, "at most 1 m", False)
    write_deposit(tmp_path / "out", project, "uwsim reproduce paper", theirs, [number], {"ours": {}})
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    assert manifest["outputs"].keys() == {"README.md", "figures.json", "ours/fig01.png"}
    assert manifest["outputs"]["ours/fig01.png"] == hashlib.sha256(b"picture").hexdigest()
    assert manifest["inputs"].keys() == {"Assets/LawnTest.unity", "Assets/Pair.fbx"}
    assert (manifest["claims_held"], manifest["claims"], manifest["seed"]) == (0, 1, 0)
    readme = (tmp_path / "out/README.md").read_text()
    assert "0 of 1 claims held" in readme and "**Their bed is not whole: SolidTerrain/A: B.fbx is missing.**" in readme


@pytest.mark.skipif(CHECKOUTS not in os.environ, reason=f"{CHECKOUTS} must name the folder of the checkouts")
def test_the_paper_s_own_files_are_reproduced_beside_ours(tmp_path: Path) -> None:
    """Takes minutes. What differs stays: the hull is five times as long, and the gates are narrower."""
    source = Path(os.environ[CHECKOUTS]) / "org-arl+UWRoboticsSimulator"
    done = command("reproduce", "paper", "--from", source, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    numbers = list(csv.DictReader((tmp_path / "out/numbers.csv").open()))
    missed = {(int(row["figure"]), row["quantity"]) for row in numbers if row["held"] != "True"}
    assert missed <= {(3, "length of the hull"), (7, "radius of the gate"), (12, "bed covered by the survey's map")}
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    for name, digest in manifest["outputs"].items():
        assert hashlib.sha256((tmp_path / "out" / name).read_bytes()).hexdigest() == digest
    assert {f"{side}fig{k:02d}.png" for side in ("", "ours/", "theirs/") for k in range(1, 13)} <= {
        *manifest["outputs"]
    }


def test_what_is_no_project_is_refused(tmp_path: Path) -> None:
    done = command("reproduce", "paper", "--from", tmp_path, "--out", tmp_path / "out")
    assert "must be the checkout of a Unity project" in error_line(done) and not (tmp_path / "out").exists()
    assert "--scene" in error_line(command("reproduce", "paper", "--scene", "LawnTest", "--out", tmp_path / "out"))


def in_itself(folder: Path) -> None:
    assets = folder / "Assets"
    (assets / "Loop.prefab").write_text("%YAML 1.1\n" + INSTANCE.replace(GUID, "f" * 32))
    (assets / "Loop.prefab.meta").write_text(f"guid: {'f' * 32}\n")
    changed(GUID, "f" * 32)(folder)


def test_names_are_a_scenario_s_and_links_out_of_the_checkout_are_not_followed(project: Path, tmp_path: Path) -> None:
    changed("m_Name: Turned", "m_Name: '7 / ö'")(project)
    changed("m_Name: Dark", "m_Name: '///'")(project)
    changed("m_Enabled: 0", "m_Enabled: 1")(project)
    (project / "Assets/Pair.fbx").rename(tmp_path / "Pair.fbx")
    (project / "Assets/Pair.fbx").symlink_to(tmp_path / "Pair.fbx")
    made = scenario_from(Project(project), project / "Assets/LawnTest.unity", tmp_path / "lake")
    assert any("more: its file is not in the checkout" in note.text for note in made.notes)
    assert [one.name for one in load(made.path).obstacles] == ["obstacle_0"]


@pytest.mark.parametrize(
    "break_it, words",
    [
        (lambda folder: (folder / "Assets").rename(folder / "Other"), "must be the checkout of a Unity project"),
        (lambda folder: (folder / "Assets/LawnTest.unity").write_bytes(b"\0\1\2"), "must be YAML"),
        (lambda folder: (folder / "Assets/LawnTest.unity").rename(folder / "Assets/A.unity"), "--scene = 'LawnTest'"),
        (lambda folder: (folder / "Assets/LawnTest.unity").write_text("%YAML 1.1\n"), "0 rigid bodies"),
        (changed("m_Children: []", "m_Children: [{fileID: 101}]"), "object 101 is the child of several, or of itself"),
        (changed("  m_Father: {fileID: 0}\n", ""), "LawnTest.unity': must be as Unity writes it: KeyError 'm_Father'"),
        (changed("y: 55.3", "y: .nan"), "SolidTerrain: has points that are not finite"),
        (changed("x: 40, y: 1, z: 40", "x: 1e6, y: 1, z: 1e6"), "m wide: must be at most 2000 m"),
        (changed("y: 55.3", "y: 95"), "the bed's lowest point is 19.7 m above the water"),
        (in_itself, "more than 20 in each other"),
    ],
)
def test_mistakes_are_one_line_and_write_nothing(break_it, words: str, project: Path, tmp_path: Path) -> None:
    break_it(project)
    done = command("scenario", "from", project, "--out", tmp_path / "lake")
    assert done.returncode != 0 and words in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "lake").exists()
