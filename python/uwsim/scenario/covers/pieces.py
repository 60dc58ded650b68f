"""Covers of lifeless pieces: rocks, cobbles, debris, and the user's own meshes."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from uwsim.scenario.build.cover_meshes import lying_about, stone, unit
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import Texture, load_texture
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import MeshFile, Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Rock(CoverModel):
    """Stones with edges, tumbled; a third of each is in the bed."""

    stance: ClassVar = "tumbled"
    sunk: ClassVar = -0.12

    kind: Literal["rock"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock")

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(stone(random, cuts=14, roughness=0.08)) for _ in range(6)]


class Cobble(CoverModel):
    """Stones that water has rounded, flat on the bed."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = -0.1

    kind: Literal["cobble"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock", colour=(0.34, 0.32, 0.29))

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        found = []
        for _ in range(5):
            vertices, triangles = stone(random, cuts=2, roughness=0.1, divisions=2)
            found.append(unit((vertices * [1.0, 0.85, 0.6], triangles)))
        return found


class Debris(CoverModel):
    """Bottles, cans, planks, bricks and tyres, lying on the bed. size_m: their length."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = -0.02

    kind: Literal["debris"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return lying_about(random)


class MeshCover(CoverModel):
    """Pieces from a mesh file, upright.

    file: FBX, glTF, OBJ, STL, PLY and others. up: the file's axis that points up, as for the obstacle `mesh`. size_m:
    the largest extent of a piece, whatever the file's unit; its lowest point stands on the bed. solid: bodies and
    tethers touch the pieces; otherwise, they pass through.
    """

    kind: Literal["mesh"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock")
    file: MeshFile = Field(examples=["meshes/rocks.obj"])
    up: Literal["y", "z"] | None = None
    solid: bool = True

    def is_solid(self) -> bool:
        """See CoverModel: as the file states."""
        return self.solid

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        vertices, triangles = unit(load_mesh(self.file, up=self.up))
        return [(vertices - [0, 0, vertices[:, 2].min()], triangles)]

    def texture(self) -> Texture | None:
        """Return the colours of the file, unless the material has its own."""
        return load_texture(self.file) if self.material.colour is None else None
