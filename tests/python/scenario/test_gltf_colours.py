"""Cameras show the material and vertex colours of glTF files, and the materials of OBJ files."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from uwsim import Simulator
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import load_texture, triangle_means


def block(east_m: float, colour: tuple[int, int, int] | None) -> trimesh.Trimesh:
    made = trimesh.creation.box((2.0, 2.0, 2.0))
    made.apply_translation((east_m, 0.0, 0.0))
    if colour is not None:
        made.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=[*colour, 255]))
    return made


def test_each_triangle_has_the_colour_of_its_material(tmp_path: Path) -> None:
    """glTF colours are linear, image colours are sRGB: half the light is 188 of 255."""
    trimesh.Scene([block(0.0, (255, 0, 0)), block(5.0, (0, 128, 0))]).export(tmp_path / "two.glb")
    texture = load_texture(tmp_path / "two.glb")
    assert texture is not None
    image, corners, _ = texture
    height, width, _ = image.shape
    places = (corners[:, 0] * (width, -height) + (0, height)).astype(int)
    seen = image[places[:, 1], places[:, 0]].astype(int)
    assert {tuple(colour) for colour in seen.tolist()} == {(255, 0, 0), (0, 188, 0)}
    assert np.ptp(corners, axis=1).max() == 0.0, "no triangle reaches into another's colour"


def test_the_materials_of_an_obj_file_colour_its_triangles_and_change_nothing_else(tmp_path: Path) -> None:
    plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n"
    (tmp_path / "plain.obj").write_text(plain)
    painted = plain.replace("f 1 3", "usemtl red\nf 1 3").replace("f 2", "usemtl none\nf 2")
    (tmp_path / "painted.obj").write_text("mtllib paints.mtl\n" + painted)
    assert load_texture(tmp_path / "painted.obj") is None, "its library is absent"
    (tmp_path / "paints.mtl").write_text("newmtl red\nNs 10\nKd 0.5 0 0\nnewmtl none\n")
    texture = load_texture(tmp_path / "painted.obj")
    assert texture is not None
    np.testing.assert_allclose(triangle_means(texture), [[0.5, 0, 0], [0.5, 0, 0], [1, 1, 1]], atol=4e-3)
    for one, other in zip(load_mesh(tmp_path / "plain.obj"), load_mesh(tmp_path / "painted.obj"), strict=True):
        np.testing.assert_array_equal(one, other)


def test_colours_of_vertices_count_and_a_file_without_colours_has_none(tmp_path: Path) -> None:
    green = block(0.0, None)
    green.visual.vertex_colors = np.array([[0, 255, 0, 255]] * len(green.vertices))
    trimesh.Scene([green]).export(tmp_path / "green.glb")
    trimesh.Scene([block(0.0, None)]).export(tmp_path / "plain.glb")
    texture = load_texture(tmp_path / "green.glb")
    assert texture is not None and np.unique(texture[0].reshape(-1, 3), axis=0).tolist() == [[0, 255, 0]]
    assert load_texture(tmp_path / "plain.glb") is None


def test_a_whole_file_is_read_once_and_one_with_parts_whenever_it_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("UWSIM_CACHE", str(tmp_path / "cache"))
    for name in ("whole.glb", "parts.gltf"):
        trimesh.Scene([block(0.0, (255, 0, 0))]).export(tmp_path / name)
    whole, parts = (load_texture(tmp_path / name) for name in ("whole.glb", "parts.gltf"))
    assert whole is not None and parts is not None
    monkeypatch.setattr(trimesh, "load_scene", None)
    again = load_texture(tmp_path / "whole.glb")
    assert again is not None and again.normals is None
    assert [again.image.tolist(), again.corners.tolist()] == [whole.image.tolist(), whole.corners.tolist()]
    assert load_texture(tmp_path / "parts.gltf") is None


@pytest.mark.parametrize(("colour", "strongest"), [((255, 0, 0), 0), ((0, 0, 255), 2)])
def test_a_camera_sees_the_colour(colour: tuple[int, int, int], strongest: int, tmp_path: Path) -> None:
    trimesh.Scene([block(0.0, colour)]).export(tmp_path / "block.glb")
    pool = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    mesh = "  - {kind: mesh, name: block, file: block.glb, position_m: [4, 0, -2], on_bed: false}\nvehicles:\n"
    pool = pool.replace("vehicles:\n", mesh).replace("start: station", "start: {position_m: [0, 0, -2]}")
    (tmp_path / "pool.yaml").write_text(pool)
    with Simulator(tmp_path / "pool.yaml") as sim:
        frame = sim.rov.cameras["front"].capture("off")
        middle = frame.rgb[frame.labels == sim.label_names.index("block")].astype(float).mean(axis=0)
    assert middle.argmax() == strongest
    assert middle[strongest] > 2.0 * np.delete(middle, strongest).max()


def test_relief_gloss_and_smooth_normals_of_a_file_count(tmp_path: Path) -> None:
    """Half the red light is 188 of 255 in sRGB; a sphere's corners have the normals of the sphere."""
    ball = trimesh.creation.uv_sphere(radius=2.0, count=[16, 16])
    material = PBRMaterial(
        baseColorTexture=Image.new("RGB", (8, 4), (255, 255, 255)), baseColorFactor=[128, 255, 255, 255],
        normalTexture=Image.new("RGB", (2, 2), (140, 128, 254)), roughnessFactor=0.4, metallicFactor=0.2,
    )  # fmt: skip
    ball.visual = TextureVisuals(uv=np.zeros((len(ball.vertices), 2)), material=material)
    ball.vertex_normals = ball.vertices / 2.0
    ball.export(tmp_path / "ball.glb", include_normals=True)
    texture = load_texture(tmp_path / "ball.glb")
    assert texture is not None and texture.normals is not None
    assert texture.image.shape == (4, 8, 8)
    assert texture.image[0, 0].tolist() == [188, 255, 255, 140, 128, 254, 102, 51]
    vertices, triangles = load_mesh(tmp_path / "ball.glb")
    first, second, third = vertices[triangles].swapaxes(0, 1)
    own = np.cross(second - first, third - first)
    along, own = ((way.T / np.linalg.norm(way, axis=1)).T for way in (second - first, own))
    axes = np.stack([along, np.cross(own, along), own], axis=1)
    assert np.allclose(np.einsum("mck,mka->mca", texture.normals, axes), vertices[triangles] / 2.0, atol=1e-5)
