"""The steps from ranges to points: transmitted text, LaserScan, point clouds, filters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from any_text import any_text
from uwsim.mapping import ranging


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
