"""From a scenario's vehicle to the native core's: the hull, its mass, its drive, its sensors and its sonar."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.scenario import Scenario, VehicleModel, rigid_body, start_pose, vehicle_hull
from uwsim.scenario.schema import Vehicle

LEVEL_XYZW = (0.0, 0.0, 0.0, 1.0)
SHAPES = {"hull": _core.CollisionShape.HULL, "box": _core.CollisionShape.BOX}


def vehicle_spec(scenario: Scenario, vehicle: Vehicle) -> _core.VehicleSpec:
    """All that the core needs to make this vehicle. Raises ScenarioError or ValueError."""
    model = vehicle.model
    spec = _core.VehicleSpec()
    spec.name = vehicle.name
    spec.craft = _craft(model, scenario.water.density_kg_m3)
    spec.full_wrench_body = np.array([*model.max_force_n, *model.max_torque_nm])
    spec.shape = SHAPES[model.collision]
    spec.friction = model.friction
    spec.restitution = model.restitution
    position_m, yaw_rad = start_pose(scenario, vehicle)
    spec.set_start(position_m, Rotation.from_euler("z", yaw_rad).as_quat())
    spec.docked = vehicle.start is None
    spec.sensors = [
        _core.SensorSpec(
            name,
            sensor.kind,
            sensor.position_m,
            Rotation.from_euler("ZYX", sensor.yaw_pitch_roll_deg, degrees=True).as_quat(),
            sensor.range_max_m or 0.0,
            sensor.noise_std,
        )
        for name, sensor in model.sensors.items()
    ]
    up_rad = -np.radians(vehicle.sonar.tilt_deg)
    spec.sonars = [_core.SonarSpec("sonar", vehicle.sonar.model, model.sonar.position_m, LEVEL_XYZW, up_rad)]
    return spec


def _craft(model: VehicleModel, water_density_kg_m3: float) -> _core.Craft:
    body = rigid_body(model, water_density_kg_m3)
    parameters = _core.CraftParameters()
    parameters.mass_kg = body.mass_kg
    parameters.centre_of_mass_body_m = body.centre_of_mass_m
    parameters.inertia_kg_m2 = np.diag(body.inertia_kg_m2)
    parameters.linear_damping = np.diag(model.linear_damping)
    parameters.quadratic_damping = np.diag(model.quadratic_damping)
    if model.added_mass is not None:
        parameters.added_mass = np.diag(model.added_mass)
    return _core.Craft(parameters, *vehicle_hull(model))
