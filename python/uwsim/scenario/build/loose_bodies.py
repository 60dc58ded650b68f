"""A scenario's loose bodies as the core's ObjectSpecs: mass, added mass and drag from their shapes.

Added mass is that of ideal flow (_core.added_mass). Drag is quadratic: each element of the convex hull's surface takes
part with half of the coefficient times its area across its own motion, so that translation has the coefficient of the
projected area (Cauchy: half of the surface's projections), and turning that of the paddles that the surface makes.
Surfaces along their own motion, such as those of a turning sphere, have skin friction.
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, product, turned
from uwsim.scenario.build.arm import link_specs
from uwsim.scenario.build.body_paths import body_path, points_on, standing
from uwsim.scenario.build.equipment import applied_wrench
from uwsim.scenario.build.hydrodynamics import default_drag
from uwsim.scenario.build.solids import grounded
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.read.mesh_repair import closed_mesh
from uwsim.scenario.spec.arm import Dropper
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.obstacle import LEVEL, Bed, ObstacleModel
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle_entry import VehicleEntry

PANELS = 800
"""Panels for added mass, which is then at most 2 % too low for boxes, cylinders and plates: see `added_mass`."""
ELEMENTS = 2000
SKIN_FRICTION = 0.005
"""That of a turbulent boundary layer at a Reynolds number of 7e5, 0.074 Re^(-1/5) (Schlichting 1979, "Boundary-Layer
Theory", ch. 21)."""

HELD = "held "
"""How the names of links begin that stand for bodies in droppers; an arm's own names have no blank."""


class _Shape(NamedTuple):
    """A closed shape in the body's frame: its origin is the middle of its volume, its axes those of its kind.

    position_m (3,), orientation_xyzw (4,): where it starts. round: the exact shape of a ball or drum, for contacts.
    """

    vertices: Vertices
    triangles: Triangles
    solid: _core.SolidProperties
    position_m: Floats
    orientation_xyzw: Floats
    round: _core.RoundShape | None


def object_specs(scenario: Scenario) -> list[_core.ObjectSpec]:
    """Return the core's specs of all loose bodies, in order. Raises ScenarioError."""
    specs = []
    for index, body in enumerate(scenario.objects):
        with scenario.source_file.errors_at("objects", index):
            specs.append(_spec(body, scenario))
    for number, vehicle in enumerate(scenario.vehicles):
        for link, held in enumerate(held_bodies(scenario, vehicle), start=len(vehicle.model.arm or {})):
            index = scenario.objects.index(held.body)
            specs[index].carry(
                number, link, held.position_m, held.orientation_xyzw, held.along_body, held.dropper.spring_j
            )
    return specs


class Held(NamedTuple):
    """A body in a dropper, and its pose in the vehicle's frame, (3,) and (4,). along_body (3,): where it leaves."""

    body: LooseBody
    dropper: Dropper
    position_m: Floats
    orientation_xyzw: Floats
    along_body: Floats


def held_bodies(scenario: Scenario, vehicle: VehicleEntry) -> list[Held]:
    """Return the bodies in a vehicle's droppers, in the order of the core's links for them."""
    bodies, found = {body.name: body for body in scenario.objects}, []
    for dropper in vehicle.droppers.values():
        turn = of_yaw_pitch_roll_deg(dropper.yaw_pitch_roll_deg)
        for number, name in enumerate(dropper.holds):
            place = np.asarray(dropper.position_m) + turned(turn, number * np.asarray(dropper.spacing_m))
            own = product(turn, own_turn(bodies[name]))
            found.append(Held(bodies[name], dropper, place, own, turned(turn, np.array([1.0, 0.0, 0.0]))))
    return found


def leaving_along(body: LooseBody) -> Floats:
    """Return the direction in a body's frame, (3,), in which it leaves a dropper."""
    return turned(own_turn(body) * [-1.0, -1.0, -1.0, 1.0], np.array([1.0, 0.0, 0.0]))


def own_turn(body: LooseBody) -> Floats:
    """Return the orientation of a body's shape, (4,)."""
    return of_yaw_pitch_roll_deg(getattr(body.shape, "yaw_pitch_roll_deg", LEVEL))


def held_links(scenario: Scenario, vehicle: VehicleEntry) -> list[_core.ArmLink]:
    """Return the fixed links that stand for the bodies in a vehicle's droppers. Raises ScenarioError.

    They have the mass, the buoyancy, the added mass and the drag of the bodies.
    """
    links = []
    for held in held_bodies(scenario, vehicle):
        shape = _placed(held.body.shape, build_terrain(scenario.terrain))
        parameters = _parameters(held.body, shape, surface_density_kg_m3(scenario.water))
        link = _core.ArmLink()
        link.name, link.parent, link.joint = f"{HELD}{held.body.name}", None, _core.JointKind.FIXED
        link.set_pose(held.position_m, held.orientation_xyzw)
        link.mass_kg, link.inertia_kg_m2 = parameters.mass_kg, parameters.inertia_kg_m2
        link.volume_m3, link.added_mass = shape.solid.volume_m3, parameters.added_mass
        link.quadratic_drag = np.diag(parameters.quadratic_damping).copy()
        links.append(link)
    return links


def object_mesh(scenario: Scenario, body: LooseBody) -> tuple[Vertices, Triangles]:
    """Return a body's surface in its frame: vertices (n, 3) [m] and triangles (m, 3)."""
    shape = _placed(body.shape, build_terrain(scenario.terrain))
    return shape.vertices, shape.triangles


def object_start(body: LooseBody, terrain: Bed) -> tuple[Vertices, Triangles]:
    """Return a body's surface in the world at its start: vertices (n, 3) [m] and triangles (m, 3)."""
    shape = _placed(body.shape, terrain)
    return shape.position_m + turned(shape.orientation_xyzw, shape.vertices), shape.triangles


def _spec(body: LooseBody, scenario: Scenario) -> _core.ObjectSpec:
    shape, water_kg_m3 = _placed(body.shape, build_terrain(scenario.terrain)), surface_density_kg_m3(scenario.water)
    if body.path is not None:
        arm_m = turned(shape.orientation_xyzw, shape.solid.centroid_m)
        followed = body_path(body.path, shape.position_m - arm_m, arm_m, shape.orientation_xyzw)
        return _unpushed(body, followed, shape, water_kg_m3)
    if body.fixed:
        return _unpushed(body, standing(shape.position_m, shape.orientation_xyzw), shape, water_kg_m3)
    parameters = _parameters(body, shape, water_kg_m3)
    inverse = shape.orientation_xyzw * [-1.0, -1.0, -1.0, 1.0]
    velocity = np.concatenate([turned(inverse, body.velocity_m_s), np.zeros(3)])
    return _core.ObjectSpec(
        body.name, _core.Craft(parameters, shape.vertices, shape.triangles), _core.CollisionShape.HULL, body.friction,
        body.restitution, _core.BodyState(shape.position_m, shape.orientation_xyzw, velocity),
        [applied_wrench(wrench, scenario.step_s) for wrench in body.wrenches or ()], round=shape.round,
    )  # fmt: skip


def _parameters(body: LooseBody, shape: _Shape, water_kg_m3: float) -> _core.CraftParameters:
    """Return the mass of a body and its coefficients in water of a density."""
    volume_m3 = shape.solid.volume_m3
    density = body.density_kg_m3 if body.density_kg_m3 is not None else (body.mass_kg or 0.0) / volume_m3
    added, areas, paddles, rubbing = (
        _flow_around_sphere(shape.round.radius_m)
        if shape.round is not None and body.shape.kind == "sphere"
        else _flow(shape.vertices, shape.triangles)
    )
    parameters = _core.CraftParameters()
    parameters.mass_kg = density * volume_m3
    parameters.inertia_kg_m2 = density * shape.solid.inertia_per_density_m5
    parameters.added_mass, parameters.munk_share = water_kg_m3 * added, body.munk_share
    if (stated := body.drag_coefficient) is not None:
        drag = np.full(3, stated)
    else:
        net_kg = parameters.mass_kg - water_kg_m3 * volume_m3
        drag = default_drag(body.shape.kind, np.ptp(shape.vertices, axis=0), net_kg, water_kg_m3)
    across = 0.5 * (np.roll(drag, 1) + np.roll(drag, 2))  # a turn moves its paddles along the two other axes
    turning = across * paddles + SKIN_FRICTION * rubbing
    parameters.quadratic_damping = np.diag(0.5 * water_kg_m3 * np.concatenate([drag * areas, turning]))
    return parameters


def _unpushed(body: LooseBody, path: _core.BodyPath, shape: _Shape, water_kg_m3: float) -> _core.ObjectSpec:
    """Return a body that no force moves: its mass, that of water, has no effect."""
    parameters = _core.CraftParameters()
    parameters.mass_kg = water_kg_m3 * shape.solid.volume_m3
    parameters.inertia_kg_m2 = water_kg_m3 * shape.solid.inertia_per_density_m5
    return _core.ObjectSpec(
        body.name, _core.Craft(parameters, shape.vertices, shape.triangles), _core.CollisionShape.HULL, body.friction,
        body.restitution, path.at(0.0), path=path, links=_links(body, shape), round=shape.round,
    )  # fmt: skip


def _links(body: LooseBody, shape: _Shape) -> list[_core.ArmLink]:
    """Return what joints hold on a body. Theirs are places in its shape's frame; the core's are from its middle."""
    middle = shape.solid.centroid_m
    held = {
        name: link if link.on else link.model_copy(update={"position_m": tuple(np.subtract(link.position_m, middle))})
        for name, link in (body.links or {}).items()
    }
    return link_specs(held)


def object_points(body: LooseBody, terrain: Bed) -> Floats:
    """Return where the middle of a body starts, or the points of its path, (n, 3). Raises ScenarioError."""
    shape = _placed(body.shape, terrain)
    if body.path is None:
        return shape.position_m[None]
    return points_on(body.path, shape.position_m - turned(shape.orientation_xyzw, shape.solid.centroid_m))


def _placed(obstacle: ObstacleModel, terrain: Bed) -> _Shape:
    afloat = grounded(obstacle, terrain)
    angles_deg = getattr(afloat, "yaw_pitch_roll_deg", LEVEL)
    level = {"yaw_pitch_roll_deg": LEVEL} if "yaw_pitch_roll_deg" in type(afloat).model_fields else {}
    own = afloat.model_copy(update={"position_m": LEVEL, **level}).solid(terrain)
    vertices, triangles = closed_mesh(own.vertices, own.triangles, name=obstacle.name)
    solid = _core.solid_properties(vertices, triangles)
    turn = of_yaw_pitch_roll_deg(angles_deg)
    position = np.asarray(afloat.position_m) + turned(turn, solid.centroid_m)  # type: ignore[attr-defined]
    centred = np.ascontiguousarray(np.asarray(vertices, np.float64) - solid.centroid_m)
    exact = own.shapes[0] if own.shapes else None
    return _Shape(centred, np.asarray(triangles, np.uint32), solid, position, turn, exact)


def _flow_around_sphere(radius_m: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the same as `_flow` for a sphere, in closed form: half of its volume moves with it (Lamb 1932, sec. 92).

    Facets would not be quite alike along all axes, so that it would turn and drift aside as it falls.
    """
    added = np.diag(2.0 / 3.0 * np.pi * radius_m**3 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    ones = np.ones(3)
    return added, np.pi * radius_m**2 * ones, np.zeros(3), 0.75 * np.pi**2 * radius_m**5 * ones


def _flow(vertices: Vertices, triangles: Triangles) -> tuple[Floats, Floats, Floats, Floats]:
    """Return what the flow around a shape depends on, for water of density 1 and a drag coefficient of 1.

    Added mass (6, 6); projected areas (3,) [m2]; and the third moments (3,) [m5] of the areas across the motion, and of
    all areas, by which drag and friction brake turns about each axis.
    """

    def make() -> tuple[Floats, ...]:
        from uwsim.base.whole_trimesh import trimesh
        from uwsim.scenario.build.hydrodynamics import simplified  # it needs scipy, which is slow to import

        added = _core.added_mass(*simplified(vertices, triangles, PANELS), 1.0, PANELS)
        hull = trimesh.convex.convex_hull(vertices)
        areas = 0.5 * np.abs(hull.face_normals).T @ hull.area_faces
        while len(hull.faces) < ELEMENTS:
            hull = hull.subdivide()
        across, rubbing = np.zeros(3), np.zeros(3)
        for axis in range(3):
            motion = np.cross(np.eye(3)[axis], hull.triangles_center)
            speed = np.linalg.norm(motion, axis=1)
            facing = np.abs(np.sum(hull.face_normals * motion, axis=1))
            across[axis] = 0.5 * np.sum(facing * speed**2 * hull.area_faces)
            rubbing[axis] = np.sum(speed**3 * hull.area_faces)
        return 0.5 * (added + added.T), areas, across, rubbing

    added, areas, across, rubbing = cached_arrays(make, "flow", vertices, triangles)
    return cast("tuple[Floats, Floats, Floats, Floats]", (added, areas, across, rubbing))
