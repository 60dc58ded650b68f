"""Generate assets/meshes/bluerov2.glb and bluerov2_heavy.glb, Blue Robotics' ROV; needs manifold3d and trimesh.

bluerov2_heavy.obj is the same without colours, for the native tests and for `uwsim vehicle decompose`.

Metres; x forward, y left, z up; 0.457 x 0.338 x 0.254 m, heavy 0.575 m across. The hull is everything that displaces
water (tubes, foam, thrusters, side plates and ballast), united into a closed solid. Thruster positions are those in
the vehicle files.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import Manifold
from solids import Colour, Point, ball, box, hull, rod, united, united_by_colour, write_glb, write_obj

ASSETS = Path(__file__).resolve().parents[2] / "assets"
SIDES = (-1, 1)
BLACK, BLUE, DARK, METAL, DOME = (
    (0.012, 0.012, 0.014),  # plates and thrusters
    (0.0, 0.12, 0.33),  # fairings
    (0.035, 0.037, 0.042),  # anodised tubes
    (0.34, 0.35, 0.37),  # flanges
    (0.13, 0.18, 0.21),  # acrylic
)  # linear; as on photographs of the vehicle
Parts = dict[Colour, list[Manifold]]
LENGTH_M, HEIGHT_M = 0.457, 0.254
LOW_M, HIGH_M = -0.127, 0.127


def thruster(at: Point, axis: Point) -> Manifold:
    """Return a T200 thruster: nozzle, motor pod and mounting bar, 0.1 m across and 0.09 m long."""
    direction = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    across = np.cross(direction, (0.0, 0.0, 1.0) if abs(direction[2]) < 0.5 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)

    def along(low: float, high: float, radius: float, sides: int) -> Manifold:
        return rod(tuple(at + low * direction), tuple(at + high * direction), radius, sides)

    nozzle = along(-0.025, 0.025, 0.05, 8) - along(-0.05, 0.05, 0.041, 8)
    pod = along(-0.045, 0.045, 0.019, 6)
    ring = 0.046 * across
    bar = rod(tuple(at + 0.012 * direction - ring), tuple(at + 0.012 * direction + ring), 0.006, 4)
    return united([nozzle, pod, bar])


def plate(outline: list[tuple[float, float]], y: float, thickness: float) -> Manifold:
    """Return a plate perpendicular to y with a convex outline in x and z."""
    return hull([(x, side, z) for side in (y - thickness / 2, y + thickness / 2) for x, z in outline])


def side_panel(y: float) -> Manifold:
    """Return a side of the frame: a bevelled plate with three windows, and its foot."""
    end, bevel = LENGTH_M / 2, 0.05
    outline = [
        (x * (end - inset), z) for x in SIDES for inset, z in ((0, 0.02), (bevel, HIGH_M - 0.02), (0, LOW_M + 0.02))
    ]
    outline += [(x * (end - 0.02), LOW_M) for x in SIDES]
    panel = plate(outline, y, 0.012)
    for x in (-0.14, 0.0, 0.14):
        panel -= box((x - 0.052, y - 0.02, -0.05), (x + 0.052, y + 0.02, 0.045))
    return panel + box((-end + 0.02, y - 0.012, LOW_M), (end - 0.02, y + 0.012, LOW_M + 0.03))


def tubes() -> Parts:
    """Return the electronics tube with its dome in front, the battery below, and their cradles."""
    flanges = [rod((low, 0, 0.03), (low + 0.02, 0, 0.03), 0.062, 10) for low in (-0.175, 0.135)]
    cylinders = [
        rod((-0.16, 0, 0.03), (0.15, 0, 0.03), 0.057, 10),
        rod((-0.13, 0, -0.072), (0.13, 0, -0.078), 0.0445, 8),
    ]
    cradles = [
        *(box((x - 0.009, -0.16, -0.04), (x + 0.009, 0.16, -0.022)) for x in (-0.07, 0.07)),
        *(box((x - 0.009, -0.165, LOW_M), (x + 0.009, 0.165, LOW_M + 0.02)) for x in (-0.15, 0.15)),
        *(box((x - 0.009, -0.03, -0.05), (x + 0.009, 0.03, 0.0)) for x in (-0.07, 0.07)),
    ]
    return {METAL: flanges, DARK: cylinders, DOME: [ball((0.15, 0, 0.03), 0.052, 8)], BLACK: cradles}


def fairing(x: float, y: float) -> Manifold:
    """Return a quarter of the top foam with its bevelled fairing."""
    near, far, low = 0.064, 0.158, 0.086
    ends = (0.045, 0.215)
    points = [(x * e, y * s, low) for e in ends for s in (near, far)]
    points += [(x * e, y * s, HIGH_M - 0.03) for e in ends for s in (near, far)]
    points += [(x * e, y * s, HIGH_M) for e in (ends[0], ends[1] - 0.04) for s in (near, far - 0.03)]
    return hull(points)


def horizontal_thrusters() -> list[Manifold]:
    """Return four thrusters, turned outward by 45 degrees."""
    return [thruster((x, y * 0.092, 0.0), (1 if x < 0 else -1, y, 0)) for x in (0.14, -0.15) for y in SIDES]


def frame() -> Parts:
    """Return side panels, fairings, tubes and horizontal thrusters."""
    inside = tubes()
    black = [*(side_panel(y * 0.163) for y in SIDES), *inside.pop(BLACK), *horizontal_thrusters()]
    return {**inside, BLUE: [fairing(x, y) for x in SIDES for y in SIDES], BLACK: black}


def verticals() -> list[Manifold]:
    """Return two vertical thrusters in the gap between the fairings, with their brackets."""
    parts = [thruster((0, y * 0.111, 0.07), (0, 0, 1)) for y in SIDES]
    return [*parts, *(box((-0.05, y * 0.111 - 0.006, 0.052), (0.05, y * 0.111 + 0.006, 0.064)) for y in SIDES)]


def heavy_sides() -> Parts:
    """Return two vertical thrusters per side, in a deck outside the panels, with foam between them."""
    parts: Parts = {BLACK: [], BLUE: []}
    for y in SIDES:
        inner, outer = y * 0.165, y * 0.2865
        deck = hull([(x * e, s, z) for x in SIDES for e, s in ((0.2, inner), (0.16, outer)) for z in (0.056, 0.07)])
        for x in SIDES:
            deck -= rod((x * 0.118, y * 0.215, 0.0), (x * 0.118, y * 0.215, 0.12), 0.0455, 8)
            parts[BLACK].append(thruster((x * 0.118, y * 0.215, 0.064), (0, 0, 1)))
        foam = hull(
            [
                (x * e, s, z)
                for x in SIDES
                for e, s, z in (
                    (0.05, inner, 0.04),
                    (0.045, outer, 0.045),
                    (0.05, inner, 0.1),
                    (0.045, outer, 0.085),
                )
            ]
        )
        parts[BLACK].append(deck)
        parts[BLUE].append(foam)
    return parts


def write(name: str, *parts: Parts) -> Manifold:
    """Write the union of parts, in their colours, and return it."""
    by_colour = {colour: [each for some in parts for each in some.get(colour, [])] for colour in parts[0]}
    solid, colours = united_by_colour(by_colour)
    write_glb(solid, colours, ASSETS / "meshes" / name)
    return solid


def main() -> None:
    """Write both meshes."""
    write("bluerov2.glb", frame(), {BLACK: verticals()})
    middle = box((-0.04, -0.165, 0.06), (0.04, 0.165, 0.075))
    heavy = write("bluerov2_heavy.glb", frame(), {BLACK: [middle]}, heavy_sides())
    write_obj(heavy, ASSETS / "meshes" / "bluerov2_heavy.obj", "made by tools/assets/make_bluerov2.py; metres, z up")


if __name__ == "__main__":
    main()
