"""A vehicle's hull in the water as a core object, with ballast and compressibility, and the settings of its control."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.scenario.build.earth import STANDARD_M_S2, gravity_m_s2
from uwsim.scenario.build.equipment import actuators_spec
from uwsim.scenario.build.hull import RigidBody, rigid_body, vehicle_hull
from uwsim.scenario.build.scale import require_floats, require_plausible_density
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.build.water import build_water
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.actuator import Loop
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import Trim, VehicleModel, load_vehicle

MAX_TAKEN_OFF = 0.5
"""The largest fraction of a vehicle's mass that trimming may remove."""


class PointMass(NamedTuple):
    """A point mass. mass_kg: negative for removed weight. position_m: (3,), body frame."""

    mass_kg: float
    position_m: Floats


def trim_weights(
    model: VehicleModel, body: RigidBody, trim: Trim | None, water_density_kg_m3: float,
    gravity_m_s2: float = STANDARD_M_S2,
) -> PointMass:  # fmt: skip
    """Return the weight that trims the body: rho V - B / g - m. Raises ScenarioError if it is unrealistic."""
    if trim is None:
        return PointMass(0.0, body.centre_of_mass_m)
    displaced_kg = water_density_kg_m3 * body.volume_m3
    added_kg = displaced_kg - trim.net_buoyancy_n / gravity_m_s2 - body.mass_kg
    if added_kg < -MAX_TAKEN_OFF * body.mass_kg:
        most_n = (displaced_kg - (1.0 - MAX_TAKEN_OFF) * body.mass_kg) * gravity_m_s2
        raise ScenarioError(
            f"vehicle '{model.name}': trim.net_buoyancy_n = {trim.net_buoyancy_n:g} N: must be at most {most_n:.4g} N "
            f"in this water: it would remove {-added_kg:.3g} kg of its {body.mass_kg:.4g} kg, more than half",
            at=("trim", "net_buoyancy_n"),
        )
    at = body.centre_of_mass_m if trim.position_m is None else np.asarray(trim.position_m)
    return PointMass(added_kg, at)


def mass_with_ballast(model: VehicleModel, body: RigidBody, trim: PointMass) -> tuple[float, Floats, Floats]:
    """Return the mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m2], in body axes.

    Trim and ballast are point masses; moments of inertia follow from the parallel axis theorem. Raises ScenarioError.
    """
    ballast = PointMass(model.ballast_kg, np.asarray(model.ballast_position_m))
    masses = [each for each in (trim, ballast) if each.mass_kg != 0.0]
    inertia = np.diag(body.inertia_kg_m2)
    if not masses:
        return body.mass_kg, body.centre_of_mass_m, inertia
    parts = [PointMass(body.mass_kg, body.centre_of_mass_m), *masses]
    mass = sum(part.mass_kg for part in parts)
    centre = sum((part.mass_kg * part.position_m for part in parts), np.zeros(3)) / mass
    for part in parts:
        arm = part.position_m - centre
        inertia = inertia + part.mass_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    smallest, middle, largest = np.linalg.eigvalsh(inertia)
    if smallest <= 0.0 or largest > (smallest + middle) * (1.0 + 1e-9):
        rule = f"{-trim.mass_kg:.3g} kg cannot be removed there: no physical body would remain; choose a nearer place"
        raise ScenarioError(f"vehicle '{model.name}': trim.position_m: {rule}", at=("trim", "position_m"))
    return mass, centre, inertia


STEP_M = 25.0  # keeps the relative error of linear interpolation below 1e-8


def buoyancy_share(scenario: Scenario, compressibility_1_pa: float) -> NDArray[np.float64]:
    """Return the buoyancy of a submerged hull relative to that at surface pressure, every STEP_M down to the bed.

    (n,): rho(z) V(z) / (rho_0(z) V_0). If the water is compressible, its density increases with pressure by EOS-80
    (sea_water.h). The volume follows dV / V = -compressibility dp, so V = V_0 exp(-compressibility p) at gauge pressure
    p.
    """
    terrain = build_terrain(scenario.terrain).window(scenario.terrain.window_m)
    gravity = gravity_m_s2(scenario.earth)
    water = build_water(
        scenario.water, bottom_depth_m=-terrain.lowest_m, seed=scenario.seed, gravity_m_s2=gravity,
        place=partial(georeference, scenario),
    )  # fmt: skip
    depths_m = STEP_M * np.arange(int(np.ceil(-terrain.lowest_m / STEP_M)) + 1)
    return np.array([_share(water, -depth, compressibility_1_pa) for depth in depths_m.tolist()])


def _share(water: _core.Water, z_m: float, compressibility_1_pa: float) -> float:
    gauge_pa = water.pressure_pa(z_m) - water.atmospheric_pressure_pa
    squeezed = 1.0
    if water.compressible:
        state = water.temperature_deg_c(z_m), water.salinity_at_psu(z_m)
        squeezed = _core.sea_water_density_kg_m3(*state, gauge_pa) / _core.sea_water_density_kg_m3(*state)
    return squeezed * float(np.exp(-compressibility_1_pa * gauge_pa))


def craft(
    model: VehicleModel,
    water_density_kg_m3: float,
    trim: Trim | None = None,
    buoyancy_share: NDArray[np.float64] | None = None,
    gravity_m_s2: float = STANDARD_M_S2,
) -> _core.Craft:
    """Return the vehicle's equations of motion in water with this surface density.

    trim: the vehicle's trim; None keeps the published mass and balance. buoyancy_share: the result of
    compressibility.buoyancy_share; by default the hull is as compressible as the water around it. gravity_m_s2: with
    which the trim has its net buoyancy. Raises ScenarioError.
    """
    parameters = _core.CraftParameters()
    parameters.mass_kg, parameters.centre_of_mass_body_m, parameters.inertia_kg_m2 = mass_properties(
        model, water_density_kg_m3, trim, gravity_m_s2
    )
    parameters.added_mass = model.matrix("added_mass")
    parameters.linear_damping = model.matrix("linear_damping")
    parameters.quadratic_damping = model.matrix("quadratic_damping")
    parameters.munk_share, parameters.crossflow_length_m = model.munk_share, model.crossflow_length_m
    if model.coefficients == "afloat":
        afloat = rigid_body(model, water_density_kg_m3)
        require_floats("coefficients", afloat.mass_kg, afloat.volume_m3, water_density_kg_m3)
        parameters.coefficients_volume_m3 = afloat.mass_kg / water_density_kg_m3
    if buoyancy_share is not None:
        parameters.buoyancy_share, parameters.buoyancy_share_step_m = buoyancy_share.tolist(), STEP_M
    return _core.Craft(parameters, *vehicle_hull(model))


def mass_properties(
    model: VehicleModel, water_density_kg_m3: float, trim: Trim | None = None, gravity_m_s2: float = STANDARD_M_S2
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m2] in body axes.

    Trim and ballast are included. Raises ScenarioError.
    """
    body = rigid_body(model, water_density_kg_m3)
    mass = mass_with_ballast(model, body, trim_weights(model, body, trim, water_density_kg_m3, gravity_m_s2))
    require_plausible_density(model.name, mass[0], body.volume_m3, model.mesh_scale, "mass, trim and ballast")
    return mass


@dataclass(frozen=True, eq=False)
class ControlSettings:
    """A vehicle's motion model and gains, from its file.

    thrusters: number of thrusters; 0 for a vehicle driven by forces along its axes. speed_min_m_s: the speed below
    which fins do not turn it.
    """

    model: _core.ControlModel
    gains: _core.ControlGains
    thrusters: int = 0
    speed_min_m_s: float = 0.0

    @property
    def net_buoyancy_n(self) -> float:
        """The net vertical force deep in still water with thrusters off; positive if the vehicle rises."""
        return -float(self.model.wrench_body(np.eye(3), np.zeros(6), np.zeros(6))[2])

    def __repr__(self) -> str:
        driven = ", ".join(axis for axis, is_driven in zip(AXES, self.model.driven, strict=True) if is_driven)
        return f"<ControlSettings: drives {driven}; {floating_text(self.net_buoyancy_n)}>"


def floating_text(net_buoyancy_n: float) -> str:
    """Return a description such as `rises by 2.0 N`."""
    if abs(net_buoyancy_n) < 0.05:
        return "balanced in the water"
    return f"{'rises' if net_buoyancy_n > 0.0 else 'sinks'} by {abs(net_buoyancy_n):.1f} N"


def control_settings(vehicle: str | Path | VehicleModel, density_kg_m3: float = 1000.0) -> ControlSettings:
    """Return the control settings of a vehicle, given as a packaged name, a file or a model.

    density_kg_m3: density of the water. Raises ScenarioError, also for gains of an axis without actuators.
    """
    model = vehicle if isinstance(vehicle, VehicleModel) else load_vehicle(vehicle)
    return built_settings(model, craft(model, density_kg_m3, model.trim), actuators_spec(model), density_kg_m3)


def built_settings(
    model: VehicleModel, body: _core.Craft, actuators: _core.ActuatorsSpec, density_kg_m3: float,
    gravity_m_s2: float = STANDARD_M_S2,
) -> ControlSettings:  # fmt: skip
    """Return the control settings of a vehicle whose core objects have been built. Raises ScenarioError."""
    plant = _core.ControlModel(body, actuators, density_kg_m3, gravity_m_s2)
    control = model.control
    for axis, is_driven in zip(AXES, plant.driven, strict=True):
        if axis in control.model_fields_set and not is_driven:
            raise ScenarioError(f"control.{axis}: nothing drives the {axis} of '{model.name}'", at=("control", axis))
    gains = _core.ControlGains(
        loops=[_loop(getattr(control, axis)) for axis in AXES],
        filter_s=control.filter_s,
        tracking_s=control.tracking_s,
        speed_max_m_s=control.speed_max_m_s,
        climb_max_m_s=control.climb_max_m_s,
        turn_max_rad_s=control.turn_max_rad_s,
        acceleration_max_m_s2=control.acceleration_max_m_s2,
        turn_acceleration_max_rad_s2=control.turn_acceleration_max_rad_s2,
    )
    return ControlSettings(plant, gains, len(model.thrusters), control.speed_min_m_s)


def _loop(loop: Loop) -> _core.LoopGains:
    return _core.LoopGains(
        position_1_s=loop.position_1_s,
        velocity_1_s=loop.velocity_1_s,
        integral_1_s2=loop.integral_1_s2,
        acceleration_1=loop.acceleration_share,
    )
