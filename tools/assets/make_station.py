"""Makes assets/meshes/station.obj, a moored pontoon with a dock beneath; needs numpy and manifold3d.

Metres; x forward, z up, z = 0 the water line. The dock's middle is at (0, 0, -5); a vehicle of 1.2 x 0.8 x 0.7 m
leaves it along +x, where the cage is open.
"""

from __future__ import annotations

from pathlib import Path

from manifold3d import Manifold
from solids import ball, box, hull, rod, united, write_obj

ASSETS = Path(__file__).resolve().parents[2] / "assets"
SIDES = (-1, 1)
DOCK_Z = -5.0
BAR_M = 0.03
"""Half the width of the cage's bars."""


def pontoon(y: float) -> Manifold:
    """Make a float with raked ends."""
    return hull([(x, y + side * 0.6, z) for side in SIDES for x, z in ((-3, 0.4), (3, 0.4), (2.3, -0.5), (-2.3, -0.5))])


def platform() -> list[Manifold]:
    """Make two floats, a deck, a hut, and a mast with its lamp and antenna bar."""
    return [
        pontoon(-1.9),
        pontoon(1.9),
        box((-3, -2.5, 0.38), (3, 2.5, 0.55)),
        box((-2.4, -1.4, 0.5), (-0.6, 1.4, 2.4)),
        box((-2.6, -1.6, 2.38), (-0.4, 1.6, 2.5)),
        rod((1.6, 0, 0.5), (1.6, 0, 4.6), 0.08, sides=8),
        rod((1.6, -0.7, 3.9), (1.6, 0.7, 3.9), 0.04, sides=8),
        ball((1.6, 0, 4.7), 0.18, sides=8),
    ]


def bar(start: tuple[float, float, float], end: tuple[float, float, float]) -> Manifold:
    """Make a square bar along one axis."""
    low = tuple(min(a, b) - BAR_M for a, b in zip(start, end, strict=True))
    high = tuple(max(a, b) + BAR_M for a, b in zip(start, end, strict=True))
    return box(low, high)


def cage() -> list[Manifold]:
    """Make the dock: 2 x 1.8 x 1.6 m, open in front, with a cross behind, hung from the deck on four legs."""
    x, y, low, high = 1.0, 0.9, DOCK_Z - 0.8, DOCK_Z + 0.8
    parts = [bar((-x, side * y, z), (x, side * y, z)) for side in SIDES for z in (low, DOCK_Z, high)]
    parts += [bar((end * x, -y, z), (end * x, y, z)) for end in SIDES for z in (low, high)]
    parts += [bar((end * x, side * y, low), (end * x, side * y, 0.45)) for end in SIDES for side in SIDES]
    parts += [bar((-x, -y, DOCK_Z), (-x, y, DOCK_Z)), bar((-x, 0, low), (-x, 0, high))]
    parts += [bar((-x, side * 0.4, low), (x, side * 0.4, low)) for side in SIDES]
    return parts


def main() -> None:
    """Write the mesh."""
    comment = "made by tools/assets/make_station.py; metres, z = 0 is the water line"
    write_obj(united([*platform(), *cage()]), ASSETS / "meshes" / "station.obj", comment)


if __name__ == "__main__":
    main()
