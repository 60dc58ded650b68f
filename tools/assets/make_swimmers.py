"""Generate the meshes of bodies on paths, a diver, a seal and a workboat; needs manifold3d and trimesh.

Metres, x ahead, z up. The diver and the seal swim level, their origin in their middle; the boat's is on its waterline.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from manifold3d import Manifold
from solids import Colour, Point, ball, box, hull, rod, united_by_colour, write_glb

MESHES = Path(__file__).resolve().parents[2] / "assets" / "meshes"
NEOPRENE: Colour = (0.03, 0.035, 0.045)
SKIN: Colour = (0.55, 0.36, 0.26)
STEEL: Colour = (0.62, 0.60, 0.10)
FINS: Colour = (0.05, 0.22, 0.45)
GLASS: Colour = (0.10, 0.14, 0.16)
FUR: Colour = (0.14, 0.13, 0.12)
WHITE: Colour = (0.75, 0.75, 0.72)
RED: Colour = (0.35, 0.05, 0.03)
GREY: Colour = (0.25, 0.26, 0.27)


def limb(points: list[Point], radii: list[float], sides: int = 10) -> Manifold:
    """Return a limb: balls along a line, each joined with the next by their convex hull."""
    balls = [ball(point, radius, sides) for point, radius in zip(points, radii, strict=True)]
    whole = Manifold()
    for a, b in pairwise(balls):
        whole += Manifold.batch_hull([a, b])
    return whole


def diver() -> dict[Colour, list[Manifold]]:
    """Return a scuba diver who swims with a stroke of the legs, 2.3 m from the hands to the fins."""
    trunk = limb([(0.42, 0, 0.0), (0.2, 0, -0.01), (-0.12, 0, 0.0)], [0.15, 0.16, 0.14], 14).scale((1, 1.25, 0.85))
    suit, skin, fins = [trunk], [ball((0.72, 0, 0.03), 0.115, 14)], []
    suit.append(limb([(0.56, 0, 0.0), (0.66, 0, 0.01)], [0.075, 0.07]))
    for side, lift in ((1, 0.10), (-1, -0.12)):
        arm = [(0.44, 0.2 * side, -0.02), (0.55, 0.27 * side, -0.2), (0.80, 0.16 * side, -0.24)]
        suit.append(limb(arm, [0.065, 0.05, 0.04]))
        skin.append(limb([arm[-1], (0.89, 0.13 * side, -0.24)], [0.042, 0.035]))
        leg = [(-0.15, 0.10 * side, 0.0), (-0.58, 0.11 * side, 0.5 * lift - 0.02), (-0.98, 0.11 * side, lift)]
        suit.append(limb(leg, [0.095, 0.07, 0.05]))
        heel, z = (-1.0, 0.11 * side), lift
        blade = [(heel[0], heel[1] + w, z + h) for w in (-0.06, 0.06) for h in (-0.025, 0.025)]
        blade += [(-1.62, heel[1] + w, z + 0.5 * lift + h) for w in (-0.12, 0.12) for h in (-0.006, 0.006)]
        fins.append(hull(blade))
    tank = [limb([(0.42, 0, 0.23), (-0.12, 0, 0.22)], [0.09, 0.09], 14), rod((0.5, 0, 0.23), (0.58, 0, 0.23), 0.03)]
    mask = [box((0.79, -0.09, -0.01), (0.85, 0.09, 0.09))]
    weights = [box((-0.2, -0.19, -0.15), (-0.08, 0.19, -0.08))]
    return {NEOPRENE: suit, SKIN: skin, STEEL: tank, FINS: fins, GLASS: [*mask, *weights]}


def seal() -> dict[Colour, list[Manifold]]:
    """Return a harbour seal, 1.6 m long."""
    x = [0.74, 0.62, 0.46, 0.22, -0.05, -0.32, -0.56, -0.70]
    r = [0.055, 0.11, 0.13, 0.21, 0.235, 0.18, 0.10, 0.05]
    z = [0.02, 0.03, 0.02, 0.0, 0.0, 0.01, 0.02, 0.02]
    trunk = limb([(a, 0.0, c) for a, c in zip(x, z, strict=True)], r, 18)
    dark = [ball((0.795, 0, 0.03), 0.03, 8)]
    flippers = []
    for side in (1, -1):
        dark.append(ball((0.69, 0.07 * side, 0.085), 0.022, 8))
        root, tip = (0.26, 0.16 * side, -0.08), (0.02, 0.38 * side, -0.17)
        flippers.append(limb([root, (0.12, 0.30 * side, -0.14), tip], [0.06, 0.05, 0.02]).scale((1, 1, 1)))
        tail = [(-0.68, 0.01 * side, 0.0), (-0.68, 0.03 * side, 0.06), (-0.70, 0.05 * side, -0.01)]
        tail += [(-0.92, 0.07 * side, 0.13), (-0.95, 0.12 * side, 0.02), (-0.92, 0.07 * side, -0.08)]
        flippers.append(hull(tail))
    return {FUR: [trunk, *flippers], GLASS: dark}


def boat() -> dict[Colour, list[Manifold]]:
    """Return a workboat, 7 m long and 2.4 m wide, that draws 0.45 m."""
    stations = np.array([-3.5, -2.0, 0.0, 1.6, 2.8, 3.5])
    beam = np.array([1.1, 1.2, 1.2, 1.05, 0.6, 0.06])
    keel = np.array([-0.38, -0.42, -0.45, -0.42, -0.25, 0.15])

    def slices(low: float, high: float, grow: float) -> Manifold:
        whole = Manifold()
        for a in range(len(stations) - 1):
            corners: list[Point] = []
            for k in (a, a + 1):
                x, half, foot = float(stations[k]), float(beam[k]) * grow, float(keel[k])
                bottom = max(foot, low)
                wide = 0.12 if bottom == foot else 0.9
                corners += [(x, wide * half, bottom), (x, -wide * half, bottom), (x, half, high), (x, -half, high)]
                if low < 0 and foot < -0.1:
                    corners += [(x, 0.85 * half, -0.12), (x, -0.85 * half, -0.12)]
            whole += hull(corners)
        return whole

    below, above = slices(-1.0, 0.12, 1.0), slices(0.1, 0.75, 1.02)
    well = box((-3.2, -0.95, 0.3), (-0.7, 0.95, 1.0))
    cabin = [box((-0.6, -0.75, 0.7), (1.3, 0.75, 1.9)), box((-0.7, -0.85, 1.88), (1.4, 0.85, 1.96))]
    engine = [box((-3.85, -0.2, -0.1), (-3.5, 0.2, 0.95)), rod((-3.68, 0, -0.1), (-3.68, 0, -0.75), 0.07)]
    engine += [
        rod((-3.9, 0, -0.65), (-3.5, 0, -0.65), 0.1),
        hull(
            [(-3.6, y, z) for y in (-0.02, 0.02) for z in (-0.9, -0.6)]
            + [(-3.75, y, z) for y in (-0.02, 0.02) for z in (-0.85, -0.6)]
        ),
    ]
    return {RED: [below], WHITE: [above - well, *cabin], GREY: engine}


def main() -> None:
    """Write the three meshes."""
    for name, parts in (("diver", diver()), ("seal", seal()), ("boat", boat())):
        solid, colours = united_by_colour(parts)
        write_glb(solid, colours, MESHES / f"{name}.glb")


if __name__ == "__main__":
    main()
