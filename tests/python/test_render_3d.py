"""The 3D renderer of figures: its view, its voxel cubes and its clip prism."""

import numpy as np
import pytest

from uwsim import _core
from uwsim.figures.clip_prism import ClipPrism
from uwsim.figures.pinhole_view import view_of_box
from uwsim.figures.render_3d import Subject, render
from uwsim.figures.voxel_mesh import voxel_world

LOW, HIGH = np.array([-8.0, -5.0, -2.0]), np.array([8.0, 5.0, 1.0])


def test_a_pixels_ray_projects_onto_the_pixel():
    view = view_of_box(LOW, HIGH, azimuth_rad=-2.0, elevation_rad=0.6, width=120)
    rays = view.rays(np.array([0, 17]), scale=1)
    pixels = view.project(view.eye_world_m + 30.0 * rays)
    assert pixels[:, 0] == pytest.approx(np.tile(np.arange(120) + 0.5, 2))
    assert pixels[:, 1] == pytest.approx(np.repeat([0.5, 17.5], 120))
    assert np.linalg.norm(rays, axis=1) == pytest.approx(1.0)


def test_the_box_is_within_the_view():
    view = view_of_box(LOW, HIGH, azimuth_rad=1.0, elevation_rad=0.3, width=200)
    corners = np.stack(np.meshgrid(*zip(LOW, HIGH, strict=True)), axis=-1).reshape(-1, 3)
    pixels = view.project(corners)
    assert np.all((pixels >= 0.0) & (pixels <= [view.width, view.height]))


@pytest.mark.parametrize("size_m", [(1e-4, 1e-4, 1.5), (1e-4, 500.0, 1e-4), (500.0, 1e-4, 1e-4), (0.0, 0.0, 0.0)])
def test_the_view_of_a_needle_keeps_a_moderate_aspect_ratio(size_m):
    view = view_of_box(np.zeros(3), np.array(size_m), azimuth_rad=-2.0, elevation_rad=0.6, width=100)
    assert 20 <= view.height <= 200
    assert (view.window[1] - view.window[0]) / (view.window[3] - view.window[2]) == pytest.approx(
        view.width / view.height, rel=0.03
    )
    pixels = view.project(np.array([np.zeros(3), size_m]))
    assert np.all((pixels >= 0.0) & (pixels <= [view.width, view.height]))


def test_a_point_behind_the_eye_has_no_pixel():
    view = view_of_box(LOW, HIGH, azimuth_rad=1.0, elevation_rad=0.3, width=200)
    assert np.isnan(view.project(2.0 * view.eye_world_m[None])).all()


@pytest.mark.parametrize(
    ("voxels", "faces"), [([[0, 0, 0]], 6), ([[0, 0, 0], [1, 0, 0]], 10), ([[0, 0, 0], [1, 1, 0]], 12)]
)
def test_only_exposed_faces_are_built_and_they_face_outwards(voxels, faces):
    vertices, triangles, _ = voxel_world((np.array(voxels) + 0.5) * 0.5, 0.5).surface_mesh()
    assert len(triangles) == 2 * faces
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert volume == pytest.approx(len(voxels) * 0.5**3)


@pytest.mark.parametrize("winding", [1, -1])
def test_a_ray_crosses_a_prism_between_its_walls(winding):
    square = np.array([[1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [1.0, 1.0]])[::winding]
    prism = ClipPrism(square, floor_m=-5.0)
    origins = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 0.0, 7.0], [2.0, 0.0, 0.0]])
    directions = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    enter, leave = prism.span(origins, directions)
    assert (enter[0], leave[0]) == (1.0, 3.0)
    assert enter[1] > leave[1]
    assert (enter[2], leave[2]) == (0.0, 12.0)
    assert (enter[3], leave[3]) == (0.0, np.inf)


def test_parts_outside_the_prism_are_invisible_and_cast_no_shadow():
    world = _core.World()
    world.set_terrain(np.zeros((31, 31), np.float32), 1.0, (-15.0, -15.0))
    view = view_of_box(LOW, HIGH, azimuth_rad=-2.0, elevation_rad=0.6, width=60)
    square = np.array([[-8.0, -5.0], [8.0, -5.0], [8.0, 5.0], [-8.0, 5.0]])

    def picture():
        grey = lambda heights: np.full((len(heights), 3), 0.5)  # noqa: E731
        sun = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
        return render(Subject(_core.RayScene(world), grey, ClipPrism(square, -2.0), world.height_at), view, sun)

    alone = picture()
    wall = np.array([[10.0, -15.0, -1.0], [10.0, 15.0, -1.0], [10.0, 15.0, 30.0], [10.0, -15.0, 30.0]])
    world.add_solid("wall", wall, np.array([[0, 1, 2], [0, 2, 3]]))
    assert alone.shape == (view.height, view.width, 3)
    assert np.ptp(alone) > 0
    assert np.array_equal(picture(), alone)
