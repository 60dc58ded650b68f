"""Generate assets/meshes/station.obj and station.glb, a moored pontoon; needs numpy, manifold3d and trimesh.

Metres; x forward, z up, z = 0 at the waterline. The dock is underneath, centred at (0, 0, -5): a 1.2 x 0.8 x 0.7 m
vehicle hangs under a roof between four posts and can leave in any direction but up.
"""

from __future__ import annotations

from pathlib import Path

from manifold3d import Manifold
from solids import Colour, ball, box, hull, rod, united, united_by_colour, write_glb, write_obj

ASSETS = Path(__file__).resolve().parents[2] / "assets"
SIDES = (-1, 1)
DOCK_Z = -5.0
BAR_M = 0.03
"""Half the thickness of the cage's bars."""


def pontoon(y: float) -> Manifold:
    """Return a float with raked ends."""
    return hull([(x, y + side * 0.6, z) for side in SIDES for x, z in ((-3, 0.4), (3, 0.4), (2.3, -0.5), (-2.3, -0.5))])


def platform() -> dict[Colour, list[Manifold]]:
    """Return two floats, a deck, a hut, and a mast with its lamp and antenna bar, by colour."""
    return {
        (0.80, 0.24, 0.03): [pontoon(-1.9), pontoon(1.9)],
        (0.34, 0.35, 0.36): [box((-3, -2.5, 0.38), (3, 2.5, 0.55))],
        (0.82, 0.82, 0.80): [box((-2.4, -1.4, 0.5), (-0.6, 1.4, 2.4))],
        (0.05, 0.16, 0.42): [box((-2.6, -1.6, 2.38), (-0.4, 1.6, 2.5))],
        (0.60, 0.61, 0.62): [
            rod((1.6, 0, 0.5), (1.6, 0, 4.6), 0.08, sides=8),
            rod((1.6, -0.7, 3.9), (1.6, 0.7, 3.9), 0.04, sides=8),
        ],
        (0.75, 0.03, 0.02): [ball((1.6, 0, 4.7), 0.18, sides=8)],
    }


def bar(start: tuple[float, float, float], end: tuple[float, float, float]) -> Manifold:
    """Return a square bar along one axis."""
    low = tuple(min(a, b) - BAR_M for a, b in zip(start, end, strict=True))
    high = tuple(max(a, b) + BAR_M for a, b in zip(start, end, strict=True))
    return box(low, high)


def cage() -> list[Manifold]:
    """Return the dock: a 2.4 x 2 m roof on four posts that hang from the deck; sides, ends and bottom are open."""
    x, y, low, high = 1.2, 1.0, DOCK_Z - 0.5, DOCK_Z + 0.8
    parts = [bar((end * x, side * y, low), (end * x, side * y, 0.45)) for end in SIDES for side in SIDES]
    parts += [bar((-x, side * y, high), (x, side * y, high)) for side in SIDES]
    parts += [bar((end * x, -y, high), (end * x, y, high)) for end in SIDES]
    parts += [bar((-x, side * 0.4, high), (x, side * 0.4, high)) for side in SIDES]
    parts += [bar((-x, side * y, -1.0), (x, side * y, -1.0)) for side in SIDES]
    parts += [bar((end * x, -y, -1.0), (end * x, y, -1.0)) for end in SIDES]
    return parts


def main() -> None:
    """Write the meshes."""
    comment = "made by tools/assets/make_station.py; metres, z = 0 is the water line"
    parts = {**platform(), (0.85, 0.66, 0.04): cage()}
    write_obj(
        united([solid for solids in parts.values() for solid in solids]), ASSETS / "meshes" / "station.obj", comment
    )
    write_glb(*united_by_colour(parts), ASSETS / "meshes" / "station.glb")


if __name__ == "__main__":
    main()
