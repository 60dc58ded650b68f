"""Fixed obstacles in the water, selected by `kind`. All of them collide and produce echoes.

For round obstacles except rings, rays intersect the exact shapes; contacts and map scores use meshes, see
build/obstacles.py.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, StrictBool, model_validator

from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import (
    AssetFile,
    Degrees,
    Factor,
    InRange,
    Model,
    Name,
    Point2,
    Point3,
    Size,
    YawPitchRoll,
    broken,
)
from uwsim.scenario.spec.material import Material, MaterialSpec

MAX_BEND_DEG = 120.0
LEVEL: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Placed(Model):
    """An obstacle placed by coordinates.

    on_bed: whether it stands on the terrain: z of position_m is then the height of its lowest point above the point of
    the bed that it would touch first; a negative value sinks it into the bed. position_m: position in the world.
    """

    on_bed: StrictBool = False
    position_m: Point3


class OnBed(Model):
    """An obstacle that always stands on the terrain or follows it.

    on_bed: always true; may be left out.
    """

    on_bed: Literal[True] = True


class Pipeline(OnBed):
    """A pipe that follows the terrain below a line through points_m (x, y).

    points_m: corners of the line, x and y. radius_m: outer radius. buried_fraction: fraction of the diameter below the
    bed.
    """

    kind: Literal["pipeline"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="concrete")
    points_m: Annotated[tuple[Point2, ...], Field(min_length=2, max_length=1000)]
    radius_m: Annotated[float, InRange(0.02, 10, "m")]
    buried_fraction: Annotated[float, InRange(0, 0.95)] = 0.2

    @model_validator(mode="after")
    def _bends_gently(self) -> Pipeline:
        headings = []
        for (x0, y0), (x1, y1) in pairwise(self.points_m):
            if math.hypot(x1 - x0, y1 - y0) < 1e-3:
                raise broken(f"the point ({x1:g}, {y1:g}) m occurs twice in a row", at=("points_m",))
            headings.append(math.atan2(y1 - y0, x1 - x0))
        for before, after in pairwise(headings):
            bend_deg = abs(math.degrees(math.remainder(after - before, 2 * math.pi)))
            if bend_deg > MAX_BEND_DEG:
                rule = f"the pipe bends by {bend_deg:.0f} deg: must be at most {MAX_BEND_DEG:.0f} deg"
                raise broken(rule, at=("points_m",))
        return self


class Gate(OnBed):
    """Two posts and a crossbar that stand on the terrain; the passage is along the gate's x.

    position_m: x and y of its middle. yaw_deg: direction of the gate's x, counter-clockwise from east. width_m:
    distance between the posts' axes. height_m: height of the crossbar's axis above the bed at position_m. bar_radius_m:
    radius of posts and bars. lower_bar_m: height of a second bar; none by default.
    """

    kind: Literal["gate"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint")
    position_m: Point2
    yaw_deg: Degrees = 0.0
    width_m: Annotated[float, InRange(0.2, 200, "m")]
    height_m: Annotated[float, InRange(0.2, 200, "m")]
    bar_radius_m: Annotated[float, InRange(0.01, 5, "m")] = 0.1
    lower_bar_m: Annotated[float, InRange(0, 200, "m")] | None = None

    @model_validator(mode="after")
    def _is_open(self) -> Gate:
        if 2 * self.bar_radius_m >= min(self.width_m, self.height_m):
            rule = "must be below half of width_m and of height_m"
            raise broken(rule, at=("bar_radius_m",), value=self.bar_radius_m, unit="m")
        if self.lower_bar_m is not None and self.lower_bar_m >= self.height_m:
            rule = f"must be below height_m ({self.height_m:g} m)"
            raise broken(rule, at=("lower_bar_m",), value=self.lower_bar_m, unit="m")
        return self


class Box(Placed):
    """A cuboid.

    position_m: its centre (world), unless it is on_bed. size_m: edge lengths along its own x, y and z.
    """

    kind: Literal["box"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="concrete")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    size_m: tuple[Size, Size, Size]


class Cylinder(Placed):
    """A cylinder along its own z.

    position_m: its centre (world), unless it is on_bed. radius_m, length_m: its dimensions.
    """

    kind: Literal["cylinder"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    radius_m: Size
    length_m: Size


class Sphere(Placed):
    """A sphere.

    position_m: its centre (world), unless it is on_bed. radius_m: its radius.
    """

    kind: Literal["sphere"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    radius_m: Size


class Ring(Placed):
    """A torus, such as a gate that hangs in the water; the passage is along its own x.

    position_m: its centre (world), unless it is on_bed. major_radius_m: distance from the centre to the axis of the
    bar.
    minor_radius_m: radius of the bar. stripes: albedos, in alternation, of twelve stripes around the ring; they
    override the material's.
    """

    kind: Literal["ring"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint")
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    major_radius_m: Size
    minor_radius_m: Size
    stripes: tuple[Colour, Colour] | None = None

    @model_validator(mode="after")
    def _is_open(self) -> Ring:
        if self.minor_radius_m >= self.major_radius_m:
            rule = f"must be below major_radius_m ({self.major_radius_m:g} m)"
            raise broken(rule, at=("minor_radius_m",), value=self.minor_radius_m, unit="m")
        return self


class MeshObstacle(Placed):
    """An obstacle from a mesh file.

    file: FBX, glTF, OBJ, STL, PLY and others. position_m: position of the mesh's own origin (world), unless it is
    on_bed. scale: metres per unit of the file. up: the file's axis that points up; by default y for glTF, the declared
    axis for FBX, z for all others.
    """

    kind: Literal["mesh"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    file: AssetFile
    yaw_pitch_roll_deg: YawPitchRoll = LEVEL
    scale: Factor = 1.0
    up: Literal["y", "z"] | None = None


ObstacleSpec = Annotated[Pipeline | Gate | Box | Cylinder | Sphere | Ring | MeshObstacle, Field(discriminator="kind")]
