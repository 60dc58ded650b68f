"""Derived properties of a vehicle: size, mass, attitude at rest, stability, and mounts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.evidence.vehicle.afloat import boat_at_rest
from uwsim.evidence.vehicle.linear_motion import course_growth_1_s, model_motion
from uwsim.evidence.vehicle.trials import Slip, StraightRun, slip, straight_run
from uwsim.evidence.vehicle.views import Mount, mounts
from uwsim.scenario import ScenarioError
from uwsim.scenario.build.craft import mass_with_ballast, trim_weights
from uwsim.scenario.build.earth import STANDARD_M_S2
from uwsim.scenario.build.hull import RigidBody, rigid_body, vehicle_hull
from uwsim.scenario.spec.vehicle import Trim, VehicleModel

NO_LEVER_M = 1e-3
"""Distance between the centres of mass and buoyancy below which righting moments are negligible."""
UNDER_WAY_M_S = 1.5
"""The speed at which course stability is assessed, typical of AUVs."""
SURGE, SWAY = 0, 1


@dataclass(frozen=True)
class VehicleFigures:
    """A vehicle with its ballast and trim, fully submerged (but for what floats) in water of water_density_kg_m3.

    size_m: size of the hull's bounding box. righting_lever_m: height of the centre of buoyancy above the centre of mass
    in the body frame, which is also the metacentric height of a submerged body; negative if the vehicle turns over.
    righting_nm_rad: righting moment per radian from rest. nose_down_deg, roll_to_starboard_deg: attitude at rest, None
    without a righting moment. inertia_kg_m2, gyration_m: moments of inertia and radii of gyration about the body axes,
    without ballast and trim.
    hull_gyration_m: the same for the hull as a solid. reach_m: distance of the hull's farthest point from each axis.
    metacentric_m: heights of the metacentres for roll and pitch above the centre of mass, of a boat as it floats, with
    its attitude there; None for other vehicles. glides: whether a buoyancy engine and fins drive it.
    drives: axes with thrusters or fins. course_growth_1_s: growth rate of a yaw disturbance without control at
    UNDER_WAY_M_S, negative if it decays; None if thrusters can push the vehicle sideways. straight: None if nothing
    drives it ahead, or its motion diverges. slip: how its side slip dies down, of a submerged vehicle whose sway
    nothing drives; None for others.
    """

    size_m: tuple[float, float, float]
    volume_m3: float
    mass_kg: float
    density_kg_m3: float
    water_density_kg_m3: float
    net_buoyancy_n: float
    centre_of_mass_m: tuple[float, float, float]
    centre_of_buoyancy_m: tuple[float, float, float]
    righting_lever_m: float
    righting_nm_rad: float
    nose_down_deg: float | None
    roll_to_starboard_deg: float | None
    inertia_kg_m2: tuple[float, float, float]
    gyration_m: tuple[float, float, float]
    hull_gyration_m: tuple[float, float, float]
    reach_m: tuple[float, float, float]
    drives: tuple[str, ...]
    course_growth_1_s: float | None
    straight: StraightRun | None
    mounts: tuple[Mount, ...]
    metacentric_m: tuple[float, float] | None = None
    glides: bool = False
    slip: Slip | None = None


def vehicle_figures(
    model: VehicleModel,
    control: _core.ControlModel,
    density_kg_m3: float,
    trim: Trim | None,
    gravity_m_s2: float = STANDARD_M_S2,
) -> VehicleFigures:
    """Return a vehicle's properties. control: its control model in that water. trim: replaces the model's trim.

    Raises ScenarioError if the vehicle cannot be built.
    """
    body = rigid_body(model, density_kg_m3)
    weights = trim_weights(model, body, trim or model.trim, density_kg_m3, gravity_m_s2)
    mass_kg, centre_m, _ = mass_with_ballast(model, body, weights)
    lever_m = body.centre_of_buoyancy_m - centre_m
    buoyancy_n = density_kg_m3 * body.volume_m3 * gravity_m_s2
    # The file states the vehicle without its arm, whose weight decides how both rest.
    nose_down_deg, roll_deg = rest_attitude_deg(lever_m) if model.arm is None else (None, None)
    boat = boat_at_rest(model, density_kg_m3, trim) if model.coefficients == "afloat" else None
    if boat is not None:
        nose_down_deg, roll_deg = boat.nose_down_deg, boat.roll_to_starboard_deg
    vertices, _ = vehicle_hull(model)
    glides = bool(model.fins) and any(mount.force == "buoyancy" for mount in model.thrusters.values())
    return VehicleFigures(
        size_m=_three(np.ptp(vertices, axis=0)),
        volume_m3=body.volume_m3,
        mass_kg=mass_kg,
        density_kg_m3=mass_kg / body.volume_m3,
        water_density_kg_m3=density_kg_m3,
        net_buoyancy_n=buoyancy_n - mass_kg * gravity_m_s2,
        centre_of_mass_m=_three(centre_m),
        centre_of_buoyancy_m=_three(body.centre_of_buoyancy_m),
        righting_lever_m=float(lever_m[2]),
        righting_nm_rad=buoyancy_n * float(np.linalg.norm(lever_m)),
        nose_down_deg=nose_down_deg,
        roll_to_starboard_deg=roll_deg,
        inertia_kg_m2=_three(body.inertia_kg_m2),
        gyration_m=_three(np.sqrt(body.inertia_kg_m2 / body.mass_kg)),
        hull_gyration_m=_three(np.sqrt(_solid_inertia(model, density_kg_m3) / body.mass_kg)),
        reach_m=_reach_m(vertices, body),
        drives=tuple(axis for axis, is_driven in zip(AXES, control.driven, strict=True) if is_driven),
        course_growth_1_s=None
        if control.driven[SWAY]
        else course_growth_1_s(model_motion(model, trim or model.trim, density_kg_m3, UNDER_WAY_M_S)),
        straight=_straight(model, density_kg_m3, trim) if control.driven[SURGE] else None,
        mounts=mounts(model),
        metacentric_m=None if boat is None else (boat.roll_m, boat.pitch_m),
        glides=glides,
        slip=None if boat is not None or glides or control.driven[SWAY] else slip(model, density_kg_m3, trim),
    )


def _straight(model: VehicleModel, density_kg_m3: float, trim: Trim | None) -> StraightRun | None:
    try:
        return straight_run(model, density_kg_m3, trim)
    except ScenarioError:
        raise
    except ValueError:
        return None


def rest_attitude_deg(lever_m: Floats) -> tuple[float | None, float | None]:
    """Return pitch (nose down) and roll (to starboard) of a submerged body at rest.

    At rest the centre of buoyancy is directly above the centre of mass.

    lever_m: (3,), from the centre of mass to the centre of buoyancy, body frame. At this attitude buoyancy and weight
    have no moment, whatever their magnitudes, and a body turned away from it returns to it.
    """
    length_m = float(np.linalg.norm(lever_m))
    if length_m < NO_LEVER_M:
        return None, None
    up = lever_m / length_m
    return float(-np.degrees(np.arcsin(np.clip(up[0], -1.0, 1.0)))) + 0.0, float(np.degrees(np.arctan2(up[1], up[2])))


def _solid_inertia(model: VehicleModel, density_kg_m3: float) -> Floats:
    """Return the moments of inertia of the hull as a solid with the model's mass, about its own centre."""
    return rigid_body(model.model_copy(update={"inertia_kg_m2": None}), density_kg_m3).inertia_kg_m2


def _reach_m(vertices_m: Floats, body: RigidBody) -> tuple[float, float, float]:
    arms = vertices_m - body.centre_of_mass_m
    return _three(np.array([np.hypot(arms[:, (k + 1) % 3], arms[:, (k + 2) % 3]).max() for k in range(3)]))


def _three(values: Floats) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
