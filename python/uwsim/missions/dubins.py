"""The shortest path between two poses in the plane for a vehicle that moves forwards and turns with a least radius.

It consists of three pieces, each an arc to port (L), an arc to starboard (R) or a straight line (S): LSL, RSR, LSR,
RSL, RLR or LRL (Dubins 1957, Am. J. Math. 79:497). Their lengths are the closed forms of Shkel and Lumelsky 2001,
"Classification of the Dubins set", Robotics and Autonomous Systems 34:179.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Pose2 = tuple[float, float, float]
"""x and y [m], and heading [rad], counterclockwise from the x axis."""
TURN = 2.0 * math.pi
TURNS = {"L": 1.0, "S": 0.0, "R": -1.0}
"""The curvature of each kind of piece, in units of the largest."""


def dubins_pieces(start: Pose2, end: Pose2, radius_m: float) -> list[tuple[str, float]]:
    """Return the kind and the length [m] of each of the three pieces of the shortest path."""
    (x, y, heading), (to_x, to_y, to_heading) = start, end
    bearing = math.atan2(to_y - y, to_x - x)
    distance = math.dist((x, y), (to_x, to_y)) / radius_m
    words = _words(distance, (heading - bearing) % TURN, (to_heading - bearing) % TURN)
    word, lengths = min(words, key=lambda found: sum(found[1]))
    return [(kind, length * radius_m) for kind, length in zip(word, lengths, strict=True)]


def dubins_points(start: Pose2, end: Pose2, radius_m: float, step_m: float = 0.5) -> NDArray[np.float64]:
    """Return points (n, 2) along the shortest path, at most step_m apart, from start to end."""
    x, y, heading = start
    points = [np.array([[x, y]])]
    for kind, length_m in dubins_pieces(start, end, radius_m):
        curvature = TURNS[kind] / radius_m
        along = np.linspace(0.0, length_m, max(1, math.ceil(length_m / step_m)) + 1)[1:]
        if curvature:
            turned = heading + curvature * along
            east = x + (np.sin(turned) - math.sin(heading)) / curvature
            north = y - (np.cos(turned) - math.cos(heading)) / curvature
        else:
            east, north = x + along * math.cos(heading), y + along * math.sin(heading)
        points.append(np.stack([east, north], axis=1))
        x, y, heading = float(east[-1]), float(north[-1]), heading + curvature * length_m
    return np.concatenate(points)


def _words(d: float, a: float, b: float) -> Iterator[tuple[str, tuple[float, float, float]]]:
    """Yield each possible word with the lengths of its pieces in radii.

    d: distance in radii. a, b: headings at start and end, from the bearing of the end.
    """
    sin_a, cos_a, sin_b, cos_b, cos_ab = math.sin(a), math.cos(a), math.sin(b), math.cos(b), math.cos(a - b)
    if (square := 2.0 + d * d - 2.0 * cos_ab + 2.0 * d * (sin_a - sin_b)) >= 0.0:
        angle = math.atan2(cos_b - cos_a, d + sin_a - sin_b)
        yield "LSL", ((angle - a) % TURN, math.sqrt(square), (b - angle) % TURN)
    if (square := 2.0 + d * d - 2.0 * cos_ab + 2.0 * d * (sin_b - sin_a)) >= 0.0:
        angle = math.atan2(cos_a - cos_b, d - sin_a + sin_b)
        yield "RSR", ((a - angle) % TURN, math.sqrt(square), (angle - b) % TURN)
    if (square := d * d - 2.0 + 2.0 * cos_ab + 2.0 * d * (sin_a + sin_b)) >= 0.0:
        straight = math.sqrt(square)
        angle = math.atan2(-cos_a - cos_b, d + sin_a + sin_b) - math.atan2(-2.0, straight)
        yield "LSR", ((angle - a) % TURN, straight, (angle - b) % TURN)
    if (square := d * d - 2.0 + 2.0 * cos_ab - 2.0 * d * (sin_a + sin_b)) >= 0.0:
        straight = math.sqrt(square)
        angle = math.atan2(cos_a + cos_b, d - sin_a - sin_b) - math.atan2(2.0, straight)
        yield "RSL", ((a - angle) % TURN, straight, (b - angle) % TURN)
    if abs(cosine := (6.0 - d * d + 2.0 * cos_ab + 2.0 * d * (sin_a - sin_b)) / 8.0) <= 1.0:
        middle = TURN - math.acos(cosine)
        first = (a - math.atan2(cos_a - cos_b, d - sin_a + sin_b) + 0.5 * middle) % TURN
        yield "RLR", (first, middle, (a - b - first + middle) % TURN)
    if abs(cosine := (6.0 - d * d + 2.0 * cos_ab + 2.0 * d * (sin_b - sin_a)) / 8.0) <= 1.0:
        middle = TURN - math.acos(cosine)
        first = (math.atan2(cos_b - cos_a, d + sin_a - sin_b) - a + 0.5 * middle) % TURN
        yield "LRL", (first, middle, (b - a - first + middle) % TURN)
