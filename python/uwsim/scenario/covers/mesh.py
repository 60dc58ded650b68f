"""The cover `mesh`: pieces of the user's own shape."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from uwsim.scenario.build.cover_meshes import unit
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import Texture, load_texture
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import MeshFile, Name
from uwsim.scenario.spec.material import Material, MaterialSpec


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
