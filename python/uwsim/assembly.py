"""From a scenario's vehicle to the native core's: the hull, its mass, its drive, its sensors and its sonar."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.scenario import Scenario, VehicleModel, rigid_body, start_pose, vehicle_hull
from uwsim.scenario.build import backscatter_by_label
from uwsim.scenario.collision_shapes import vehicle_pieces
from uwsim.scenario.schema import Vehicle
from uwsim.scenario.water import surface_density_kg_m3

SHAPES = {"hull": _core.CollisionShape.HULL, "box": _core.CollisionShape.BOX}


def vehicle_spec(scenario: Scenario, vehicle: Vehicle) -> _core.VehicleSpec:
    """All that the core needs to make this vehicle. Raises ScenarioError or ValueError."""
    model = vehicle.model
    spec = _core.VehicleSpec()
    spec.name = vehicle.name
    spec.craft = _craft(model, surface_density_kg_m3(scenario.water))
    spec.actuators = _actuators(model)
    if model.collision_pieces is not None:
        spec.set_collision_pieces(vehicle_pieces(model))
    else:
        spec.shape = SHAPES[model.collision]
    spec.friction = model.friction
    spec.restitution = model.restitution
    position_m, yaw_rad = start_pose(scenario, vehicle)
    spec.set_start(position_m, Rotation.from_euler("z", yaw_rad).as_quat())
    spec.docked = vehicle.start is None
    spec.sensors = [sensor.core_spec(name) for name, sensor in model.sensors.items()]
    if model.sonar is not None:
        spec.sonars = [_sonar(scenario, vehicle, model.sonar.position_m)]
    return spec


def _sonar(scenario: Scenario, vehicle: Vehicle, mount_m: tuple[float, float, float]) -> _core.SonarSpec:
    sonar, model = vehicle.sonar, vehicle.sonar.loaded
    acoustics = None
    if sonar.mode == "physics":
        acoustics = model.core_acoustics(
            sonar.frequency_khz,
            bending=sonar.bending,
            rays_per_beam=sonar.rays_per_beam,
            bottoms=backscatter_by_label(scenario),
        )
    return _core.SonarSpec(
        "sonar",
        model.core_model(sonar.frequency_khz),
        np.add(mount_m, model.mounting.position_m),
        model.mounting.orientation_xyzw,
        elevation_rad=-np.radians(sonar.tilt_deg),
        acoustics=acoustics,
    )


def _actuators(model: VehicleModel) -> _core.ActuatorsSpec:
    spec = _core.ActuatorsSpec()
    if model.max_force_n is not None and model.max_torque_nm is not None:
        spec.full_wrench_body = np.array([*model.max_force_n, *model.max_torque_nm])
    spec.thrusters = [thruster.core_spec(name) for name, thruster in model.thrusters.items()]
    spec.fins = [fin.core_spec(name) for name, fin in model.fins.items()]
    return spec


def _craft(model: VehicleModel, water_density_kg_m3: float) -> _core.Craft:
    body = rigid_body(model, water_density_kg_m3)
    parameters = _core.CraftParameters()
    parameters.mass_kg = body.mass_kg
    parameters.centre_of_mass_body_m = body.centre_of_mass_m
    parameters.inertia_kg_m2 = np.diag(body.inertia_kg_m2)
    parameters.added_mass = model.matrix("added_mass")
    parameters.linear_damping = model.matrix("linear_damping")
    parameters.quadratic_damping = model.matrix("quadratic_damping")
    return _core.Craft(parameters, *vehicle_hull(model))
