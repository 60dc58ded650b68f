"""Obstacles of one solid: boxes, cylinders, spheres and meshes."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from uwsim import _core
from uwsim.scenario.build.solids import bars, created, posed
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import Texture, load_texture
from uwsim.scenario.spec.fields import Factor, InRange, MeshFile, Name, Size, YawPitchRoll
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import LEVEL, Bed, Placed, Solid


class Box(Placed):
    """A cuboid.

    position_m: its centre (world), unless it is on_bed. size_m: edge lengths along its own x, y and z.
    """

    kind: Literal["box"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="concrete")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    size_m: tuple[Size, Size, Size] = Field(examples=[[2, 2, 2]])

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = created("box", self.size_m)
        return Solid(posed(vertices, self.position_m, self.yaw_pitch_roll_deg), triangles, [])


class Cylinder(Placed):
    """A cylinder along its own z.

    position_m: its centre (world), unless it is on_bed. radius_m, length_m: its dimensions.
    """

    kind: Literal["cylinder"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    radius_m: Annotated[float, InRange(0.002, 10_000, "m")] = Field(examples=[0.5])
    length_m: Size = Field(examples=[2])

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * self.length_m
        start, end = posed(ends, self.position_m, self.yaw_pitch_roll_deg)
        return bars([(start, end)], self.radius_m)


BALL_SUBDIVISIONS = 4
"""Subdivisions of an icosahedron: the facets lie at most 0.1 % of the radius inside the sphere."""


class Sphere(Placed):
    """A sphere.

    position_m: its centre (world), unless it is on_bed. radius_m: its radius.
    """

    kind: Literal["sphere"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    radius_m: Size = Field(examples=[1])

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = created("icosphere", BALL_SUBDIVISIONS, self.radius_m)
        shape = _core.RoundShape.sphere(self.position_m, self.radius_m)
        return Solid(vertices + np.asarray(self.position_m), triangles, [shape])


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
