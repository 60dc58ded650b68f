"""Map scores: a perfect map has coverage 1, an empty one 0, and a map shifted by d has distance d."""

import numpy as np
import pytest

from uwsim import _core
from uwsim.scoring import true_surface
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.true_surface import SurfaceAhead

VOXEL_M = 0.5
AREA = np.array([[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]])
ABOVE = np.array([[0.0, 0.0, 6.0]])


COMPARED = (
    *("visible_voxels", "false_centres_m", "coverage", "precision", "recall"),
    *("distance_mean_m", "distance_p95_m", "distance_max_m"),
)


def plane(z_m: float) -> _core.World:
    world = _core.World()
    world.set_terrain(np.full((31, 31), z_m, np.float32), 1.0, (-15.0, -15.0))
    return world


def box(low, high):
    x, y, z = np.meshgrid(*zip(low, high, strict=True), indexing="ij")
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), np.array(triangles)


def score(world, occupied, path=ABOVE, range_max_m=50.0, area=AREA, **options) -> MapScore:
    return score_map(world, np.asarray(occupied, float).reshape(-1, 3), VOXEL_M, path, area, range_max_m, **options)


@pytest.fixture(scope="module")
def flat():
    """A level bed, and the centres of the voxels of it that are visible from above."""
    world = plane(0.2)
    return world, score(world, []).visible_centres_m


def test_a_visible_plane_has_area_over_voxel_area_voxels_and_a_map_of_them_is_perfect(flat):
    world, truth = flat
    assert len(truth) == 10 * 10 / VOXEL_M**2
    perfect = score(world, truth)
    assert (perfect.coverage, perfect.precision, perfect.recall) == (1.0, 1.0, 1.0)
    assert len(perfect.missed_centres_m) == len(perfect.false_centres_m) == 0
    assert perfect.distance_max_m == pytest.approx(0.05)  # the plane lies 0.05 m below the voxel centres


def test_an_empty_map_covers_nothing_and_has_no_distance_no_seabed_and_no_precision(flat):
    empty = score(flat[0], [])
    assert (empty.coverage, empty.recall, empty.seabed) == (0.0, 0.0, None)
    assert len(empty.missed_centres_m) == empty.visible_truth_voxels
    assert np.isnan([empty.distance_mean_m, empty.distance_p95_m, empty.distance_max_m, empty.precision]).all()


def test_without_a_flown_pose_nothing_was_visible(flat):
    nowhere = score(flat[0], [[0.25, 0.25, 0.25]], path=np.empty((0, 3)))
    assert (nowhere.visible_truth_voxels, nowhere.coverage) == (0, 0.0)


def test_a_map_of_half_the_plane_covers_half_and_recall_requires_the_voxel_itself(flat):
    world, truth = flat
    half = truth[truth[:, 0] < -VOXEL_M]  # the mapped voxels' neighbours reach x = 0
    assert score(world, half).coverage == 0.5
    each_second = score(world, truth[::2])
    assert (each_second.recall, each_second.precision) == (0.5, 1.0)


@pytest.mark.parametrize(("voxels", "coverage"), [(0, 1.0), (1, 1.0), (2, 0.0), (5, 0.0)])
def test_a_map_shifted_by_d_lies_at_distance_d_and_covers_up_to_one_voxel(voxels, coverage):
    world = plane(0.25)
    truth = score(world, []).visible_centres_m
    shifted = score(world, truth + np.array([0.0, 0.0, voxels * VOXEL_M]))
    distances = [shifted.distance_mean_m, shifted.distance_p95_m, shifted.distance_max_m]
    assert distances == pytest.approx([voxels * VOXEL_M] * 3)
    right = float(voxels == 0)
    assert (shifted.coverage, shifted.recall, shifted.precision) == (coverage, right, right)
    assert len(shifted.false_centres_m) == (len(truth) if voxels else 0)


def test_hidden_surface_is_not_counted():
    world = plane(0.2)
    world.add_solid("slab", *box((-1.9, -1.9, 1.7), (1.9, 1.9, 2.7)))
    seen = score(world, []).visible_centres_m
    assert not np.any(np.all(np.abs(seen[:, :2]) < 1.5, axis=1) & (seen[:, 2] < 2.5)), "below the slab"
    assert score(world, seen).coverage == 1.0
    from_the_side = np.array([[0.0, 0.0, 6.0], [9.0, 0.0, 0.7]])
    assert score(world, [], path=from_the_side).visible_truth_voxels > len(seen)


def test_surface_out_of_range_is_not_counted():
    reach = score(plane(0.0), [], range_max_m=6.5)
    from_nadir_m = np.linalg.norm(reach.visible_centres_m[:, :2], axis=1)
    assert from_nadir_m.max() <= 2.5 + VOXEL_M  # 6.5, 6, 2.5: a right triangle
    assert reach.visible_truth_voxels >= np.pi * 2.5**2 / VOXEL_M**2


def test_neither_the_direction_of_the_path_nor_tiles_change_the_score(monkeypatch):
    world = plane(0.2)
    world.add_solid("wall", *box((-0.1, -3.0, 0.0), (0.1, 3.0, 4.0)))
    path = np.stack([np.linspace(-4.0, 4.0, 60), np.full(60, 0.3), np.full(60, 2.0)], axis=1)
    there, back = score(world, [], path=path), score(world, [], path=path[::-1])
    assert there.visible_truth_voxels == pytest.approx(back.visible_truth_voxels, rel=0.02)
    assert there.visible_truth_voxels > score(world, [], path=path[:1]).visible_truth_voxels
    occupied = score(world, []).visible_centres_m[::5]
    whole = score(world, occupied)
    monkeypatch.setattr(true_surface, "TILE_VOXELS", 3)
    tiled = score(world, occupied)
    assert np.array_equal(tiled.visible_centres_m, whole.visible_centres_m)
    assert np.array_equal(tiled.covered, whole.covered)
    assert 0.0 < tiled.coverage < 1.0


def test_voxels_on_another_grid_are_refused(flat):
    with pytest.raises(ValueError, match=r"occupied_centres_m = up to 0\.25 m off the grid"):
        score(flat[0], [[0.0, 0.0, 0.0]])


def test_surface_out_of_range_of_the_path_does_not_count_towards_the_limit(flat, monkeypatch):
    monkeypatch.setattr(true_surface, "MAX_VOXELS", 100)
    assert score(flat[0], [], path=np.array([[0.0, 0.0, 1.2]]), range_max_m=1.5).visible_truth_voxels > 0
    with pytest.raises(ValueError, match=r"must be at most 0\.0001 million"):
        score(flat[0], [])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_surface_on_the_voxels_faces_counts_for_either_side(side):
    for off_m, recall in ((0.0, 1.0), (5e-4, 1.0), (2e-3, 0.0)):
        world = plane(1.0 - side * off_m)  # 1.0 is a multiple of the voxel; the map lies on the other side
        truth = score(world, [], area=AREA / 4).visible_centres_m
        across = score(world, truth * (1, 1, 0) + (0, 0, 1.0 + side * VOXEL_M / 2), area=AREA / 4)
        assert (across.recall, across.coverage) == (recall, 1.0), off_m


def test_false_voxels_are_found(flat):
    world, truth = flat
    floating = truth[:100] + np.array([0.0, 0.0, 6.0 * VOXEL_M])
    mixed = score(world, np.concatenate([truth, floating]))
    assert mixed.precision == pytest.approx(len(truth) / (len(truth) + 100))
    assert np.array_equal(mixed.false_centres_m, floating)


def test_a_voxel_is_right_exactly_when_the_surface_runs_through_it():
    """A tilted plane through a voxel grid, compared with the exact plane-cube intersection test."""
    normal = np.array([0.3, -0.5, 1.0])
    x, y = np.meshgrid(np.arange(-10.0, 11.0), np.arange(-10.0, 11.0))
    world = _core.World()
    world.set_terrain((-(normal[0] * x + normal[1] * y)).astype(np.float32), 1.0, (-10.0, -10.0))
    axis = (np.arange(-8, 8) + 0.5) * VOXEL_M
    cubes = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    depth_of_cut = np.abs(normal).sum() * VOXEL_M / 2.0 - np.abs(cubes @ normal)
    sure = np.abs(depth_of_cut) > 0.03 * np.linalg.norm(normal)  # 1/32 of a voxel is undecided
    right = cubes[sure & (depth_of_cut > 0)]
    wrong = cubes[sure & (depth_of_cut < 0)]
    assert min(len(right), len(wrong)) > 400
    found = score(world, np.concatenate([right, wrong]))
    assert np.array_equal(found.false_centres_m, wrong)


def test_a_vertical_shift_of_the_map_is_the_seabeds_error():
    world = plane(-20.25)
    truth = score(world, [], path=np.array([[0.0, 0.0, -15.0]])).visible_centres_m
    for voxels in (-2, 0, 1):
        seabed = score(world, truth - np.array([0.0, 0.0, voxels * VOXEL_M])).seabed
        assert seabed.judged.sum() == len(truth)
        assert seabed.errors_m == pytest.approx(voxels * VOXEL_M)
        assert seabed.depths_m == pytest.approx(20.25)
        assert (seabed.mean_m, seabed.p95_m) == pytest.approx((voxels * VOXEL_M, abs(voxels) * VOXEL_M))


def test_cells_under_an_obstacle_and_outside_the_polygon_are_not_judged():
    world = plane(0.25)
    world.add_solid("slab", *box((-1.05, -1.05, 2.0), (1.05, 1.05, 2.2)))
    flat = np.stack(np.meshgrid(*[(np.arange(-20, 20) + 0.5) * VOXEL_M] * 2), axis=-1).reshape(-1, 2)
    seabed = score(world, np.column_stack([flat, np.full(len(flat), 0.25)])).seabed
    assert seabed.obstructed.sum() == 6 * 6  # every cell that the slab overlaps
    assert seabed.judged.sum() == 20 * 20 - 36
    assert (seabed.grid.count > 0).sum() == 40 * 40


def test_what_exact_beams_have_hit_needs_no_ray_and_counts_as_seen(flat):
    """The score is that of rays."""
    world, truth = flat
    mapped = truth[truth[:, 0] < 0.0]
    asked, told = score(world, mapped), score(world, mapped, occupied_were_seen=True)
    np.testing.assert_array_equal(told.visible_voxels, asked.visible_voxels)
    assert (told.coverage, told.recall, told.precision) == (asked.coverage, asked.recall, asked.precision)
    far_from_the_path = score(world, mapped, np.add(ABOVE, (0.0, 0.0, 500.0)), occupied_were_seen=True)
    assert far_from_the_path.visible_truth_voxels == 0
    beside_the_surface = np.add(mapped, (0.0, 0.0, 2.0))  # contain no true surface: they do not count, visible or not
    wrong = score(world, beside_the_surface, occupied_were_seen=True)
    assert (wrong.visible_truth_voxels, wrong.precision) == (asked.visible_truth_voxels, 0.0)


def test_what_was_looked_at_ahead_changes_no_value(flat):
    """Independent of how much of the surface was examined during the survey, and from where."""
    world, truth = flat
    mapped = np.concatenate([truth[::2], truth[:50] + np.array([0.0, 0.0, 6.0 * VOXEL_M])])
    alone = score(world, mapped)
    for looks in (0, 1, 100):
        ahead = SurfaceAhead(world, _core.RayScene(world), VOXEL_M, AREA)
        for _ in range(looks):
            ahead.look_at(truth[::3].astype(np.float32))
        told = score(world, mapped, ahead=ahead)
        for name in COMPARED:
            np.testing.assert_array_equal(getattr(told, name), getattr(alone, name), name)
    with pytest.raises(ValueError, match=r"ahead\.voxels"):
        score_map(world, mapped, 2.0 * VOXEL_M, ABOVE, AREA, 50.0, ahead=ahead)
