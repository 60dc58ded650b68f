"""Cameras show the material and vertex colours of glTF files."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from uwsim import Simulator
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.textures import load_texture


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
    image, corners = texture
    height, width, _ = image.shape
    places = (corners[:, 0] * (width, -height) + (0, height)).astype(int)
    seen = image[places[:, 1], places[:, 0]].astype(int)
    assert {tuple(colour) for colour in seen.tolist()} == {(255, 0, 0), (0, 188, 0)}
    assert np.ptp(corners, axis=1).max() == 0.0, "no triangle reaches into another's colour"


def test_colours_of_vertices_count_and_a_file_without_colours_has_none(tmp_path: Path) -> None:
    green = block(0.0, None)
    green.visual.vertex_colors = np.array([[0, 255, 0, 255]] * len(green.vertices))
    trimesh.Scene([green]).export(tmp_path / "green.glb")
    trimesh.Scene([block(0.0, None)]).export(tmp_path / "plain.glb")
    texture = load_texture(tmp_path / "green.glb")
    assert texture is not None and np.unique(texture[0].reshape(-1, 3), axis=0).tolist() == [[0, 255, 0]]
    assert load_texture(tmp_path / "plain.glb") is None


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
