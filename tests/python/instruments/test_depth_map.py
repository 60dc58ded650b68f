"""The depth-map method against one exact ray per beam: its errors, and the settings it refuses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from basin import BED_M, basin
from uwsim import _core
from uwsim.instruments.sonars import depth_map, imaging
from uwsim.instruments.sonars.depth_map import DepthMap, difference, ranges_m

SONAR = _core.multibeam_model(2)
ANGLES = SONAR.angle_min_rad + SONAR.angle_increment_rad * np.arange(SONAR.beams)
HEAD = imaging.pose_matrix((0.0, 1.0, BED_M + 3.0), yaw_rad=0.3, pitch_rad=0.2, roll_rad=0.2)


@pytest.fixture(scope="module")
def sim() -> SimpleNamespace:
    """A basin with four walls and a box ahead; the sonar head is rolled so that all columns differ."""
    walls = [((x, y, -15.0), size) for x, y, size in ((21, 0, (2, 44, 12)), (-21, 0, (2, 44, 12)),
                                                       (0, 21, (44, 2, 12)), (0, -21, (44, 2, 12)))]  # fmt: skip
    return basin(*walls, ((9.0, 3.0, BED_M + 1.0), (1.0, 1.0, 3.0)))


@pytest.fixture(scope="module")
def exact(sim: SimpleNamespace) -> np.ndarray:
    """Return the ranges (beams,) from one ray per beam."""
    flat = np.stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(SONAR.beams)], axis=1)
    ranges: np.ndarray = sim.scene.cast(HEAD[None, :3, 3], flat @ HEAD[:3, :3].T, SONAR.range_max_m).ranges_m
    assert np.isfinite(ranges).all()
    return ranges


def method(**changes: object) -> DepthMap:
    return replace(DepthMap(field_of_view_rad=SONAR.field_of_view_rad, range_max_m=SONAR.range_max_m), **changes)


def test_the_mean_error_falls_with_the_width_of_a_pixel(sim: SimpleNamespace, exact: np.ndarray) -> None:
    found = [ranges_m(sim, HEAD, ANGLES, method(width=width)) for width in (256, 1024, 4096)]
    coarse, middle, fine = (difference(ranges, exact) for ranges in found)
    assert coarse.beams == np.isfinite(exact).sum() == 513
    assert coarse.mean_m > 2.5 * middle.mean_m > 6.0 * fine.mean_m > 0.0
    half_pixel_rad = np.tan(SONAR.field_of_view_rad / 2) / 4096  # at the centre, where pixels are widest
    steepest_m_rad = np.percentile(np.abs(np.gradient(exact, ANGLES)), 98)  # ignoring edges
    assert fine.percentile_95_m < half_pixel_rad * steepest_m_rad


def test_interpolation_leaves_errors_only_at_edges(sim: SimpleNamespace, exact: np.ndarray) -> None:
    plain, smooth = (
        np.abs(ranges_m(sim, HEAD, ANGLES, method(width=1024, interpolate=between)) - exact)
        for between in (False, True)
    )
    assert np.percentile(smooth, 90) < 1e-4 < np.percentile(plain, 90)
    assert smooth.max() > 0.01, "across the box's edge there is no plane to interpolate on"


def test_several_cameras_give_the_ranges_of_one_and_more(sim: SimpleNamespace, exact: np.ndarray) -> None:
    four = difference(ranges_m(sim, HEAD, ANGLES, method(width=1024, cameras=4)), exact)
    assert (four.missed, four.invented) == (0, 0)
    assert four.mean_m < 0.01
    all_around = DepthMap(field_of_view_rad=2 * np.pi, range_max_m=55.0, width=512, cameras=4)
    around = np.radians([-170.0, -80.0, 10.0, 100.0])
    inside = imaging.pose_matrix((0.0, 0.0, -15.0))
    walls = 20.0 / np.maximum(np.abs(np.cos(around)), np.abs(np.sin(around)))
    assert ranges_m(sim, inside, around, all_around) == pytest.approx(walls, abs=0.2)
    with pytest.raises(ValueError, match=r"camera\.horizontal_fov_rad"):
        ranges_m(sim, inside, around, replace(all_around, cameras=1))


def test_a_tall_image_reduced_to_its_nearest_row_gives_the_first_echo(sim: SimpleNamespace, exact: np.ndarray) -> None:
    tall = method(width=512, height=33, vertical_fov_rad=np.radians(20.0))
    middle, nearest = (ranges_m(sim, HEAD, ANGLES, replace(tall, reduction=how)) for how in ("middle", "nearest"))
    assert (nearest <= middle).all()
    assert np.median(exact - nearest) > 0.2, "a bed that falls away is nearest where the camera looks lowest"
    assert depth_map.depth_images(sim, HEAD, tall).shape == (1, 33, 512)


def test_depths_of_eight_bits_err_by_up_to_half_a_step(sim: SimpleNamespace, exact: np.ndarray) -> None:
    fine = ranges_m(sim, HEAD, ANGLES, method(width=4096))
    stored = ranges_m(sim, HEAD, ANGLES, method(width=4096, depth_bits=8))
    half_step = 0.5 * 55.0 / 255.0
    assert np.abs((stored - fine) * np.cos(ANGLES)).max() <= half_step + 1e-4
    assert np.abs(stored - fine).mean() > 0.3 * half_step


def test_differences_are_taken_over_beams_with_both_echoes() -> None:
    off = difference([1.0, np.inf, 3.0, 5.0], [1.5, 2.0, np.inf, 5.0])
    assert (off.beams, off.missed, off.invented) == (2, 1, 1)
    assert (off.mean_m, off.max_m) == (0.25, 0.5)
    assert np.isnan(difference([np.inf], [1.0]).mean_m)
    with pytest.raises(ValueError, match=r"found_m\.shape"):
        difference([1.0], [1.0, 2.0])


def test_a_bad_value_is_named(sim: SimpleNamespace) -> None:
    for field, value in (("width", 12.5), ("height", -1), ("reduction", "median"), ("range_max_m", float("nan"))):
        with pytest.raises(ValueError, match=field):
            ranges_m(sim, np.eye(4), [0.0], method(**{field: value}))
