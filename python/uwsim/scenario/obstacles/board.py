"""The obstacle `board`, a plate with a picture and openings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictBool, model_validator

from uwsim.base.arrays import Floats
from uwsim.scenario.build.solids import SIDES, Mesh, posed
from uwsim.scenario.read.mesh_file import joined
from uwsim.scenario.read.textures import Texture, encoded
from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import InRange, Model, Name, Size, YawPitchRoll, broken
from uwsim.scenario.spec.material import Mark, Material, MaterialSpec, Place
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid

LONGER_SIDE = 512
"""Pixels of a picture's longer side."""
FINER = 3
"""Points per pixel and direction."""

Mask = NDArray[np.bool_]

FONT = bytes.fromhex(
    "0e11111f1111111e11111e11111e0e11101010110e1e11111111111e1f10101e10101f1f10101e1010100e11101711110f"
    "1111111f1111110e04040404040e0702020202120c111214181412111010101010101f111b151511111111191513111111"
    "0e11111111110e1e11111e1010100e11111115120d1e11111e1412110f10100e01011e1f0404040404041111111111110e"
    "11111111110a0411111115151b1111110a040a111111110a040404041f01020408101f0e11131519110e040c040404040e"
    "0e11010204081f1f02040201110e02060a121f02021f101e0101110e0608101e11110e1f0102040808080e11110e11110e"
    "0e11110f01020c"
)
"""Letters A to Z and figures 0 to 9 of 5 x 7 points: seven rows each, from the top, of five bits."""
LETTERS = {letter: FONT[7 * k : 7 * k + 7] for k, letter in enumerate("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789")}


def board_picture(size_m: tuple[float, float], ground: Sequence[float], marks: Sequence[Mark]) -> Floats:
    """Return the albedo (h, w, 3) of a board's front, seen from in front of it. ground: that of the board."""
    scale = LONGER_SIDE / max(size_m)
    width, height = (max(round(scale * length), 1) for length in size_m)
    right = ((np.arange(width * FINER) + 0.5) / (width * FINER) - 0.5) * size_m[0]
    up = (0.5 - (np.arange(height * FINER) + 0.5) / (height * FINER)) * size_m[1]
    picture = np.empty((height * FINER, width * FINER, 3))
    picture[:] = ground
    for mark in marks:
        x, y = np.meshgrid(right - mark.at_m[0], up - mark.at_m[1])
        turn = np.radians(mark.turned_deg)
        along, across = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        picture[_covered(mark, along / mark.size_m, across / mark.size_m)] = mark.colour
    return np.asarray(picture.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3)))


def _covered(mark: Mark, x: Floats, y: Floats) -> Mask:
    """Return which points a mark covers; x to the right and y up from its middle, in parts of its size."""
    return _text(mark.text, x, y) if mark.text is not None else MASKS[mark.shape](x, y)


def _text(text: str, x: Floats, y: Floats) -> Mask:
    row = np.floor((0.5 - y) * 7.0).astype(int)
    column = np.floor(x * 7.0 + 0.5 * (6 * len(text) - 1)).astype(int)
    points = np.zeros((7, 6 * len(text)), bool)
    for number, letter in enumerate(text):
        for line, bits in enumerate(LETTERS.get(letter, bytes(7))):
            points[line, 6 * number : 6 * number + 5] = [bits >> (4 - k) & 1 for k in range(5)]
    inside = (row >= 0) & (row < 7) & (column >= 0) & (column < points.shape[1])
    return np.asarray(inside & points[row.clip(0, 6), column.clip(0, points.shape[1] - 1)])


def _square(x: Floats, y: Floats, width: float = 1.0, height: float = 1.0) -> Mask:
    return np.asarray((np.abs(x) <= 0.5 * width) & (np.abs(y) <= 0.5 * height))


def _triangle(x: Floats, y: Floats) -> Mask:
    """An equilateral triangle that points up; its middle is that of its height."""
    return np.asarray((np.abs(y) <= 0.25 * 3**0.5) & (np.abs(x) <= (0.25 * 3**0.5 - y) / 3**0.5))


def _star(x: Floats, y: Floats) -> Mask:
    """A star with five points, as one draws it by a single line."""
    sector = np.mod(np.arctan2(x, y), 2 * np.pi / 5)
    angle = np.minimum(sector, 2 * np.pi / 5 - sector)
    return np.asarray(np.hypot(x, y) * np.cos(2 * np.pi / 5 - angle) <= 0.5 * np.cos(2 * np.pi / 5))


def _arrow(x: Floats, y: Floats) -> Mask:
    head = (y >= 0.1) & (y <= 0.5) & (np.abs(x) <= 0.75 * (0.5 - y))
    return np.asarray(head | ((np.abs(x) <= 0.1) & (y >= -0.5) & (y < 0.1)))


def _fish(x: Floats, y: Floats) -> Mask:
    """A fish that swims to the left: a body, a tail and an eye."""
    body = ((x + 0.1) / 0.4) ** 2 + (y / 0.2) ** 2 <= 1.0
    tail = (x >= 0.2) & (x <= 0.5) & (np.abs(y) <= 0.6 * (x - 0.2) + 0.04)
    return np.asarray((body | tail) & (np.hypot(x + 0.32, y - 0.04) > 0.03))


MASKS: dict[str, Callable[[Floats, Floats], Mask]] = {
    "disc": lambda x, y: np.asarray(np.hypot(x, y) <= 0.5),
    "ring": lambda x, y: np.asarray(np.abs(np.hypot(x, y) - 0.4) <= 0.1),
    "square": _square,
    "triangle": _triangle,
    "cross": lambda x, y: _square(x, y, height=1 / 3) | _square(x, y, width=1 / 3),
    "star": _star,
    "arrow": _arrow,
    "stripes": lambda x, y: _square(x, y) & (np.mod(np.floor(5.0 * (x + 0.5)), 2) == 0),
    "fish": _fish,
}


STRIP = 4
"""Width in pixels of the strip beside a picture that has the colour of the board's edges."""
WHITE: Colour = (0.8, 0.8, 0.8)


class Opening(Model):
    """A round hole through a board.

    at_m: its middle, to the right and up from the board's as one looks at the front. radius_m: its radius.
    """

    at_m: tuple[Place, Place] = (0.0, 0.0)
    radius_m: Annotated[float, InRange(0.005, 50, "m")]


class Cell(NamedTuple):
    """A rectangle of the board: from left to right and from low to high [m], and the opening in its middle, if any."""

    left: float
    right: float
    low: float
    high: float
    radius_m: float | None = None


class Board(Placed):
    """A flat board, such as a sign or a target. Its front faces along its own x; its edges are along y and z.

    position_m: its centre (world), unless it is on_bed. size_m: width and height. thickness_m: through the board.
    marks: its picture, on a ground of the material's colour. both_sides: whether the back has the same picture.
    openings: round holes; a square that is a fifth wider than each is to lie on the board, apart from those of others.
    """

    kind: Literal["board"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint", colour=WHITE)
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    size_m: tuple[Size, Size] = Field(examples=[[0.6, 0.6]])
    thickness_m: Annotated[float, InRange(0.001, 5, "m")] = 0.02
    marks: Annotated[tuple[Mark, ...], Field(max_length=100)] = ()
    both_sides: StrictBool = True
    openings: Annotated[tuple[Opening, ...], Field(max_length=20)] = ()

    @model_validator(mode="after")
    def _has_room_for_its_openings(self) -> Board:
        if _cells(self._whole(), [_around(one) for one in self.openings]) is None:
            rule = "a square a fifth wider than each must lie on the board, and a straight cut must part it from others"
            raise broken(rule, at=("openings",))
        return self

    def _whole(self) -> Cell:
        width, height = self.size_m
        return Cell(-0.5 * width, 0.5 * width, -0.5 * height, 0.5 * height)

    def _mesh(self) -> Mesh:
        cells = _cells(self._whole(), [_around(one) for one in self.openings]) or []
        parts = [_block(cell, self.thickness_m) for cell in cells]
        vertices, triangles = joined(parts)
        return vertices, triangles.astype(np.uint32)

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = self._mesh()
        return Solid(posed(vertices, self.position_m, self.yaw_pitch_roll_deg), triangles, [])

    def texture(self) -> Texture | None:
        """Return the picture, laid on the front, and on the back if that has it."""
        if not self.marks:
            return None
        ground = self.material.colour or WHITE
        picture = board_picture(self.size_m, ground, self.marks)
        edge = np.empty((len(picture), STRIP, 3))
        edge[:] = ground
        corners, triangles = self._mesh()
        places = corners[triangles]
        seen = np.where((places[:, :, 0] < 0).all(axis=1), -1.0, 1.0)[:, None] * places[:, :, 1]
        share = picture.shape[1] / (picture.shape[1] + STRIP)
        across = share * (0.5 + seen / self.size_m[0])
        laid = np.stack([across, 0.5 + places[:, :, 2] / self.size_m[1]], axis=-1)
        side = places[:, :, 0] / (0.5 * self.thickness_m)
        is_pictured = (side > 0.99).all(axis=1) | ((side < -0.99).all(axis=1) & self.both_sides)
        laid[~is_pictured] = (0.5 * (share + 1.0), 0.5)
        image = encoded(np.concatenate([picture, edge], axis=1))
        return Texture(np.ascontiguousarray(image), np.ascontiguousarray(laid, np.float32))


def _around(opening: Opening) -> Cell:
    (right, up), half = opening.at_m, 1.2 * opening.radius_m
    return Cell(right - half, right + half, up - half, up + half, opening.radius_m)


def _cells(whole: Cell, openings: Sequence[Cell]) -> list[Cell] | None:
    """Cut a rectangle along straight lines into those around openings and plain ones; None if that cannot be done."""
    if not openings:
        return [whole]
    if any(o.left < whole.left or o.right > whole.right or o.low < whole.low or o.high > whole.high for o in openings):
        return None
    if len(openings) == 1 and whole[:4] == openings[0][:4]:
        return [openings[0]]
    for low, high in (("left", "right"), ("low", "high")):
        for cut in sorted({getattr(one, key) for one in openings for key in (low, high)}):
            before = [one for one in openings if getattr(one, high) <= cut]
            after = [one for one in openings if getattr(one, low) >= cut]
            if getattr(whole, low) < cut < getattr(whole, high) and len(before) + len(after) == len(openings):
                sides = whole._replace(**{high: cut}), whole._replace(**{low: cut})
                parts = _cells(sides[0], before), _cells(sides[1], after)
                return None if parts[0] is None or parts[1] is None else [*parts[0], *parts[1]]
    return None


def _block(cell: Cell, thickness_m: float) -> Mesh:
    """Return a closed block, whose x is through the board and y to the right as one looks at the front."""
    outline = np.array([[cell.left, cell.low], [cell.right, cell.low], [cell.right, cell.high], [cell.left, cell.high]])
    if cell.radius_m is None:
        return _prism(outline, np.array([[0, 1, 2], [0, 2, 3]]), [[0, 1, 2, 3]], thickness_m)
    middle = outline.mean(axis=0)
    angles = np.arange(SIDES) * (2 * np.pi / SIDES)
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    half = 0.5 * (cell.right - cell.left)
    outer = rays * (half / np.abs(rays).max(axis=1, keepdims=True))
    points = middle + np.vstack([outer, cell.radius_m * rays])
    k = np.arange(SIDES)
    after = (k + 1) % SIDES
    faces = np.vstack([np.column_stack([k, after, SIDES + after]), np.column_stack([k, SIDES + after, SIDES + k])])
    return _prism(points, faces, [k.tolist(), (2 * SIDES - 1 - k).tolist()], thickness_m)


def _prism(points: NDArray[Any], faces: NDArray[Any], loops: Sequence[Sequence[int]], thickness_m: float) -> Mesh:
    """Return a prism over a flat figure (right, up). faces: counter-clockwise. loops: its edges, the figure at left."""
    count, half = len(points), 0.5 * thickness_m
    flat = np.column_stack([points[:, 0], points[:, 1]])
    vertices = np.vstack([np.column_stack([np.full(count, x), flat]) for x in (half, -half)])
    sides = []
    for loop in loops:
        a = np.asarray(loop)
        b = np.roll(a, -1)
        sides += [np.column_stack([a, a + count, b + count]), np.column_stack([a, b + count, b])]
    return vertices, np.vstack([faces, faces[:, ::-1] + count, *sides]).astype(np.uint32)
