"""Three floating hulls and what Capytaine computed for them: a hemisphere, a vertical cylinder and a barge."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.hull import RigidBody
from uwsim.scenario.build.radiation import radiation
from uwsim.scenario.read.radiation_file import read_radiation
from uwsim.scenario.read.radiation_table import RadiationTable

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

FOLDER = Path(__file__).parent
DENSITY_KG_M3, GRAVITY_M_S2 = 1000.0, 9.81
HULLS = ("hemisphere", "cylinder", "barge")
TRIED_RAD_S = {
    "hemisphere": (1.98, 3.13, 3.96, 4.43, 5.05, 6.26),
    "cylinder": (1.5, 2.2, 2.7, 3.0, 3.4, 4.2),
    "barge": (1.5, 2.5, 3.5, 4.2, 4.8, 5.5),
}


class FloatingHull(NamedTuple):
    """A hull without drag and the linear terms of its motion about its centre of mass, deep water.

    waterline_m: height of the surface in the body frame, whose origin is the middle of the hull's box. mass, stiffness:
    (6, 6). tried_rad_s: frequencies at which heave and pitch are tried, with both resonances. settling_s: until its own
    motions have died away. least_response: smaller responses are compared with this one.
    """

    name: str
    craft: _core.Craft
    table: RadiationTable
    model: _core.Radiation
    waterline_m: float
    mass: Array
    stiffness: Array
    tried_rad_s: tuple[float, ...]
    settling_s: float
    least_response: float


class Shape(NamedTuple):
    """A mesh about the middle of its box, and closed forms of what floats: area, second moments of the waterplane.

    It displaces as much as the table's flat panels, which are within its smooth shape.
    """

    vertices_m: Array
    triangles: NDArray[np.uint32]
    waterline_m: float
    wet_volume_m3: float
    centre_of_buoyancy_z_m: float
    centre_of_mass_z_m: float
    plane_m2: float
    plane_moments_m4: tuple[float, float]
    radii_m: tuple[float, float, float]


def table_file(name: str) -> Path:
    """Return the file that Capytaine wrote for a hull."""
    return FOLDER / f"seakeeping_{name}.nc"


@cache
def floating_hull(name: str) -> FloatingHull:
    """Return a hull with its table."""
    table = read_radiation(table_file(name))
    assert table.displaced_kg is not None
    shape = {"hemisphere": hemisphere, "cylinder": cylinder, "barge": barge}[name](table.displaced_kg / DENSITY_KG_M3)
    mass_kg = DENSITY_KG_M3 * shape.wet_volume_m3
    parameters = _core.CraftParameters()
    parameters.mass_kg = mass_kg
    parameters.inertia_kg_m2 = mass_kg * np.diag(np.square(shape.radii_m))
    parameters.centre_of_mass_body_m = (0.0, 0.0, shape.centre_of_mass_z_m + shape.waterline_m)
    model = radiation(table_file(name), rigid_body(shape), shape.vertices_m, shape.triangles, DENSITY_KG_M3)
    parameters.radiation = model
    weight_n = mass_kg * GRAVITY_M_S2
    arm_m = shape.centre_of_buoyancy_z_m - shape.centre_of_mass_z_m
    stiffness = np.zeros(6)
    stiffness[2] = DENSITY_KG_M3 * GRAVITY_M_S2 * shape.plane_m2
    for axis, moment in zip((3, 4), shape.plane_moments_m4, strict=True):
        stiffness[axis] = weight_n * (moment / shape.wet_volume_m3 + arm_m)
    return FloatingHull(
        name=name,
        craft=_core.Craft(parameters, shape.vertices_m, shape.triangles),
        table=table,
        model=model,
        waterline_m=shape.waterline_m,
        mass=mass_kg * np.diag([1.0, 1.0, 1.0, *np.square(shape.radii_m)]),
        stiffness=np.diag(stiffness),
        tried_rad_s=TRIED_RAD_S[name],
        settling_s=60.0 if name == "barge" else 200.0,
        least_response=0.1,
    )


def rigid_body(shape: Shape, density_kg_m3: float = DENSITY_KG_M3) -> RigidBody:
    """Return the mass properties of a hull that floats."""
    mass_kg = density_kg_m3 * shape.wet_volume_m3
    return RigidBody(
        volume_m3=shape.wet_volume_m3,
        mass_kg=mass_kg,
        centre_of_buoyancy_m=np.array([0.0, 0.0, shape.centre_of_buoyancy_z_m + shape.waterline_m]),
        centre_of_mass_m=np.array([0.0, 0.0, shape.centre_of_mass_z_m + shape.waterline_m]),
        inertia_kg_m2=mass_kg * np.square(shape.radii_m),
    )


def responses(hull: FloatingHull, omega_rad_s: Array) -> Complex:
    """Return the motions per metre of a head wave's amplitude, (n, 6) complex, about the centre of mass.

    All from the table: interpolated in frequency, for heading 0, without our fit.
    """
    from scipy.interpolate import CubicSpline

    table = hull.table
    added, damping = (CubicSpline(table.omega_rad_s, each)(omega_rad_s) for each in (table.added_mass, table.damping))
    force = CubicSpline(table.omega_rad_s, table.exciting[:, 0])(omega_rad_s)
    omega = omega_rad_s[:, None, None]
    dynamic = -(omega**2) * (hull.mass + added) - 1j * omega * damping + hull.stiffness
    return np.asarray(np.linalg.solve(dynamic, force[:, :, None])[:, :, 0], np.complex128)


def hemisphere(volume_m3: float) -> Shape:
    """Return a ball that floats to its equator, its centre of mass at 0.2 radii below."""
    from uwsim.base.whole_trimesh import trimesh

    radius = (1.5 * volume_m3 / np.pi) ** (1.0 / 3.0)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=1.0)
    vertices = np.asarray(ball.vertices) * (2.0 * volume_m3 / ball.volume) ** (1.0 / 3.0)
    moment = np.pi / 4.0 * radius**4
    return Shape(vertices, np.asarray(ball.faces, np.uint32), 0.0, volume_m3, -3.0 / 8.0 * radius, -0.1,
                 np.pi * radius**2, (moment, moment), (0.25, 0.25, 0.25))  # fmt: skip


def cylinder(volume_m3: float) -> Shape:
    """Return a vertical cylinder of draught 0.75 m."""
    from uwsim.base.whole_trimesh import trimesh

    draught, height = 0.75, 1.25
    radius = np.sqrt(volume_m3 / (np.pi * draught))
    made = trimesh.creation.cylinder(radius=1.0, height=height, sections=64)
    vertices = np.asarray(made.vertices) * np.array([1.0, 1.0, 1.0])
    vertices[:, :2] *= radius * np.sqrt(np.pi * height / made.volume)
    moment = np.pi / 4.0 * radius**4
    return Shape(vertices, np.asarray(made.faces, np.uint32), draught - height / 2.0, volume_m3, -draught / 2.0, -0.5,
                 np.pi * radius**2, (moment, moment), (0.35, 0.35, 0.35))  # fmt: skip


def barge(volume_m3: float) -> Shape:
    """Return a box of 2 x 0.8 m."""
    from uwsim.base.whole_trimesh import trimesh

    length, width, height = 2.0, 0.8, 0.5
    draught = volume_m3 / (length * width)
    made = trimesh.creation.box((length, width, height))
    moments = length * width**3 / 12.0, width * length**3 / 12.0
    return Shape(np.asarray(made.vertices), np.asarray(made.faces, np.uint32), draught - height / 2.0, volume_m3,
                 -draught / 2.0, 0.0, length * width, moments, (0.25, 0.58, 0.6))  # fmt: skip
