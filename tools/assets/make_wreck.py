"""Generate the wreck of the scenario `wreck`, and a tyre; needs manifold3d and trimesh.

Metres, z up, the keel at z = 0. A coaster of riveted steel, 36 m long, has broken abaft its hold: the stern lies to
starboard of the bow and lists. Plates, decks and bulkheads are 0.12 m thick, thicker than any ship's, so that a mesh of
few triangles is closed and can be entered.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import Manifold, Mesh
from solids import Point, box, hull, rod, united, write_glb, write_obj

MESHES = Path(__file__).resolve().parents[2] / "assets" / "meshes"
LENGTH_M, BEAM_M, DEPTH_M, PLATE_M = 36.0, 7.4, 4.6, 0.12
BREAK_X = -5.0
STATIONS = np.array([-18.0, -17.2, -15.5, -12.5, -8, -2, 4, 9, 12.5, 15, 16.8, 18])
FULLNESS = np.array([0.30, 0.52, 0.76, 0.92, 1, 1, 1, 0.96, 0.80, 0.54, 0.27, 0.03])
RISE_M = np.array([2.6, 1.9, 1.1, 0.45, 0, 0, 0, 0.02, 0.08, 0.2, 0.4, 0.8])
"""Heights of the keel at the stations."""


def lofted(inset_m: float, top_m: float) -> Manifold:
    """Return the solid inside the hull's plating, which is inset_m thick, up to a height above the sheer."""
    rings = []
    for x, full, rise in zip(STATIONS, FULLNESS, RISE_M, strict=True):
        x = float(np.clip(x, STATIONS[0] + 2 * inset_m, STATIONS[-1] - 6 * inset_m))
        half = max(0.5 * BEAM_M * full - inset_m, 0.02)
        sheer = DEPTH_M + 1.1 * (x / 18) ** 2 + (1.0 if x > 11 else 0.0) + top_m
        turn = np.linspace(0, 0.5 * np.pi, 6)
        bilge = [
            (half * np.sin(a) ** 0.55, rise + inset_m + (2.2 - 0.4 * rise) * (1 - np.cos(a) ** 0.55)) for a in turn
        ]
        side = [*bilge, (half * 1.02, sheer)]
        rings.append([(x, y, z) for y, z in side] + [(x, -y, z) for y, z in reversed(side[1:])])
    count, total = len(rings[0]), len(rings)
    points = np.array(rings, np.float32).reshape(-1, 3)
    ends = np.array([np.mean(rings[0], axis=0), np.mean(rings[-1], axis=0)], np.float32)
    a, k = np.arange((total - 1) * count).reshape(total - 1, count), np.arange(count)
    b = np.roll(a, -1, axis=1)
    wall = np.stack([a, b, b + count, a, b + count, a + count], -1).reshape(-1, 3)
    first = np.column_stack([np.full(count, total * count), np.roll(k, -1), k])
    end = k + (total - 1) * count
    last = np.column_stack([np.full(count, total * count + 1), end, np.roll(end, -1)])
    triangles = np.vstack([wall, first, last])
    return Manifold(Mesh(np.vstack([points, ends]), triangles.astype(np.uint32)))


def blob(random: np.random.Generator, at: Point, size_m: float) -> Manifold:
    """Return an angular lump, to cut holes with or to stand for growth."""
    points = random.normal(size=(9, 3))
    points *= size_m / np.linalg.norm(points, axis=1)[:, None] * random.uniform(0.6, 1.0, (9, 1))
    return hull([tuple(map(float, point)) for point in points]).translate(at)


def plating(random: np.random.Generator) -> Manifold:
    """Return shell, decks, bulkheads and frames, with hatches, doors and the holes of age."""
    inner = lofted(PLATE_M, 2.0)
    shell = lofted(0.0, 0.9) - inner
    decks = [
        box((-18, -4, DEPTH_M - 0.06), (18, 4, DEPTH_M + 0.06)),
        box((11, -4, DEPTH_M + 1.3), (18, 4, DEPTH_M + 1.42)),
    ]
    walls = [box((x - 0.06, -4, 0), (x + 0.06, 4, DEPTH_M)) for x in (-14.5, -6.2, 5.6, 11.0)]
    walls.append(box((10.94, -4, DEPTH_M), (11.06, 4, DEPTH_M + 1.4)))
    ribs = [box((x - 0.05, -4, 0), (x + 0.05, 4, DEPTH_M)) for x in np.arange(-13.2, 14, 1.8)]
    web = (lofted(0.05, 0.0) - lofted(0.30, 0.1)) ^ united(ribs)
    body = united([shell, (united([*decks, *walls]) ^ inner), web])
    doors = [box((x - 0.3, y - 0.7, 0.8), (x + 0.3, y + 0.7, 3.0)) for x, y in ((-6.2, 1.2), (5.6, -1.0), (-14.5, 0.0))]
    doors.append(box((10.7, -0.6, DEPTH_M + 0.1), (11.3, 0.6, DEPTH_M + 1.2)))
    hatches = [
        box((-3.6, -2.1, DEPTH_M - 1), (4.4, 2.1, DEPTH_M + 1)),
        box((7.0, -1.2, DEPTH_M - 1), (9.2, 1.2, DEPTH_M + 1)),
    ]
    ports = [rod((x, -5, DEPTH_M - 1.0), (x, 5, DEPTH_M - 1.0), 0.2, sides=10) for x in (-13.4, -11.8, -10.2, -8.6)]
    places = random.uniform((-15, -3.4, 0.6), (15, 3.4, DEPTH_M), (18, 3))
    rot = [blob(random, (x, float(np.sign(y)) * 3.5, z), random.uniform(0.3, 0.9)) for x, y, z in places]
    return body - united([*doors, *hatches, *ports, *rot])


def house() -> Manifold:
    """Return the bridge on the stern, open at its doors and windows."""
    low = DEPTH_M + 0.05
    outer = box((-15.2, -2.6, low), (-8.4, 2.6, low + 2.5)) + box((-11.8, -2.2, low + 2.4), (-8.6, 2.2, low + 4.6))
    inner = box((-15.1, -2.5, low - 1), (-8.5, 2.5, low + 2.38)) + box((-11.7, -2.1, low + 2.5), (-8.7, 2.1, low + 4.5))
    cuts = [box((-9.0, y, low + 3.2), (-8.2, y + 1.0, low + 4.0)) for y in (-1.9, -0.5, 0.9)]
    cuts += [box((x, -3, low + 0.9), (x + 0.6, 3, low + 1.6)) for x in (-14.4, -13.0, -11.6)]
    cuts += [box((-9.9, -3, low + 0.1), (-9.1, 3, low + 1.9)), box((-11.2, -3, low + 3.2), (-9.6, 3, low + 4.0))]
    return outer - inner - united(cuts)


def fittings() -> tuple[list[Manifold], list[Manifold]]:
    """Return what stands on the bow part, and on the stern part."""
    top = DEPTH_M + 0.05
    mast = [
        rod((5.2, 0, top - 1), (4.4, 1.2, top + 6.8), 0.16, sides=8),
        rod((5.0, 0.3, top + 1.0), (-1.6, 1.6, top + 2.4), 0.1, sides=8),
    ]
    coaming = box((-3.8, -2.3, top - 0.1), (4.6, 2.3, top + 0.5)) - box((-3.6, -2.1, top - 1), (4.4, 2.1, top + 1))
    winch = [
        rod((6.2, -0.9, top + 0.5), (6.2, 0.9, top + 0.5), 0.35, sides=10),
        box((5.9, -1.1, top - 0.1), (6.5, -0.9, top + 0.8)),
    ]
    windlass = [
        rod((13.6, -0.8, top + 1.9), (13.6, 0.8, top + 1.9), 0.3, sides=10),
        box((13.4, -0.2, top + 1.3), (13.8, 0.2, top + 2.0)),
    ]
    rails = [
        rod((x, s * y, top + 1.3), (x, s * y, top + 2.2), 0.035, sides=6)
        for x, y in ((11.5, 2.95), (12.9, 2.5), (14.3, 1.95), (15.7, 1.3))
        for s in (-1, 1)
    ]
    rails += [rod((11.5, s * 2.95, top + 2.2), (15.7, s * 1.3, top + 2.2), 0.035, sides=6) for s in (-1, 1)]
    funnel = rod((-13.4, 0, top + 2.4), (-13.7, 0, top + 4.6), 0.75, sides=14) - rod(
        (-13.4, 0, top + 2.7), (-13.75, 0, top + 5), 0.65, sides=14
    )
    shaft = rod((-18.4, 0, 1.1), (-13, 0, 1.1), 0.14, sides=8)
    blades = [
        box((-18.35, -0.22, 0.15), (-18.2, 0.22, 1.0))
        .rotate((0, 0, 12))
        .translate((18.28, 0, 0))
        .rotate((90 * k, 0, 0))
        .translate((-18.28, 0, 1.1))
        for k in range(4)
    ]
    rudder = box((-19.3, -0.07, 0.4), (-18.6, 0.07, 3.2))
    davits = [rod((x, 2.5, top + 2.4), (x, 3.3, top + 3.6), 0.06, sides=6) for x in (-14.6, -12.6)]
    return [*mast, coaming, *winch, *windlass, *rails], [funnel, shaft, *blades, rudder, *davits]


def wreck() -> Manifold:
    """Return the two parts as they lie, and the scrap between them."""
    random = np.random.default_rng(1917)
    steel, bow_fittings = plating(random), fittings()
    tear = united(
        [
            blob(random, (BREAK_X + random.uniform(-0.8, 0.8), y, z), 1.6)
            for y in np.arange(-3.6, 3.7, 1.8)
            for z in np.arange(0.2, 6.2, 1.6)
        ]
    )
    ahead, astern = box((BREAK_X, -9, -2), (40, 9, 20)), box((-40, -9, -2), (BREAK_X, 9, 20))
    bow = ((steel ^ ahead) - tear) + united(bow_fittings[0])
    stern = (((steel + house()) ^ astern) - tear) + united(bow_fittings[1])
    bow = bow.rotate((9, 2, 0)).translate((0, 0, -0.8))
    stern = stern.translate((-BREAK_X, 0, 0)).rotate((-24, 3, -17)).translate((BREAK_X - 3.2, -2.2, 0.4))
    scrap = [
        blob(random, (BREAK_X + x, y, 0.3), 0.5).scale((1, 1, 0.5))
        for x, y in random.normal((-1.5, -1.0), (1.6, 2.2), (9, 2))
    ]
    beams = [
        rod((BREAK_X - 3 + 0.7 * k, -4 + k, 0.3), (BREAK_X - 1 + k, -1 + 0.6 * k, 0.5 + 0.3 * (k % 3)), 0.09, sides=5)
        for k in range(6)
    ]
    return united([bow, stern, *scrap, *beams]).simplify(0.03)


def tyre() -> Manifold:
    """Return a car's tyre with a hole of its rim's size, lying."""
    return (
        rod((0, 0, -0.1), (0, 0, 0.1), 0.33, sides=28)
        - rod((0, 0, -0.2), (0, 0, 0.2), 0.19, sides=28)
        - (rod((0, 0, -0.075), (0, 0, 0.075), 0.29, sides=28))
    )


def main() -> None:
    """Write the meshes."""
    write_glb(wreck(), {}, MESHES / "wreck.glb")
    write_obj(tyre(), MESHES / "tyre.obj", "made by tools/assets/make_wreck.py; metres, z up")


if __name__ == "__main__":
    main()
