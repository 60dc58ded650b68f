"""The obstacle `mesh`."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from uwsim.scenario.build.solids import posed
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import Texture, load_texture
from uwsim.scenario.spec.fields import Factor, MeshFile, Name, YawPitchRoll
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid


class MeshObstacle(Placed):
    """An obstacle from a mesh file.

    file: FBX, glTF, OBJ, STL, PLY and others. position_m: position of the mesh's own origin (world), unless it is
    on_bed. scale: metres per unit of the file. up: the file's axis that points up; by default y for glTF, the declared
    axis for FBX, z for all others.
    """

    has_own_unit: ClassVar = True

    kind: Literal["mesh"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    file: MeshFile = Field(examples=["meshes/rocks.obj"])
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    scale: Factor = Field(1.0, examples=[0.2])
    up: Literal["y", "z"] | None = None

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = load_mesh(self.file, scale=self.scale, up=self.up)
        return Solid(posed(vertices, self.position_m, self.yaw_pitch_roll_deg), triangles, [])

    def texture(self) -> Texture | None:
        """Return the colours of the file, unless the material has its own."""
        return load_texture(self.file) if self.material.colour is None else None
