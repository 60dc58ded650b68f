"""A mesh yields the same solid in the same place from every file format; hulls must be closed."""

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

from step_file import step_box
from uwsim.base import quaternions
from uwsim.channels.families.description import turn_up
from uwsim.scenario import RepairWarning, ScenarioError, closed_mesh, load_mesh
from uwsim.scenario.read import mesh_union
from uwsim.scenario.read.mesh_file import TURNS_UP, Up

LOW, HIGH = np.array([9.0, 18.0, 27.0]), np.array([10.0, 20.0, 30.0])  # in metres, z up


def solid() -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[LOW, HIGH])


def write_fbx(path: Path, up: str = "z", unit_cm: float = 100.0) -> Path:
    """Write the box as Blender does: a mesh about its own origin, positioned by its node."""
    size, place = HIGH - LOW, LOW
    if up == "y":
        size, place = size[[0, 2, 1]], np.array([LOW[0], LOW[2], -HIGH[1]])
    size, place = size * 100 / unit_cm, place * 100 / unit_cm
    points = [(x * size[0], y * size[1], z * size[2]) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [k if n < 3 else -k - 1 for quad in quads for n, k in enumerate(quad)]
    up_axis, front_axis, front_sign = {"y": (1, 2, 1), "z": (2, 1, -1)}[up]
    settings = {"UpAxis": up_axis, "UpAxisSign": 1, "FrontAxis": front_axis, "FrontAxisSign": front_sign}
    settings |= {"CoordAxis": 0, "CoordAxisSign": 1}
    lines = "".join(f'P: "{key}", "int", "Integer", "",{value}\n' for key, value in settings.items())
    path.write_text(f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{
FBXHeaderVersion: 1003
FBXVersion: 7400
}}
GlobalSettings:  {{
Version: 1000
Properties70:  {{
{lines}P: "UnitScaleFactor", "double", "Number", "",{unit_cm}
}}
}}
Objects:  {{
Geometry: 1000, "Geometry::box", "Mesh" {{
Vertices: *24 {{
a: {",".join(f"{c:.9g}" for point in points for c in point)}
}}
PolygonVertexIndex: *24 {{
a: {",".join(map(str, faces))}
}}
}}
Model: 2000, "Model::box", "Mesh" {{
Version: 232
Properties70:  {{
P: "Lcl Translation", "Lcl Translation", "", "A",{",".join(f"{c:.9g}" for c in place)}
}}
}}
}}
Connections:  {{
C: "OO",2000,0
C: "OO",1000,2000
}}
""")
    return path


def write(folder: Path, kind: str) -> Path:
    path = folder / f"box.{kind}"
    if kind == "fbx":
        return write_fbx(path)
    mesh = solid()
    if kind in ("glb", "gltf"):  # y up, and positioned by a node
        mesh.apply_transform([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
        shift = trimesh.transformations.translation_matrix([5, 6, 7])
        mesh.apply_transform(np.linalg.inv(shift))
        scene = trimesh.Scene()
        scene.add_geometry(mesh, transform=shift)
        scene.export(path)
    else:
        mesh.export(path)
    return path


@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "off", "glb", "gltf", "fbx"])
def test_every_format_gives_the_same_solid_in_the_same_place(
    kind: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    vertices, triangles = load_mesh(write(tmp_path, kind))
    assert (vertices.dtype, triangles.dtype) == (np.float64, np.uint32)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vertices, triangles = closed_mesh(vertices, triangles)
    assert vertices.shape == (8, 3)
    assert triangles.shape == (12, 3)
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [LOW, HIGH], atol=1e-5)
    assert trimesh.Trimesh(vertices, triangles).volume == pytest.approx(6.0, rel=1e-5)
    assert capfd.readouterr() == ("", "")


def write_collada(path: Path) -> None:
    """Write the box with a line beside its triangles."""
    box = solid()
    x, y, z = (f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    path.write_text(f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="box"><mesh>
<source id="at"><float_array id="xyz" count="24">{" ".join(map(str, box.vertices.ravel()))}</float_array>
<technique_common><accessor source="#xyz" count="8" stride="3">{x}{y}{z}</accessor></technique_common></source>
<vertices id="corners"><input semantic="POSITION" source="#at"/></vertices>
<lines count="1"><input semantic="VERTEX" source="#corners" offset="0"/><p>0 7</p></lines>
<triangles count="12"><input semantic="VERTEX" source="#corners" offset="0"/>
<p>{" ".join(map(str, box.faces.ravel()))}</p></triangles>
<linestrips count="0"/>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="all"><node><instance_geometry url="#box"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#all"/></scene></COLLADA>
""")


def test_lines_beside_the_triangles_of_a_collada_file_are_left_out(tmp_path: Path) -> None:
    write_collada(tmp_path / "a.dae")
    vertices, triangles = load_mesh(tmp_path / "a.dae")
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [LOW, HIGH], atol=1e-5)
    assert len(triangles) == 12


def test_an_fbx_file_declares_its_axes_and_its_unit(tmp_path: Path) -> None:
    for up in ("y", "z"):
        for unit_cm in (1.0, 100.0):
            vertices, _ = load_mesh(write_fbx(tmp_path / "a.fbx", up, unit_cm))
            np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [LOW, HIGH], atol=1e-4)


def test_a_step_file_is_read_in_metres_and_a_broken_one_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cascadio", reason="pip install 'uwsim[step]'")
    path = tmp_path / "box.step"
    path.write_text(step_box((1200.0, 400.0, 300.0)))
    vertices, triangles = closed_mesh(*load_mesh(path))
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [[0, 0, 0], [1.2, 0.4, 0.3]], atol=1e-6)
    assert trimesh.Trimesh(vertices, triangles).volume == pytest.approx(0.144, rel=1e-5)
    path.write_text(path.read_text()[:600])
    with pytest.raises(ScenarioError, match="not a readable step file: OpenCASCADE finds no shape in it"):
        load_mesh(path)
    assert capfd.readouterr() == ("", "")


def test_a_missing_step_reader_is_named_with_its_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cascadio", None)
    (tmp_path / "box.STP").write_text(step_box((1.0, 1.0, 1.0)))
    with pytest.raises(ScenarioError, match=r"'cascadio', which is not installed: pip install 'uwsim\[step\]'"):
        load_mesh(tmp_path / "box.STP")


def test_scale_and_up_override_the_defaults_of_a_format(tmp_path: Path) -> None:
    path = write(tmp_path, "obj")
    vertices, _ = load_mesh(path, scale=0.001, up="y")  # the file's (x, y, z) becomes (x, -z, y)
    np.testing.assert_allclose(vertices.min(axis=0), [0.009, -0.030, 0.018])
    np.testing.assert_allclose(load_mesh(write(tmp_path, "glb"), up="z")[0].min(axis=0), [9, 27, -20], atol=1e-5)


@pytest.mark.parametrize("up", TURNS_UP)
def test_any_axis_may_point_up(up: Up, tmp_path: Path) -> None:
    """It becomes z, by a rotation, which viewers are given as the same quaternion."""
    turn = np.array(TURNS_UP[up])
    assert np.linalg.det(turn) == 1
    vertices, _ = load_mesh(path := write(tmp_path, "obj"), up=up)
    np.testing.assert_allclose(vertices[:, 2], solid().vertices[:, "xyz".index(up[-1])] * (-1 if up[0] == "-" else 1))
    np.testing.assert_allclose(quaternions.matrix(turn_up(path, up)), turn, atol=1e-15)


def test_comments_may_be_in_any_encoding(tmp_path: Path) -> None:
    path = write(tmp_path, "obj")
    path.write_bytes(b"# caf\xe9\n" + path.read_bytes())
    assert len(load_mesh(path)[1]) == 12


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8"])
def test_the_name_in_an_ascii_stl_may_be_any_text(encoding: str, tmp_path: Path) -> None:
    text = trimesh.exchange.stl.export_stl_ascii(solid()).replace("solid", "solid Körper", 1)
    path = tmp_path / "a.stl"
    path.write_bytes(text.encode(encoding))
    np.testing.assert_allclose(np.ptp(load_mesh(path)[0], axis=0), HIGH - LOW)
    path.write_bytes(text.encode(encoding)[:-300])
    with pytest.raises(ScenarioError, match="not a readable stl file: breaks off before its endsolid"):
        load_mesh(path)


def test_the_error_about_a_corrupt_stl_says_what_is_wrong(tmp_path: Path) -> None:
    path = write(tmp_path, "stl")
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(ScenarioError, match="its 634 bytes are not the 684 of the 12 triangles it announces"):
        load_mesh(path)


def test_the_error_names_a_reader_that_is_not_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "assimp_py", None)
    with pytest.raises(ScenarioError, match=r"'assimp_py', which is not installed: pip install 'uwsim\[files\]'"):
        load_mesh(write(tmp_path, "fbx"))


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ("f 0 1 2", "line 5: a face names vertex 0, but an OBJ file's count from 1"),
        ("f 1 2 3\n f 1//1 2//1 00//1", "line 6: a face names vertex 0"),
        ("f 1 1 2\nf 2 3 3", "none of its 2 triangles has an area"),
        ("f 1 2 4", "none of its 1 triangles has an area"),
    ],
)
def test_faces_without_a_vertex_or_an_area_are_refused(faces: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 10 0 0\n{faces}\n")
    with pytest.raises(ScenarioError, match=message):
        load_mesh(path)


def test_a_mesh_in_the_wrong_unit_is_refused(tmp_path: Path) -> None:
    mesh = solid().apply_scale(1e5)
    mesh.export(tmp_path / "a.ply")
    with pytest.raises(ScenarioError, match=r"reaches 3e\+06 m from its origin at scale 1, must be at most 100000 m"):
        load_mesh(tmp_path / "a.ply")
    assert load_mesh(tmp_path / "a.ply", scale=1e-5)[0].max() == pytest.approx(30.0)
    solid().apply_scale(1e-6).export(tmp_path / "small.ply")  # small, but not flat
    assert len(load_mesh(tmp_path / "small.ply")[1]) == 12


@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "glb", "fbx", "dae", "xyz"])
@pytest.mark.parametrize("content", [b"", b"hello world", bytes(range(256)) * 4], ids=["empty", "text", "bytes"])
def test_malformed_files_are_refused_in_one_line(
    kind: str, content: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"bad.{kind}"
    path.write_bytes(content)
    with pytest.raises(ScenarioError) as caught:
        load_mesh(path)
    assert str(caught.value).startswith(f"mesh '{path}': ")
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["stl", "ply", "glb", "fbx"])
def test_truncated_files_are_refused(kind: str, tmp_path: Path) -> None:
    path = write(tmp_path, kind)
    path.write_bytes(path.read_bytes()[:-120])
    with pytest.raises(ScenarioError, match="not a readable"):
        load_mesh(path)


def test_missing_files_and_meshes_without_a_finite_surface_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="no such file"):
        load_mesh(tmp_path / "none.stl")
    with pytest.raises(ScenarioError, match="not a regular file"):
        load_mesh(tmp_path)
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n")
    with pytest.raises(ScenarioError, match="1 vertices are not finite"):
        load_mesh(path)
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    with pytest.raises(ScenarioError, match=r"a\.obj"):
        load_mesh(path)
    path.write_text("v 0 0 0\nv 1 0 0\nl 1 2\n")
    with pytest.raises(ScenarioError, match="holds no triangles"):
        load_mesh(path)


def volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    return float(trimesh.Trimesh(vertices, triangles, process=False).volume)


def test_holes_and_winding_are_repaired_with_a_warning() -> None:
    box = solid()
    with pytest.warns(RepairWarning, match="repaired: filled holes with 1 triangles"):
        assert volume(*closed_mesh(box.vertices, box.faces[1:])) == pytest.approx(6.0)
    turned = box.faces.copy()
    turned[[2, 7]] = turned[[2, 7], ::-1]
    with pytest.warns(RepairWarning, match="made the winding consistent"):
        assert volume(*closed_mesh(box.vertices, turned)) == pytest.approx(6.0)
    with pytest.warns(RepairWarning, match="turned inside-out parts outward"):
        assert volume(*closed_mesh(box.vertices, box.faces[:, ::-1])) == pytest.approx(6.0)


def test_a_cavity_stays_a_cavity_and_an_inverted_neighbour_does_not() -> None:
    inner = trimesh.creation.box((0.5, 0.5, 0.5))
    inner.invert()
    outer = trimesh.creation.box((2, 2, 2))
    shell = trimesh.util.concatenate([outer, inner])
    assert volume(*closed_mesh(shell.vertices, shell.faces)) == pytest.approx(8 - 0.125)
    inner.apply_translation([5, 0, 0])
    pair = trimesh.util.concatenate([outer, inner])
    with pytest.warns(RepairWarning, match="turned inside-out parts outward"):
        assert volume(*closed_mesh(pair.vertices, pair.faces)) == pytest.approx(8 + 0.125)


def test_loose_sheets_are_left_out_and_nothing_else_is_refused() -> None:
    box = solid()
    fin = np.vstack([box.faces, [[0, 7, 5]]])
    with pytest.warns(RepairWarning, match=r"mesh 'fin': was not closed \(.*edge.*left out 1 sheets.*encloses 6 m3"):
        assert volume(*closed_mesh(box.vertices, fin, name="fin")) == pytest.approx(6.0)
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(ScenarioError, match=r"mesh 'mesh': is not closed \(3 edges .*\) and encloses no volume"):
        closed_mesh(flat.vertices, flat.faces)


def test_open_parts_that_share_an_edge_and_overlap_are_capped_turned_and_united() -> None:
    """As in models made for pictures: a lidless box, one turned inside out along its edge, and a tube through both."""
    box = trimesh.creation.box((2, 2, 2))
    lidless = trimesh.Trimesh(box.vertices, box.faces[box.face_normals[:, 2] < 0.5], process=False)
    inverted = trimesh.creation.box((2, 2, 2))
    inverted.apply_translation([2, 2, 0])
    inverted.invert()
    tube = trimesh.creation.cylinder(0.25, 6, sections=64)
    tube = trimesh.Trimesh(tube.vertices, tube.faces[np.abs(tube.face_normals[:, 2]) < 0.5], process=False)
    mesh = trimesh.util.concatenate([lidless, inverted, tube])
    with pytest.warns(RepairWarning, match=r"capped 3 holes.* turned 1 parts outward.* united 3 parts.* m3, [+-]"):
        vertices, triangles = closed_mesh(mesh.vertices, mesh.faces)
    disc_m2 = 32 * 0.25**2 * np.sin(2 * np.pi / 64)
    assert volume(vertices, triangles) == pytest.approx(8 + 8 + 4 * disc_m2)
    assert trimesh.Trimesh(vertices, triangles, process=False).is_watertight


def test_a_part_that_crosses_itself_is_wrapped_to_within_its_grid() -> None:
    """A ball with spikes through it, and a fin on one of its edges."""
    ball = trimesh.creation.icosphere(2, radius=1.0)
    spikes = ball.vertices.copy()
    spikes[::7] *= -0.98  # every seventh vertex is on the other side: its triangles pass through all of the ball
    faces = np.vstack([ball.faces, [[*ball.faces[0][:2], ball.faces[150][0]]]])
    with pytest.warns(RepairWarning, match=r"wrapped 1 parts that cross themselves, to within 0\.04"):
        vertices, triangles = closed_mesh(spikes, faces)
    found = trimesh.Trimesh(vertices, triangles, process=False)
    assert found.is_watertight
    assert 0.5 * ball.volume < found.volume < 1.1 * ball.volume
    assert np.abs(found.bounds - ball.bounds).max() < 2 / 48


def test_a_small_part_that_crosses_itself_becomes_its_convex_hull() -> None:
    ball = trimesh.creation.icosphere(2, radius=0.02)
    spikes = ball.vertices.copy()
    spikes[::7] *= -0.98
    spikes[:, 0] += 2.0
    open_box = trimesh.creation.box((2, 2, 2))
    hull = trimesh.util.concatenate([trimesh.Trimesh(open_box.vertices, open_box.faces[2:], process=False)])
    hull = trimesh.util.concatenate([hull, trimesh.Trimesh(spikes, ball.faces, process=False)])
    with pytest.warns(RepairWarning, match="replaced 1 small parts that cross themselves by their convex hulls"):
        found = volume(*closed_mesh(hull.vertices, hull.faces))
    assert found - 8.0 == pytest.approx(ball.volume, rel=0.05)


def test_a_mesh_that_was_closed_before_is_closed_no_more_but_warned_about(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("UWSIM_CACHE", str(tmp_path))
    box = solid()
    for name in ("one", "two"):
        with pytest.warns(RepairWarning, match=f"mesh '{name}': repaired: filled holes with 1 triangles"):
            found = closed_mesh(box.vertices, box.faces[1:], name=name)
        assert volume(*found) == pytest.approx(6.0)
        monkeypatch.setattr("uwsim.scenario.read.mesh_repair._repair", None)


def test_crossings_are_those_of_all_pairs() -> None:
    ball = trimesh.creation.icosphere(2)
    vertices, faces = ball.vertices * [1.0, 0.3, 0.1], np.asarray(ball.faces)
    vertices[::7] *= -0.98
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    apart = [(edge, face) for edge in edges for face in faces if not set(edge) & set(face)]
    pierced = mesh_union._pierces(vertices[[e for e, _ in apart]], vertices[[f for _, f in apart]])
    solid = mesh_union.manifold(trimesh.Trimesh(vertices, faces, process=False))
    assert mesh_union.crossings(solid) == pierced.sum() > 5


def test_parts_that_overlap_are_united_with_a_warning() -> None:
    body = trimesh.creation.box((2, 2, 2))
    tower = trimesh.creation.box((1, 1, 2))
    tower.apply_translation([0, 0, 1])  # half of it lies inside the body
    buried = trimesh.creation.icosphere(2, radius=0.2)
    hull = trimesh.util.concatenate([body, tower, buried])
    with pytest.warns(UserWarning, match="united 3 parts that overlapped"):
        assert volume(*closed_mesh(hull.vertices, hull.faces)) == pytest.approx(8 + 1)


def test_parts_that_touch_or_stand_apart_are_not_united() -> None:
    box, neighbour = trimesh.creation.box((2, 2, 2)), trimesh.creation.box((1, 1, 1))
    for shift in (1.5, 4.0):
        pair = trimesh.util.concatenate([box, neighbour.copy().apply_translation([shift, 0, 0])])
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            _, triangles = closed_mesh(pair.vertices, pair.faces)
        assert len(triangles) == 24


def test_a_skin_that_crosses_itself_in_a_few_places_is_kept_with_a_warning() -> None:
    ball = trimesh.creation.icosphere(3)
    vertices = ball.vertices.copy()
    vertices[0] *= -1.1  # its triangles pass through the ball
    with pytest.warns(RepairWarning, match=r"mesh 'hull': .*crosses itself \(10 edges pierce its triangles\)"):
        found = trimesh.Trimesh(*closed_mesh(vertices, ball.faces, name="hull"))
    assert found.is_watertight
    assert found.volume == pytest.approx(ball.volume, rel=0.02)


def test_an_empty_mesh_is_refused() -> None:
    with pytest.raises(ScenarioError, match="mesh 'hull': has no triangles"):
        closed_mesh(np.zeros((0, 3)), np.zeros((0, 3)), name="hull")
