"""Covers of plants: kelp and seagrass."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from uwsim.base.arrays import Floats
from uwsim.scenario.build.cover_meshes import merged, ribbon, tube, unit
from uwsim.scenario.spec.cover import CoverModel, LeansAt, Mesh, PieceSize
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Kelp(CoverModel):
    """Tall plants with stipes and blades; they lean in a current, sway in waves, and brake what moves through them.

    size_m: their height.
    """

    sunk: ClassVar = 0.0
    drag_coefficient: ClassVar = 1.0

    kind: Literal["kelp"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="leaf", colour=(0.23, 0.17, 0.05))
    size_m: tuple[PieceSize, PieceSize] = Field(examples=[[2, 4]])
    leans_at_m_s: LeansAt = 0.4  # assumed

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(merged(_plant(random)), standing=True) for _ in range(4)]


BLADE_POINTS = 13
"""Along a blade; fewer are seen as corners from a metre away."""


def _plant(random: np.random.Generator) -> list[Mesh]:
    """Return a stipe, which leans and winds, and blades along its upper part, each curved and wavy."""
    up = np.linspace(0, 1, 9)
    lean, phase = random.uniform(-0.12, 0.12, 2), random.uniform(0, 2 * np.pi)
    stipe = np.stack([lean[0] * up**2 + 0.02 * np.sin(5 * up + phase), lean[1] * up**2 + 0.02 * np.cos(4 * up), up], -1)
    parts = [tube(stipe, np.linspace(0.010, 0.004, 9), 6)]
    for k, height in enumerate(np.linspace(0.12, 0.98, 22)):
        foot = np.array([np.interp(height, up, stipe[:, axis]) for axis in range(3)])
        turn = 2.4 * k + random.uniform(-0.4, 0.4)
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        along = np.linspace(0, 1, BLADE_POINTS)[:, None]
        length, rise = random.uniform(0.12, 0.22), random.uniform(0.1, 0.6)
        blade = foot + length * (along * out + (rise * along - 0.5 * along**2) * [0, 0, 1])
        blade[:, 2] += 0.008 * np.sin(9 * along[:, 0] + turn)
        parts += _kelp_blade(blade, np.cross(out, [0, 0, 1]), random)
    return parts


def _kelp_blade(line: Floats, across: Floats, random: np.random.Generator) -> list[Mesh]:
    """Return the two halves of a blade along a line (n, 3): folded at the rib, with wavy edges, and twisted."""
    along = np.linspace(0, 1, len(line))
    widths = 0.05 * np.interp(along, np.linspace(0, 1, 6), [0.2, 0.9, 1.0, 0.9, 0.6, 0.02])[:, None]
    widths *= 1 + 0.08 * np.sin(40 * along + random.uniform(0, 6))[:, None]  # a frilled edge
    twist = along[:, None] * random.uniform(-1.2, 1.2)
    level = np.cos(twist) * across + np.sin(twist) * [0, 0, 1]
    over = np.cos(twist) * [0, 0, 1] - np.sin(twist) * across
    halves = []
    for side in (-1, 1):
        wave = 0.25 + 0.3 * np.sin(11.5 * along[:, None] + random.uniform(0, 2 * np.pi))
        edge = 0.5 * widths * (side * level + wave * over)
        halves.append(ribbon(line + 0.5 * edge, edge, np.ones(len(line))))
    return halves


BLADES = 14


class Seagrass(CoverModel):
    """Tufts of long, narrow leaves; they lean in a current, sway in waves, and brake what moves through them.

    size_m: their height.
    """

    sunk: ClassVar = 0.02
    drag_coefficient: ClassVar = 1.0

    kind: Literal["seagrass"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="leaf")
    leans_at_m_s: LeansAt = 0.12  # assumed

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(merged([_grass_blade(random) for _ in range(BLADES)]), standing=True) for _ in range(5)]


def _grass_blade(random: np.random.Generator) -> Mesh:
    """Return a leaf that bends over towards its tip."""
    turn, bend, length = random.uniform(0, 2 * np.pi), random.uniform(0.05, 0.6), random.uniform(0.5, 1.0)
    out = np.array([np.cos(turn), np.sin(turn), 0.0])
    t = np.linspace(0, 1, 5)[:, None]
    line = np.append(random.normal(0, 0.06, 2), 0) + length * (bend * t**2 * out + (t - 0.25 * bend * t**2) * [0, 0, 1])
    return ribbon(line, np.cross(out, [0, 0, 1]), 0.035 * np.array([0.8, 1, 1, 0.8, 0.1]))
