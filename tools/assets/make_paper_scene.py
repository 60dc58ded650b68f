"""Generate the meshes of the scenario `paper`: station and rocks; needs manifold3d and trimesh.

Metres, z up. Dimensions are those of the published simulator's scene (LawnTest.unity) where it defines them; the shapes
are our own.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import Manifold
from solids import Colour, ball, box, hull, rod, united, united_by_colour, write_glb, write_obj

MESHES = Path(__file__).resolve().parents[2] / "assets" / "meshes"
SIDES = (-1, 1)
BED_Z = -42.0
DECK_Z = 5.9
DECK_M = 9.6
"""Half of the deck's side."""
LEG_M = 8.12
"""Half of the distance between the legs' axes."""
PIVOT_M = (9.15, 8.65, -6.4)
"""The middle of the platform at the waterline, seen from the published station's origin, from which it is ranged."""


def rails() -> list[Manifold]:
    """Return the railing round the open part of the deck."""
    top, end = DECK_Z + 1.1, DECK_M - 0.1
    stands = [(x, side * end) for side in SIDES for x in np.arange(0.8, end, 1.25)]
    stands += [(end, y) for y in np.arange(-end, end + 0.1, 1.6) if abs(y) > 1.3]
    parts = [box((x - 0.05, y - 0.05, DECK_Z), (x + 0.05, y + 0.05, top)) for x, y in stands]
    parts += [box((0.2, side * end - 0.08, top - 0.12), (end, side * end + 0.08, top)) for side in SIDES]
    parts += [
        box((end - 0.08, min(a, b), top - 0.12), (end + 0.08, max(a, b), top)) for a, b in ((-end, -1.6), (1.6, end))
    ]
    return parts


def cage() -> list[Manifold]:
    """Return the frame ahead of the deck, open below, in which the vehicle hangs at (12.15, 0, 4.1)."""
    low, high, near, far = DECK_Z - 0.9, DECK_Z - 0.35, DECK_M - 0.2, 15.25
    parts = [box((near, y - 0.25, low), (far, y + 0.25, high)) for y in (-2.2, 2.2)]
    parts += [box((x - 0.25, -2.45, low), (x + 0.25, 2.45, high)) for x in (near + 0.25, far - 0.25)]
    parts += [box((x - 0.04, -2.2, low + 0.1), (x + 0.04, 2.2, low + 0.3)) for x in (11.8, 12.5)]
    return parts


def dish() -> Manifold:
    """Return a bowl that faces up and ahead."""
    bowl = ball((0, 0, 0), 1.7, sides=24) - ball((0, 0, 0.25), 1.65, sides=24)
    bowl -= box((-2, -2, -0.7), (2, 2, 2))
    return (bowl + rod((0, 0, -1.65), (0, 0, 0.1), 0.06, sides=8)).rotate((0, 50, 0)).translate((-1.5, -5.5, 17.0))


def aerial() -> list[Manifold]:
    """Return a mast with crossbars."""
    x, y = -6.5, 5.5
    bars = [
        box((x - 0.04, y - 0.3 * k, 15.5 + 0.55 * k), (x + 0.04, y + 0.3 * k, 15.58 + 0.55 * k)) for k in (5, 4, 3, 2)
    ]
    return [rod((x, y, 14.5), (x, y, 18.6), 0.08, sides=8), *bars]


def station() -> dict[Colour, list[Manifold]]:
    """Return a platform on four legs, with its middle at the waterline as origin."""
    blue, dark, grey = (0.02, 0.10, 0.55), (0.035, 0.035, 0.045), (0.20, 0.19, 0.18)
    orange, red, yellow = (0.85, 0.38, 0.06), (0.52, 0.07, 0.02), (0.70, 0.60, 0.05)
    legs = [rod((x, y, BED_Z), (x, y, DECK_Z - 0.4), 0.5, sides=16) for x in (-LEG_M, LEG_M) for y in (-LEG_M, LEG_M)]
    hut = box((-9.1, -8.7, DECK_Z), (0.1, 7.9, 14.2)) + box((-9.4, -9.0, 14.1), (0.6, 8.2, 14.6))
    lit = [box((0.0, y, z), (0.16, y + 0.9, z + 1.1)) for z in (8.2, 11.2) for y in (-7.4, -5.2, -3.0, 1.4, 3.6, 5.8)]
    lit.append(box((0.0, -1.2, DECK_Z), (0.16, 0.4, DECK_Z + 2.3)))
    return {
        blue: [box((-DECK_M, -DECK_M, DECK_Z - 0.7), (DECK_M, DECK_M, DECK_Z))],
        dark: [*rails(), *legs],
        grey: [hut],
        orange: lit,
        red: [*cage(), *aerial()],
        yellow: [dish(), rod((-1.5, -5.5, 14.5), (-1.5, -5.5, 16.4), 0.15, sides=8)],
    }


def rocks() -> Manifold:
    """Return a field of boulders, 30 m across, on a bed at z = 0."""
    random = np.random.default_rng(33)
    parts = []
    for _ in range(70):
        size = 0.4 + 1.3 * random.random() ** 2
        points = random.normal(size=(14, 3))
        points *= size / np.linalg.norm(points, axis=1)[:, None] * random.uniform(0.7, 1.0, (14, 1))
        x, y = random.normal(scale=6.0, size=2)
        parts.append(hull([tuple(map(float, point)) for point in points]).translate((x, y, 0.2 * size)))
    return united(parts)


def main() -> None:
    """Write the meshes."""
    platform, colours = united_by_colour(station())
    write_glb(platform.translate(PIVOT_M), colours, MESHES / "paper_station.glb")
    write_obj(rocks(), MESHES / "rocks.obj", "made by tools/assets/make_paper_scene.py; metres, z up")


if __name__ == "__main__":
    main()
