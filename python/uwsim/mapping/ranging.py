"""The steps from a sonar's ranges to points in the world; each is a separate function.

    text = encode_depth_string(ping.ranges_m, model=2)      the published wire: "12.31a12.3a55a..."
    ranges_m = decode_depth_string(text, model=2)           inf without echo
    scan = to_laser_scan(ranges_m, model=2, stamp_s=12.5)   sensor_msgs/LaserScan's fields
    scan = reject_outliers(scan)                            in physics mode: false detections
                                                            (before the text: place_deviation_m, reject_uncertain)
    points_m = to_point_cloud(scan)                         in base_scan: x forward, y left, z up
    points_m = remove_box(transform_points(points_m, body_from_sonar), box_min_m, box_max_m)      self filter
    points_world_m = transform_points(points_m, world_from_body)
    points_world_m = to_world(scan, ...)                    the last three lines at once

Points are (n, 3) float32, processed by PCL. C-ordered float32 arrays are not copied, float64 arrays and sequences are
converted, and other dtypes are rejected. All errors are ValueError. model: the number of one of the four published
variants, or any sonar's model, such as rov.sonar.model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core

MODELS: Mapping[int, _core.MultibeamModel] = MappingProxyType({n: _core.multibeam_model(n) for n in (1, 2, 3, 4)})
"""The four EM 2040 variants of the published wire: 600 kHz single, 700 kHz single, 600 kHz dual, 700 kHz dual swath.

Each has beams, field_of_view_rad, angle_min_rad, angle_increment_rad, and two ranges: range_max_m (95 or 55), which
stands for a beam without echo, and range_limit_m (94.9 or 54.9), which is the LaserScan's range_max and above which the
decoder interprets a value as no echo.
"""

CONFIDENCE = 1.96
"""Half-width of the 95 % interval of a normal distribution, in standard deviations."""
HORIZONTAL_CONFIDENCE = 2.45
"""Radius of the circle that holds 95 % of a normal distribution in two dimensions, in standard deviations of one."""

REACH, AGREEING, NOISE_M, STEEPEST_RAD = 4, 3, 0.1, math.radians(83.0)
"""Settings of `reject_outliers` (assumed); in the valley, they retain 99.7 % of a gate's echoes in physics mode."""


NO_INTENSITIES = np.empty(0, dtype=np.float32)


@dataclass(frozen=True, eq=False)
class LaserScan:
    """A ping as a sensor_msgs/LaserScan, with the message's field names; angles in rad, times in s, ranges in m.

    Beam i points along angle_min + i * angle_increment in the x-y plane of frame_id, from +x towards +y. ranges:
    (beams,) float32, inf if there is no echo. intensities: (beams,) or empty.
    """

    frame_id: str
    stamp_s: float
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: NDArray[np.float32]
    intensities: NDArray[np.float32] = field(default_factory=lambda: NO_INTENSITIES)


def encode_depth_string(ranges_m: ArrayLike, model: int | _core.MultibeamModel = 2) -> str:
    """Return the published `depthArray` text of one ping: each range formatted as a C# float, each followed by "a".

    ranges_m: (beams,) float32 in [0, range_max_m of the model], or inf, which is written as range_max_m.
    """
    variant = _variant(model)
    return _core.encode_depth_string(_beams(ranges_m, variant), variant.range_max_m)


def decode_depth_string(text: str, model: int | _core.MultibeamModel = 2) -> NDArray[np.float32]:
    """Return the ranges in a `depthArray` text, (beams,) float32.

    As published, a value above the model's range_limit_m means no echo and becomes inf. Raises ValueError, which names
    the beam, unless the text has one plain decimal for each of the model's beams, each followed by "a".
    """
    variant = _variant(model)
    if not isinstance(text, str):
        raise ValueError(f"text is {type(text).__name__}: must be a str")
    return _core.decode_depth_string(text, variant.beams, variant.range_limit_m)


def to_laser_scan(
    ranges_m: ArrayLike, model: int | _core.MultibeamModel = 2, stamp_s: float = 0.0, *, ping_interval_s: float = 0.1
) -> LaserScan:
    """Return the LaserScan of one ping, in `base_scan`. All beams have the same time: time_increment is 0.

    ranges_m: (beams,) float32. ping_interval_s: time between pings, the message's scan_time.
    """
    variant = _variant(model)
    ranges = _ranges(ranges_m, variant)
    if not math.isfinite(stamp_s):
        raise ValueError(f"scan.stamp_s = {stamp_s} s: must be finite")
    if not (math.isfinite(ping_interval_s) and ping_interval_s > 0.0):
        raise ValueError(f"scan.ping_interval_s = {ping_interval_s} s: must be positive")
    return scan_of_decoded(ranges, variant, stamp_s, ping_interval_s)


def scan_of_decoded(
    ranges_m: NDArray[np.float32], model: _core.MultibeamModel, stamp_s: float, ping_interval_s: float = 0.1
) -> LaserScan:
    """Return the LaserScan of a ping, like `to_laser_scan`, from ranges as returned by decode_depth_string."""
    first_rad = model.angle_min_rad
    return LaserScan(
        frame_id="base_scan",
        stamp_s=stamp_s,
        angle_min=first_rad,
        angle_max=-first_rad,
        angle_increment=model.angle_increment_rad,
        time_increment=0.0,
        scan_time=ping_interval_s,
        range_min=0.0,
        range_max=model.range_limit_m,
        ranges=ranges_m,
    )


def to_point_cloud(scan: LaserScan) -> NDArray[np.float32]:
    """Return the scan's echoes as points in its frame, (n, 3) float32, in beam order.

    As in laser_geometry, a range counts if range_min <= range < range_max.
    """
    return _core.scan_to_points(scan.ranges, scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)


def to_world(
    scan: LaserScan,
    box_min_m: ArrayLike,
    box_max_m: ArrayLike,
    world_from_body: ArrayLike,
    world_from_sonar: ArrayLike,
) -> NDArray[np.float32]:
    """Return the scan's echoes in the world, (n, 3) float32, without those inside a box in the body frame.

    The same as the functions below, whose clouds it keeps in one place:

        points_sonar_m = filter_range(to_point_cloud(scan), scan.range_min, scan.range_max)
        points_body_m = transform_points(points_sonar_m, relative_transform(world_from_body, world_from_sonar))
        points_world_m = transform_points(remove_box(points_body_m, box_min_m, box_max_m), world_from_body)
    """
    return _core.scan_to_world(
        scan.ranges, scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, box_min_m, box_max_m,
        world_from_body, world_from_sonar,
    )  # fmt: skip


def place_deviation_m(ping: object) -> NDArray[np.float32] | None:
    """Return the standard deviation of each echo's position, combining vertical and horizontal errors, (beams,).

    ping: a _core.PhysicsPing, or an object that forwards its attributes. Returns None for any other ping, as in
    geometry mode, where the deviation is unknown.
    """
    vertical_m = getattr(ping, "vertical_deviation_m", None)
    if vertical_m is None:
        return None
    deviation_m: NDArray[np.float32] = np.hypot(vertical_m, ping.horizontal_deviation_m)  # type: ignore[attr-defined]
    return deviation_m


def reject_uncertain(ranges_m: ArrayLike, deviation_m: ArrayLike, max_uncertainty_m: float) -> NDArray[np.float32]:
    """Replace ranges with inf where an echo's position is uncertain by more than max_uncertainty_m at 95 % confidence.

    ranges_m, deviation_m: (beams,), as in a ping in physics mode and as `place_deviation_m` returns; the uncertainty is
    CONFIDENCE standard deviations, as in IHO S-44. The sonar head applies this before it sends ranges, as real
    instruments do with their quality factors.
    """
    if not max_uncertainty_m > 0.0:  # false for nan, too
        raise ValueError(f"max_uncertainty_m = {max_uncertainty_m} m: must be positive")
    ranges, deviations = np.asarray(ranges_m, np.float32), np.asarray(deviation_m)
    if ranges.shape != deviations.shape:
        raise ValueError(f"deviation_m.shape = {deviations.shape}: must be that of ranges_m, {ranges.shape}")
    return np.where(CONFIDENCE * deviations <= max_uncertainty_m, ranges, np.float32(np.inf))


def reject_outliers(scan: LaserScan) -> LaserScan:
    """Replace outliers along the swath, such as false detections, with inf. An outlier agrees with too few neighbours.

    A neighbour k beams away agrees if the two ranges differ by at most NOISE_M plus the difference that a plane at
    STEEPEST_RAD causes: |r_i - r_j| <= NOISE_M + k angle_increment tan(STEEPEST_RAD) min(r_i, r_j). A range is kept if
    AGREEING of its REACH neighbours on either side agree, so an object hit by at least AGREEING + 1 beams is also kept.
    """
    ranges = scan.ranges
    nearby = np.lib.stride_tricks.sliding_window_view(np.pad(ranges, REACH, constant_values=np.inf), 2 * REACH + 1)
    beams_away = np.abs(np.arange(-REACH, REACH + 1))
    slope = abs(scan.angle_increment) * math.tan(STEEPEST_RAD)
    own = ranges[:, None]
    with np.errstate(invalid="ignore"):  # inf - inf is NaN for two beams without echo
        agrees = np.abs(nearby - own) <= NOISE_M + slope * beams_away * np.minimum(nearby, own)
    needed = min(AGREEING, (len(ranges) - 1) // 2)
    kept = agrees.sum(axis=1) > needed  # a range agrees with itself
    return replace(scan, ranges=np.where(kept, ranges, np.float32(np.inf)))


def transform_points(points_source_m: ArrayLike, target_from_source: ArrayLike) -> NDArray[np.float32]:
    """Return points in another frame, (n, 3) float32.

    target_from_source: (4, 4), rigid, such as ping.world_from_sonar. Rounding to float32 moves coordinates by up to 2
    um at 50 m from the origin, and 0.2 mm at 4 km.
    """
    return _core.transform_points(points_source_m, target_from_source)


def relative_transform(world_from_target: ArrayLike, world_from_source: ArrayLike) -> NDArray[np.float64]:
    """Return target_from_source, (4, 4), from two rigid transforms: inverse(world_from_target) @ world_from_source."""
    return _core.relative_transform(world_from_target, world_from_source)


def filter_range(points_m: ArrayLike, min_m: float, max_m: float) -> NDArray[np.float32]:
    """Return the points (n, 3) whose distance to the frame's origin is in [min_m, max_m]."""
    return _core.filter_range(points_m, min_m, max_m)


def remove_box(points_m: ArrayLike, box_min_m: ArrayLike, box_max_m: ArrayLike) -> NDArray[np.float32]:
    """Return the points (n, 3) outside a closed, axis-aligned box: a self filter in the body frame.

    box_min_m, box_max_m: (3,), opposite corners.
    """
    return _core.remove_box(points_m, box_min_m, box_max_m)


def _variant(model: int | _core.MultibeamModel) -> _core.MultibeamModel:
    if isinstance(model, _core.MultibeamModel):
        return model
    if isinstance(model, int | np.integer) and not isinstance(model, bool) and model in MODELS:
        return MODELS[int(model)]
    raise ValueError(f"sonar.model = {model!r}: must be one of {', '.join(map(str, MODELS))}")


def _beams(ranges_m: ArrayLike, variant: _core.MultibeamModel) -> NDArray[np.floating | np.integer]:
    """Return ranges as an array with one number for each beam. Raises ValueError."""
    ranges = np.asarray(ranges_m)
    is_accepted = ranges.dtype in (np.float32, np.float64) or (
        not isinstance(ranges_m, np.ndarray) and ranges.dtype.kind in "iu"
    )
    if not is_accepted:
        raise ValueError(f"ranges_m.dtype = {ranges.dtype}: must be float32, float64 or a sequence of numbers")
    if ranges.shape != (variant.beams,):
        raise ValueError(
            f"ranges_m.shape = {ranges.shape}: must be ({variant.beams},) for model {variant.number or variant.name}"
        )
    return ranges


def _ranges(ranges_m: ArrayLike, variant: _core.MultibeamModel) -> NDArray[np.float32]:
    ranges = _beams(ranges_m, variant)
    (too_far,) = (np.isfinite(ranges) & (ranges > variant.range_max_m)).nonzero()
    if len(too_far):
        beam = int(too_far[0])
        rule = f"must be in [0, {variant.range_max_m:g}] m, or inf for a beam without echo"
        raise ValueError(f"ranges_m[{beam}] = {ranges[beam]} m: {rule}")
    return np.ascontiguousarray(ranges, dtype=np.float32)
