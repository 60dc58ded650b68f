"""The steps from ranges to points: transmitted text, LaserScan, point clouds, filters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from any_text import any_text
from uwsim.mapping import ranging


def rigid(yaw_rad, translation_m):
    transform = np.eye(4)
    transform[:2, :2] = [[np.cos(yaw_rad), -np.sin(yaw_rad)], [np.sin(yaw_rad), np.cos(yaw_rad)]]
    transform[:3, 3] = translation_m
    return transform


def wall_scan(distance_m, model=2):
    """Return the scan of a plane perpendicular to the sonar's forward axis."""
    variant = ranging.MODELS[model]
    angles_rad = variant.angle_min_rad + variant.angle_increment_rad * np.arange(variant.beams)
    return ranging.to_laser_scan((distance_m / np.cos(angles_rad)).astype(np.float32), model)


@given(st.text(alphabet="0123456789.aE+-,n ", max_size=40) | any_text(40))
def test_any_other_text_raises_a_value_error(text):
    with pytest.raises(ValueError, match="depth_string"):
        ranging.decode_depth_string(text)


@pytest.mark.parametrize(
    ("model", "beams", "fov_deg", "range_m", "limit_m"),
    [(1, 513, 85, 95, 94.9), (2, 513, 85, 55, 54.9), (3, 1025, 170, 95, 94.9), (4, 1025, 170, 55, 54.9)],
)
def test_every_link_uses_the_models_values(model, beams, fov_deg, range_m, limit_m):
    text = ranging.encode_depth_string(np.full(beams, np.inf), model)
    assert text == beams * f"{range_m}a"
    scan = ranging.to_laser_scan(ranging.decode_depth_string(text, model), model)
    assert (scan.range_min, scan.range_max) == (0.0, limit_m)
    assert np.degrees(scan.angle_max - scan.angle_min) == pytest.approx(fov_deg)
    assert scan.angle_min + (beams - 1) * scan.angle_increment == pytest.approx(scan.angle_max)
    assert ranging.to_point_cloud(scan).shape == (0, 3)
    with pytest.raises(ValueError, match=r"shape"):
        ranging.encode_depth_string(np.ones(beams - 1), model)


@pytest.mark.parametrize("model", [0, 5, "2", None, 2.5])
def test_the_error_about_an_unknown_model_lists_the_known_ones(model):
    with pytest.raises(ValueError, match=r"sonar\.model = .*: must be one of 1, 2, 3, 4"):
        ranging.encode_depth_string(np.ones(513), model)


def test_a_scan_has_the_fields_of_the_message():
    scan = ranging.to_laser_scan(np.ones(513), model=2, stamp_s=12.5, ping_interval_s=0.1)
    assert (scan.frame_id, scan.stamp_s, scan.scan_time, scan.time_increment) == ("base_scan", 12.5, 0.1, 0.0)
    assert scan.intensities.size == 0


def test_float32_is_not_copied_and_other_dtypes_are_refused():
    ranges_m = np.ones(513, dtype=np.float32)
    assert ranging.to_laser_scan(ranges_m).ranges is ranges_m
    assert ranging.to_laser_scan([1.0] * 513).ranges.dtype == np.float32
    for dtype in (bool, complex, str, object):
        with pytest.raises(ValueError, match="dtype"):
            ranging.to_laser_scan(np.ones(513).astype(dtype))
        with pytest.raises(ValueError, match="dtype"):
            ranging.transform_points(np.ones((2, 3)).astype(dtype), np.eye(4))


def test_a_scan_in_the_world_is_the_same_in_one_call_and_step_by_step():
    scan, box = wall_scan(9.0), ([-1, -3, -1], [20, 3, 1])
    body, sonar = rigid(2.0, [100, -50, -20]), rigid(2.0, [100, -50, -20]) @ rigid(-0.5, [0.4, 0, -0.2])
    near_m = ranging.filter_range(ranging.to_point_cloud(scan), scan.range_min, scan.range_max)
    in_body_m = ranging.transform_points(near_m, ranging.relative_transform(body, sonar))
    others_m = ranging.remove_box(in_body_m, *box)
    assert 0 < len(others_m) < len(in_body_m)
    np.testing.assert_array_equal(ranging.to_world(scan, *box, body, sonar), ranging.transform_points(others_m, body))
    with pytest.raises(ValueError, match="box_max_m"):
        ranging.to_world(scan, *reversed(box), body, sonar)
