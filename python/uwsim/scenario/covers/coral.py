"""The cover `coral`: branching, massive, plate-shaped or fan-shaped colonies."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.build.cover_meshes import Mesh, ball, lumps, merged, revolved, tube, unit
from uwsim.scenario.spec.cover import CoverModel
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Coral(CoverModel):
    """Colonies of coral. form: how they grow. size_m: height of branching ones and fans, diameter of others."""

    stance: ClassVar = "on_bed"

    kind: Literal["coral"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral")
    form: Literal["branching", "massive", "plate", "fan"] = "branching"

    def is_solid(self) -> bool:
        """See CoverModel: fans bend."""
        return self.form != "fan"

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        make = {"branching": _branching, "massive": _massive, "plate": _plate, "fan": _fan}[self.form]
        return [make(random) for _ in range(2 if self.form == "fan" else 4)]


def _branching(random: np.random.Generator) -> Mesh:
    """Return branches that fork twice, as staghorn's."""
    parts: list[Mesh] = []

    def grow(foot: Floats, along: Floats, length: float, radius: float, forks: int) -> None:
        bend = random.normal(0, 0.25, 3)
        t = np.linspace(0, 1, 3)[:, None]
        line = foot + length * (t * along + 0.3 * t**2 * bend)
        parts.append(tube(line, radius * np.array([1.0, 0.9, 0.65]), 5))
        for _ in range(3 if forks else 0):
            side = along + random.normal(0, 0.55, 3)
            side[2] = abs(side[2]) + 0.25
            at = foot + random.uniform(0.55, 1.0) * length * along
            grow(at, side / np.linalg.norm(side), 0.72 * length, 0.72 * radius, forks - 1)

    for turn in np.linspace(0, 2 * np.pi, 4)[:-1] + random.uniform(0, 2):
        grow(np.zeros(3), np.array([0.6 * np.cos(turn), 0.6 * np.sin(turn), 0.8]), 0.45, 0.055, 2)
    return unit(merged(parts), standing=True)


def _massive(random: np.random.Generator) -> Mesh:
    """Return a dome with lobes and winding ridges, as brain coral's."""
    vertices, triangles = ball(3)
    swell = 1 + 0.10 * lumps(vertices, random, 0.5) + 0.035 * np.sin(3.0 * lumps(vertices, random, 1.6))
    vertices = vertices * swell[:, None] * [1.0, random.uniform(0.8, 1.0), random.uniform(0.6, 0.85)]
    vertices, triangles = unit((vertices, triangles))
    return vertices - [0, 0, -0.15], triangles


def _plate(random: np.random.Generator) -> Mesh:
    """Return a stalk and a wide, wavy plate, as table coral's."""
    r = np.array([0.12, 0.09, 0.1, 0.35, 0.7, 1.0, 0.98, 0.6, 0.0])
    z = np.array([0.0, 0.15, 0.3, 0.4, 0.45, 0.52, 0.55, 0.5, 0.46])
    vertices, triangles = revolved(r, z, 18)
    wave = 1 + 0.12 * lumps(vertices * [1, 1, 0], random, 0.5)
    vertices = np.stack([vertices[:, 0] * wave, vertices[:, 1] * wave, vertices[:, 2] + 0.04 * (wave - 1) * 6], -1)
    vertices, triangles = unit((vertices, triangles))
    return vertices - [0, 0, vertices[:, 2].min()], triangles


def _fan(random: np.random.Generator) -> Mesh:
    """Return branches in one plane, as a sea fan's."""
    parts: list[Mesh] = []

    def grow(x: float, z: float, angle: float, length: float, radius: float, forks: int) -> None:
        end_x, end_z = x + length * np.sin(angle), z + length * np.cos(angle)
        line = np.array([[x, random.normal(0, 0.01), z], [end_x, random.normal(0, 0.01), end_z]])
        parts.append(tube(line, [radius, 0.75 * radius], 4))
        if forks:
            for turn in (-0.42, 0.05, 0.45):
                grow(end_x, end_z, angle + turn + random.normal(0, 0.08), 0.78 * length, 0.75 * radius, forks - 1)

    grow(0.0, 0.0, 0.0, 0.28, 0.02, 4)
    return unit(merged(parts), standing=True)
