"""Generate assets/meshes/rov.obj, an open-frame ROV, and paper_rov.glb, as the paper has it; needs manifold3d, trimesh.

Metres; x forward, y left, z up; 1.2 x 0.8 x 0.7 m. The hull is everything that displaces water (foam block, pods,
thrusters and frame bars), united into a closed solid. The origin is the intended centre of mass, 0.10 m below the
centre of buoyancy.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import Manifold
from solids import Colour, ball, box, centroid, hull, rod, united, united_by_colour, write_glb, write_obj

ASSETS = Path(__file__).resolve().parents[2] / "assets"
SIDES = (-1, 1)
BUOYANCY_ARM_M = 0.10


def foam_block() -> Manifold:
    """Return the top buoyancy foam, with bevelled edges and the wells of two vertical thrusters."""
    bevel = 0.06
    points = []
    for x in SIDES:
        for y in SIDES:
            points += [(x * 0.56, y * (0.40 - bevel), z) for z in (0.15, 0.29)]
            points += [(x * (0.56 - bevel), y * 0.40, z) for z in (0.15, 0.29)]
            points += [(x * (0.56 - bevel), y * (0.40 - bevel), 0.35)]
    block = hull(points)
    for y in SIDES:
        block -= rod((0, y * 0.22, 0.1), (0, y * 0.22, 0.4), 0.11, sides=10)
    return block


def vertical_thruster(y: float) -> Manifold:
    """Return the hub and the guard bar in a well of the foam block."""
    return rod((0, y, 0.19), (0, y, 0.29), 0.035, sides=6) + box((-0.12, y - 0.015, 0.22), (0.12, y + 0.015, 0.25))


def horizontal_thruster(x: float, y: float) -> Manifold:
    """Return a duct turned inward by 45 degrees, its hub and the strut that carries both."""
    axis = np.array([np.sign(x), -np.sign(y), 0.0]) / np.sqrt(2)
    centre = np.array([x, y, -0.13])

    def along(low: float, high: float, radius: float, sides: int) -> Manifold:
        return rod(tuple(centre + low * axis), tuple(centre + high * axis), radius, sides)

    duct = along(-0.06, 0.06, 0.095, 10) - along(-0.1, 0.1, 0.08, 10)
    strut = box((x - 0.012, y - 0.012, -0.22), (x + 0.012, y + 0.012, 0.17))
    return duct + along(-0.09, 0.05, 0.035, 6) + strut


def skid(y: float) -> Manifold:
    """Return a skid with an upturned toe."""
    inner, outer = y * 0.34, y * 0.40
    low, high = min(inner, outer), max(inner, outer)
    toe = [(x, side, z) for side in (low, high) for x, z in ((0.5, -0.35), (0.5, -0.29), (0.6, -0.27), (0.6, -0.21))]
    return box((-0.6, low, -0.35), (0.5, high, -0.29)) + hull(toe)


def frame() -> list[Manifold]:
    """Return uprights, side rails and cross bars between the skids and the foam."""
    parts = []
    for y in SIDES:
        side = y * 0.37
        parts += [box((x - 0.025, side - 0.02, -0.30), (x + 0.025, side + 0.02, 0.16)) for x in (-0.48, 0.0, 0.46)]
        parts.append(box((-0.48, side - 0.02, -0.24), (0.46, side + 0.02, -0.20)))
    parts += [box((x - 0.03, -0.35, -0.34), (x + 0.03, 0.35, -0.30)) for x in (-0.40, 0.0, 0.40)]
    parts += [box((x - 0.025, -0.36, -0.24), (x + 0.025, 0.36, -0.20)) for x in (-0.35, 0.35)]
    return parts


def pods() -> list[Manifold]:
    """Return two pressure cylinders for electronics and battery, strapped below the foam."""
    parts = []
    for y in SIDES:
        parts.append(rod((-0.38, y * 0.13, 0.03), (0.34, y * 0.13, 0.03), 0.105, sides=10))
        parts.append(ball((0.34, y * 0.13, 0.03), 0.103, sides=8))
    parts += [box((x - 0.03, -0.2, -0.02), (x + 0.03, 0.2, 0.16)) for x in (-0.26, 0.22)]
    return parts


def sonar_head() -> list[Manifold]:
    """Return the multibeam head: a drum across the bow, on an arm from the frame."""
    return [rod((0.53, -0.12, -0.18), (0.53, 0.12, -0.18), 0.07), box((0.33, -0.03, -0.24), (0.50, 0.03, -0.18))]


def thrusters() -> list[Manifold]:
    """Return the vertical and the horizontal thrusters."""
    parts = [vertical_thruster(y * 0.22) for y in SIDES]
    return parts + [horizontal_thruster(x, y) for x in (-0.38, 0.36) for y in (-0.25, 0.25)]


def by_colour() -> dict[Colour, list[Manifold]]:
    """Return the vehicle's parts by colour."""
    yellow, black, grey = (0.80, 0.50, 0.03), (0.03, 0.03, 0.03), (0.50, 0.52, 0.55)
    red, blue = (0.55, 0.03, 0.02), (0.02, 0.06, 0.35)
    frame_and_skids = [*frame(), *(skid(y) for y in SIDES)]
    return {yellow: [foam_block()], black: frame_and_skids, grey: pods(), red: sonar_head(), blue: thrusters()}


def main() -> None:
    """Write the meshes."""
    solid = united([foam_block(), *frame(), *pods(), *sonar_head(), *(skid(y) for y in SIDES), *thrusters()])
    x, _, z = centroid(solid)
    shift = (-x, 0, BUOYANCY_ARM_M - z)
    comment = "made by tools/assets/make_rov.py; metres, x forward, z up"
    placed = {colour: [part.translate(shift) for part in parts] for colour, parts in by_colour().items()}
    write_obj(solid.translate(shift), ASSETS / "meshes" / "rov.obj", comment, placed)
    coloured, colours = united_by_colour(by_colour())
    write_glb(coloured.translate(shift), colours, ASSETS / "meshes" / "paper_rov.glb")


if __name__ == "__main__":
    main()
