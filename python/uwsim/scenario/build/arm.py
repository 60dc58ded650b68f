"""A vehicle's arm as the core's ArmLinks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.read.mesh_repair import closed_mesh
from uwsim.scenario.spec.arm import Hinge, Link, Slide, links_in_order
from uwsim.scenario.spec.obstacle import Bed
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel


def link_specs(arm: Mapping[str, Link]) -> list[_core.ArmLink]:
    """Return the core's links, each after the one that holds it."""
    names = links_in_order(arm)
    return [_spec(name, arm[name], names) for name in names]


def shaped_links(model: VehicleModel) -> dict[str, Link]:
    """Return the links that have a shape, in the core's order."""
    return with_shape(model.arm or {})


def with_shape(arm: Mapping[str, Link]) -> dict[str, Link]:
    """Return the links that have a shape, in the core's order."""
    return {name: arm[name] for name in links_in_order(arm) if arm[name].shape is not None}


def all_shaped_links(scenario: Scenario) -> list[tuple[str, Link]]:
    """Return all links that have a shape, of vehicles and then of objects, with the names of their bodies.

    The order is that of Simulation.link_surfaces and of labels.
    """
    carried = [(entry.name, shaped_links(entry.model)) for entry in scenario.vehicles]
    carried += [(body.name, with_shape(body.links or {})) for body in scenario.objects]
    return [(name, link) for name, links in carried for link in links.values()]


def link_mesh(link: Link) -> tuple[Vertices, Triangles]:
    """Return the shape of a link as a closed mesh in its frame: vertices (n, 3) [m], triangles (m, 3).

    Raises ScenarioError.
    """
    assert link.shape is not None
    own = link.shape.solid(cast("Bed", None))  # shapes of these kinds do not stand on a bed
    vertices, triangles = closed_mesh(own.vertices, own.triangles, name=link.shape.name)
    return np.ascontiguousarray(vertices, np.float64), np.asarray(triangles, np.uint32)


def _spec(name: str, link: Link, names: list[str]) -> _core.ArmLink:
    spec = _core.ArmLink()
    spec.name = name
    spec.parent = None if link.on is None else names.index(link.on)
    spec.set_pose(link.position_m, of_yaw_pitch_roll_deg(link.yaw_pitch_roll_deg))
    spec.mass_kg = link.mass_kg
    spec.centre_of_mass_m = link.centre_of_mass_m
    xy, xz, yz = link.inertia_products_kg_m2
    spec.inertia_kg_m2 = np.diag(link.inertia_kg_m2) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
    spec.volume_m3 = link.volume_m3
    centre_m = link.centre_of_buoyancy_m or link.centre_of_mass_m
    spec.centre_of_buoyancy_m = centre_m
    if link.added_mass is not None:
        spec.added_mass = _at_origin(np.diag(link.added_mass), centre_m)
    if link.linear_drag is not None:
        spec.linear_drag = np.array(link.linear_drag)
    if link.quadratic_drag is not None:
        spec.quadratic_drag = np.array(link.quadratic_drag)
    if link.shape is not None:
        spec.set_surface(*link_mesh(link))
    spec.friction = link.friction
    spec.joint = _core.JointKind.FIXED
    if link.hinge is not None:
        _turning(spec, link.hinge)
    elif link.slide is not None:
        _sliding(spec, link.slide)
    return spec


def _at_origin(mass: Floats, centre_m: tuple[float, float, float]) -> Floats:
    """Return a 6x6 mass at a point as it is at the origin: H^T M H, H the motion of the point (Fossen 2011, 7.33)."""
    x, y, z = centre_m
    moved = np.eye(6)
    moved[:3, 3:] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(moved.T @ mass @ moved, np.float64)


def _turning(spec: _core.ArmLink, hinge: Hinge) -> None:
    spec.joint, spec.axis = _core.JointKind.HINGE, hinge.axis
    spec.start = math.radians(hinge.start_deg)
    if hinge.limits_deg is not None:
        spec.lowest, spec.highest = map(math.radians, hinge.limits_deg)
    spec.viscous_friction, spec.coulomb_friction = hinge.viscous_nm_s_rad, hinge.coulomb_nm
    if (motor := hinge.motor) is not None:
        spec.strongest, spec.fastest = motor.strongest_nm, math.radians(motor.fastest_deg_s)
        spec.response_s, spec.gear_ratio = motor.response_s, motor.gear_ratio
        spec.rotor_inertia_kg_m2 = motor.rotor_inertia_kg_m2
        spec.torque_per_ampere = motor.torque_per_ampere_nm_a or 0.0


def _sliding(spec: _core.ArmLink, slide: Slide) -> None:
    spec.joint, spec.axis = _core.JointKind.SLIDE, slide.axis
    spec.start = slide.start_m
    if slide.limits_m is not None:
        spec.lowest, spec.highest = slide.limits_m
    spec.viscous_friction, spec.coulomb_friction = slide.viscous_n_s_m, slide.coulomb_n
    if (motor := slide.motor) is not None:
        spec.strongest, spec.fastest = motor.strongest_n, motor.fastest_m_s
        spec.response_s, spec.gear_ratio = motor.response_s, motor.gear_rad_m
        spec.rotor_inertia_kg_m2 = motor.rotor_inertia_kg_m2
        spec.torque_per_ampere = motor.force_per_ampere_n_a or 0.0
