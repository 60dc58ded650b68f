"""Models of lenses, as in OpenCV and ROS: the pixel at which a lens shows a ray, and the rays that it can show.

A ray is x = X/Z, y = Y/Z in the optical frame (x right, y down, z ahead). The lens bends it to x', y', and shows it at
u = fx x' + cx, v = fy y' + cy [pixels]. The number of coefficients d names the model; with r^2 = x^2 + y^2:

- plumb_bob, d = k1 k2 p1 p2 k3 (Brown 1971, "Close-range camera calibration"):
  x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' likewise;
- rational_polynomial, d = k1 k2 p1 p2 k3 k4 k5 k6 (OpenCV's CALIB_RATIONAL_MODEL): the same, with the radial factor
  divided by 1 + k4 r^2 + k5 r^4 + k6 r^6;
- equidistant, d = k1 k2 k3 k4 (Kannala and Brandt 2006, "A generic camera model and calibration method for
  conventional, wide-angle, and fish-eye lenses", IEEE TPAMI 28:1335; OpenCV's fisheye), for the angle a = atan r:
  r' = a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8).
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats

COEFFICIENTS = {
    "plumb_bob": ("k1", "k2", "p1", "p2", "k3"),
    "rational_polynomial": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
    "equidistant": ("k1", "k2", "k3", "k4"),
}
"""The coefficients of each model, under ROS's names, in OpenCV's order."""
ALIASES = {"fisheye": "equidistant", "radtan": "plumb_bob", "brown_conrady": "plumb_bob"}
WIDEST_DEG = 89.0
"""The largest angle to the axis of a ray that x and y can represent well."""


def coefficients(model: str, given: Sequence[float]) -> tuple[str, tuple[float, ...]]:
    """Return a calibration's model and all of its coefficients; those left out at the end are 0.

    model: one of COEFFICIENTS or ALIASES; "" for one that 5 or 8 coefficients name. Coefficients beyond the eighth, of
    thin prisms and tilted sensors, must be 0. A plumb_bob with k4 k5 k6, as old files have, is a rational_polynomial,
    and one of these without them a plumb_bob. Raises ValueError.
    """
    values = [float(value) for value in given]
    while len(values) > 8 and values[-1] == 0.0:
        values.pop()
    name = ALIASES.get(model, model) or ("plumb_bob" if len(values) <= 5 else "rational_polynomial")
    if name not in COEFFICIENTS:
        raise ValueError(f"distortion_model = {model!r:.40}: must be one of {', '.join(COEFFICIENTS)}")
    if not model and len(values) == 4:
        raise ValueError("distortion_model: missing: 4 coefficients are of plumb_bob or of equidistant")
    if name == "plumb_bob" and len(values) > 5:
        name = "rational_polynomial"
    names = COEFFICIENTS[name]
    if len(values) > len(names):
        raise ValueError(f"{len(given)} coefficients of distortion: {name} has at most {', '.join(names)}")
    values += [0.0] * (len(names) - len(values))
    if name == "rational_polynomial" and not any(values[5:]):
        return "plumb_bob", tuple(values[:5])
    return name, tuple(values)


def bent(d: Sequence[float] | Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return x', y' of rays x, y. d: see above. Raises ValueError unless it has 4, 5 or 8 coefficients."""
    if len(d) == 4:
        k1, k2, k3, k4 = d
        r = np.hypot(x, y)
        a2 = np.arctan(r) ** 2
        near = np.where(r > 1e-8, np.arctan(r) / np.maximum(r, 1e-8), 1.0)
        factor = near * (1 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
        return x * factor, y * factor
    if len(d) not in (5, 8):
        raise ValueError(f"d = {len(d)} coefficients: must be 4 (equidistant), 5 (plumb_bob) or 8 (rational)")
    k1, k2, p1, p2, k3 = d[:5]
    r2 = x * x + y * y
    radial: Any = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    if len(d) == 8:
        radial = radial / (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])))
    bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return bent_x, bent_y


def project(k: Floats, d: Sequence[float] | Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the pixels u, v at which the lens with the matrix k (3, 3) shows rays x, y. Raises ValueError as `bent`.

    Rays beyond `largest_angle` have pixels, too, perhaps in the picture, where the lens does not show them.
    """
    bent_x, bent_y = bent(d, x, y)
    return k[0, 0] * bent_x + k[0, 2], k[1, 1] * bent_y + k[1, 2]


def largest_angle(d: Sequence[float] | Floats) -> tuple[float, float]:
    """Return the angle to the axis [rad] up to which rays farther out are shown farther out, and its r'.

    Beyond it, the distortion folds the picture over itself, so that no ray is shown there. At most WIDEST_DEG.
    """
    return _largest_angle(tuple(float(value) for value in d))


def shows(d: Sequence[float] | Floats, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return whether the lens shows rays x, y, in a picture that is large enough."""
    return np.asarray(np.hypot(x, y) <= np.tan(largest_angle(d)[0]))


def resized(
    fx: float, fy: float, cx: float, cy: float, *, size: tuple[int, int], to: tuple[int, int]
) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy for a picture of another width and height with the same field of view across the width.

    The pixels keep their shape, and the rows are cut, or added, at both ends: pixel centres have whole coordinates.
    """
    scale = to[0] / size[0]
    middle = 0.5 * (to[1] - 1) + scale * (cy - 0.5 * (size[1] - 1))
    return scale * fx, scale * fy, scale * (cx + 0.5) - 0.5, middle


@functools.lru_cache(maxsize=256)
def _largest_angle(d: tuple[float, ...]) -> tuple[float, float]:
    angles = np.radians(np.linspace(0.0, WIDEST_DEG, 1781))[1:, None]
    around = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    across, down = np.cos(around), np.sin(around)
    with np.errstate(all="ignore"):  # a rational factor may divide by 0
        x, y = bent(d, np.tan(angles) * across, np.tan(angles) * down)
        outward = x * across + y * down
        grows = np.asarray((np.diff(outward, axis=0, prepend=0.0) > 0.0).all(axis=1))
    last = max((len(grows) if grows.all() else int(grows.argmin())) - 1, 0)
    return float(angles[last, 0]), float(outward[last].min())
