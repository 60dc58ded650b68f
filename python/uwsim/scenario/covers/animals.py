"""Animals: covers of corals, sponges, mussels, sea urchins, starfish and shells, and the life `school`, of fish."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from uwsim.base.arrays import Floats
from uwsim.scenario.build.cover_meshes import ball, directions, fish, lumps, merged, revolved, tube, turned_to, unit
from uwsim.scenario.spec.cover import CoverModel, LifeModel, Mesh
from uwsim.scenario.spec.fields import InRange, Name, broken
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


class Sponge(CoverModel):
    """Groups of open tubes. size_m: their height."""

    kind: Literal["sponge"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral", colour=(0.62, 0.34, 0.08))

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(merged([_tube(random) for _ in range(random.integers(2, 6))]), standing=True) for _ in range(4)]


def _tube(random: np.random.Generator) -> Mesh:
    """Return a tube that opens at its top, where its wall turns inward."""
    high, wide = random.uniform(0.5, 1.0), random.uniform(0.10, 0.17)
    r = wide * np.array([0.7, 0.85, 1.0, 1.05, 1.0, 0.85, 0.6, 0.55])
    z = high * np.array([0.0, 0.25, 0.5, 0.75, 0.95, 1.0, 0.95, 0.5])
    vertices, triangles = revolved(r, z, 12)
    wave = 1 + 0.09 * lumps(vertices, random, 2.0)
    vertices = vertices * np.stack([wave, wave, np.ones_like(wave)], axis=-1)
    lean = np.append(random.normal(0, 0.25, 2), 1.0)
    return turned_to((vertices, triangles), lean, np.append(random.normal(0, 0.12, 2), 0.0))


class Mussel(CoverModel):
    """Clumps of a dozen mussels. size_m: diameter of the clump."""

    stance: ClassVar = "on_bed"

    kind: Literal["mussel"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock", colour=(0.13, 0.12, 0.16))

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_clump(random) for _ in range(4)]


def _clump(random: np.random.Generator) -> Mesh:
    """Return pointed ovals that stand close together, tips up."""
    vertices, triangles = ball(1)
    narrow = 0.6 + 0.4 * np.clip(0.5 + 0.6 * vertices[:, 2:], 0, 1)
    shell = (vertices * [0.16, 0.10, 0.3] * np.hstack([narrow, narrow, np.ones_like(narrow)]), triangles)
    parts = []
    for _ in range(12):
        at = np.append(random.normal(0, 0.22, 2), random.uniform(0.05, 0.15))
        parts.append(turned_to(shell, np.append(1.5 * at[:2] + random.normal(0, 0.3, 2), 0.8), at))
    vertices, triangles = unit(merged(parts))
    return vertices - [0, 0, vertices[:, 2].min()], triangles


SPINES = 110


class Urchin(CoverModel):
    """Sea urchins with all their spines. size_m: diameter across the spines."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = 0.08

    kind: Literal["urchin"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock", colour=(0.09, 0.05, 0.09))

    def is_solid(self) -> bool:
        """See CoverModel: spines break."""
        return False

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_urchin(random) for _ in range(3)]


def _urchin(random: np.random.Generator) -> Mesh:
    body, triangles = ball(1)
    parts = [(body * [0.5, 0.5, 0.36], triangles)]
    for along in directions(SPINES):
        if along[2] < -0.45:
            continue
        out = along + random.normal(0, 0.08, 3)
        tip = out / np.linalg.norm(out) * random.uniform(0.8, 1.05) * [1, 1, 0.85]
        parts.append(tube([0.4 * tip, tip], [0.022, 0.003], 3, closed=False))
    vertices, triangles = unit(merged(parts))
    return vertices - [0, 0, vertices[:, 2].min()], triangles


class Starfish(CoverModel):
    """Starfish with five arms, whose outline is a superformula (Gielis 2003, Am. J. Bot. 90(3):333)."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = 0.01

    kind: Literal["starfish"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral", colour=(0.60, 0.20, 0.07))

    def is_solid(self) -> bool:
        """See CoverModel: they are soft."""
        return False

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_star(random) for _ in range(3)]


def _star(random: np.random.Generator) -> Mesh:
    rings, sides = np.array([0.0, 0.25, 0.5, 0.75, 0.92, 1.0]), 40
    vertices, triangles = revolved(rings, np.zeros_like(rings), sides)
    turn = np.arctan2(vertices[:, 1], vertices[:, 0])
    power = random.uniform(1.5, 1.9)
    outline = (np.abs(np.cos(1.25 * turn)) ** power + np.abs(np.sin(1.25 * turn)) ** power) ** (-1 / 0.55)
    outline = outline / outline.max()
    reach = np.hypot(vertices[:, 0], vertices[:, 1])
    dome = 0.16 * np.sqrt(np.clip(1 - reach**2, 0, 1)) * (0.45 + 0.55 * (1 - reach))
    flat = vertices[:, :2] * outline[:, None]
    curl = 0.08 * lumps(np.column_stack([flat, dome]), random, 0.5) * (reach**2)
    vertices = np.column_stack([flat[:, 0] - curl * flat[:, 1], flat[:, 1] + curl * flat[:, 0], dome])
    vertices, triangles = unit((vertices, triangles))
    return vertices - [0, 0, vertices[:, 2].min()], triangles


RIBS, RINGS, SIDES = 9, 5, 36


class Shell(CoverModel):
    """Ribbed valves of scallops and cockles, hollow side down."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = 0.0

    kind: Literal["shell"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral", colour=(0.72, 0.64, 0.55))

    def is_solid(self) -> bool:
        """See CoverModel: a body pushes them aside."""
        return False

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_valve(random) for _ in range(3)]


def _valve(random: np.random.Generator) -> Mesh:
    """Return a fan of ribs from the hinge, domed across."""
    angle = np.linspace(-1.0, 1.0, SIDES)[None, :]
    reach = np.linspace(0.05, 1.0, RINGS)[:, None]
    rib = 1 + 0.05 * np.cos(np.pi * RIBS * angle)
    edge = 0.5 * (1 + np.cos(0.5 * np.pi * angle**2))
    x = reach * np.sin(1.15 * angle) * random.uniform(0.85, 1.0)
    y = reach * np.cos(1.15 * angle) * (0.9 + 0.1 * edge)
    z = random.uniform(0.28, 0.4) * rib * np.sqrt(np.clip(1 - reach**2, 0, 1) + 0.02) * edge * np.sqrt(reach)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    a = (np.arange(RINGS - 1)[:, None] * SIDES + np.arange(SIDES - 1)).ravel()
    triangles = np.stack([a, a + SIDES, a + 1, a + 1, a + SIDES, a + SIDES + 1], axis=-1).reshape(-1, 3)
    vertices, triangles = unit((vertices, triangles.astype(np.uint32)))
    return vertices - [0.0, 0.0, vertices[:, 2].min()], triangles


PHASES, SIZES = 8, 3
STRIDE = 0.7
"""Body lengths swum per beat of the tail, as of many fish at steady speed (Bainbridge 1958, J. Exp. Biol. 35:109)."""
FISH_DB = -23.0
"""At normal incidence, per square metre. TS = 20 log10 L - 67.4 dB with L in cm (Foote 1987, J. Acoust. Soc. Am.
82:981, physoclists), of a side of 0.25 L^2; it is the same for each length."""


class FishSchool(LifeModel):
    """A school of fish of one form.

    form: deep as a damselfish, or slender as a sardine. Tail beats follow the speed.
    """

    kind: Literal["school"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="plain", colour=(0.33, 0.36, 0.38), strength_db=FISH_DB)
    form: Literal["deep", "slender"] = "slender"
    flatness: Annotated[float, InRange(0.2, 1)] = 0.5

    @model_validator(mode="after")
    def _turns_gently(self) -> FishSchool:
        low, high = self.size_m
        if low > high:
            raise broken("its first value must not exceed its second", at=("size_m",), value=[low, high])
        if self.spread_m[1] > 0.5 * self.round_m:
            rule = "its width must be at most half of round_m, so that the inner fish swim forwards"
            raise broken(rule, at=("spread_m", 1), value=self.spread_m[1])
        return self

    def shapes(self, random: np.random.Generator) -> list[list[Mesh]]:
        """See LifeModel."""
        depth = {"deep": 0.42, "slender": 0.22}[self.form] * random.uniform(0.95, 1.05)
        sizes = np.linspace(*self.size_m, SIZES)
        return [[fish(size, depth, self.flatness, k / PHASES) for k in range(PHASES)] for size in sizes]

    def stroke_hz(self) -> float:
        """See LifeModel."""
        return self.speed_m_s / (STRIDE * float(np.mean(self.size_m)))
