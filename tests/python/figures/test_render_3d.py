"""The 3D renderer for figures: its view, voxel cubes and clipping prism."""

import numpy as np
import pytest

from uwsim import _core
from uwsim.figures.clip_prism import ClipPrism
from uwsim.figures.pinhole_view import view_of_box
from uwsim.figures.render_3d import Subject, cast_at_world, render

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


def boxes_hit_m(centres_m, edge_m, origins_m, directions):
    """Return the distance to the nearest cube and the axis of the face hit, by the slab method per ray and cube."""
    with np.errstate(divide="ignore"):
        walls = (centres_m[None, :, None] + [[-edge_m / 2], [edge_m / 2]] - origins_m[:, None, None]) / directions[
            :, None, None
        ]
    enter, leave = walls.min(axis=2), walls.max(axis=2).min(axis=2)
    axis, enter_m = enter.argmax(axis=2), np.maximum(enter.max(axis=2), 0.0)
    enter_m[enter_m > leave] = np.inf
    first = enter_m.argmin(axis=1)
    rays = np.arange(len(origins_m))
    return enter_m[rays, first], axis[rays, first]


def test_a_ray_hits_the_first_of_many_cubes():
    random = np.random.default_rng(3)
    keys = np.unique(random.integers([-40, -50, -10], [60, 30, 12], (4000, 3)), axis=0)
    edge_m = 0.25
    centres = (keys + 0.5) * edge_m
    origins = random.uniform([-30, -30, -20], [30, 30, 20], (500, 3))
    targets = centres[random.integers(len(centres), size=len(origins))] + random.uniform(-1, 1, origins.shape)
    directions = (targets - origins) / np.linalg.norm(targets - origins, axis=1)[:, None]
    expected_m, axis = boxes_hit_m(centres, edge_m, origins, directions)
    hits = _core.VoxelScene(random.permutation(centres), edge_m).cast(origins, directions, 1e4)
    assert 100 < np.isfinite(expected_m).sum() < 500
    assert hits.ranges_m == pytest.approx(expected_m, abs=1e-5)
    met = np.flatnonzero(np.isfinite(expected_m) & (expected_m > 0.0))
    assert np.abs(hits.normals_world[met]).argmax(axis=1).tolist() == axis[met].tolist()
    assert (np.einsum("ij,ij->i", hits.normals_world[met], directions[met]) < 0.0).all()


def test_rays_along_the_axes_hit_cubes_and_pass_between_them():
    scene = _core.VoxelScene(np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 40.5], [70.5, 0.5, 0.5]]), 1.0)
    origins = np.array([[0.5, 0.5, 90.0], [0.5, 0.5, 20.0], [0.5, 0.5, 20.0], [90.0, 0.5, 0.5], [1.5, 0.5, 90.0]])
    directions = np.array([[0, 0, -1], [0, 0, -1], [0, 0, 1], [-1, 0, 0], [0, 0, -1]])
    assert scene.cast(origins, directions, 1e3).ranges_m.tolist() == [49.0, 19.0, 20.0, 19.0, np.inf]
    assert scene.cast(origins[:1], directions[:1], 48.0).ranges_m.tolist() == [np.inf]


@pytest.mark.parametrize(
    ("centres", "edge_m", "message"),
    [
        ([[0.5, 0.5, 0.5], [2e6, 0.5, 0.5]], 1.0, "less than 2\\^17 cubes apart"),
        ([[0.5, 0.5, 0.5]], 0.0, "edge_m = 0: must be positive"),
    ],
)
def test_cubes_that_no_grid_holds_are_refused(centres, edge_m, message):
    with pytest.raises(ValueError, match=message):
        _core.VoxelScene(np.array(centres), edge_m)


def test_nothing_is_hit_where_there_are_no_cubes():
    scene = _core.VoxelScene(np.empty((0, 3)), 1.0)
    assert np.isinf(scene.cast([[0.0, 0.0, 9.0]], [[0.0, 0.0, -1.0]], 100.0).ranges_m).all()


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
        return render(
            Subject(cast_at_world(_core.RayScene(world)), grey, ClipPrism(square, -2.0), world.height_at), view, sun
        )

    alone = picture()
    wall = np.array([[10.0, -15.0, -1.0], [10.0, 15.0, -1.0], [10.0, 15.0, 30.0], [10.0, -15.0, 30.0]])
    world.add_solid("wall", wall, np.array([[0, 1, 2], [0, 2, 3]]))
    assert alone.shape == (view.height, view.width, 3)
    assert np.ptp(alone) > 0
    assert np.array_equal(picture(), alone)
