"""A scenario's vehicle as the core's VehicleSpec, and a vehicle completed with what its file does not state."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import about_z
from uwsim.scenario.build.arm import link_specs
from uwsim.scenario.build.craft import ControlSettings, built_settings, buoyancy_share, craft
from uwsim.scenario.build.earth import gravity_m_s2
from uwsim.scenario.build.equipment import (
    actuators_spec,
    applied_wrench,
    battery_spec,
    measures_temperature,
    sensor_spec,
)
from uwsim.scenario.build.hull import is_boat, rigid_body
from uwsim.scenario.build.loose_bodies import held_links
from uwsim.scenario.build.measured_water import require_temperature
from uwsim.scenario.build.multibeam import acoustic_spec, backscatter_by_label, multibeam_model
from uwsim.scenario.build.station import start_pose
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.build.wind import windage
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import VehicleEntry


def completed(model: VehicleModel, density_kg_m3: float) -> tuple[VehicleModel, tuple[str, ...]]:
    """Return a vehicle that states its volume, centre of buoyancy and inertia, and the keys that were added.

    What its file does not state is that of its hull, in water of this density.
    """
    body = rigid_body(model, density_kg_m3)
    own = {
        "volume_m3": body.volume_m3,
        "centre_of_buoyancy_m": tuple(map(float, body.centre_of_buoyancy_m)),
        "inertia_kg_m2": tuple(map(float, body.inertia_kg_m2)),
    }
    added = {key: value for key, value in own.items() if getattr(model, key) is None}
    return model.model_copy(update=added), tuple(added)


def double_integrator(model: VehicleModel, density_kg_m3: float) -> VehicleModel:
    """Return the simplest model of a vehicle: its masses and thrusters, without drag and lift; neutral, but for a boat.

    A boat still floats upright.
    """
    whole, _ = completed(model, density_kg_m3)
    still = dict.fromkeys(("linear_damping", "quadratic_damping"), (0.0,) * 6)
    update: dict[str, Any] = {
        **still,
        "linear_damping_matrix": None,
        "quadratic_damping_matrix": None,
        "munk_share": 0.0,
        "fins": {},
    }
    if not is_boat(model, density_kg_m3):
        update |= {"buoyancy": "neutral", "mass_kg": None, "centre_of_buoyancy_m": whole.centre_of_mass_m}
    return whole.model_copy(update={**update, "crossflow_length_m": 0.0, "windage": None})


COLLISION_SHAPES = {"hull": _core.CollisionShape.HULL, "box": _core.CollisionShape.BOX}


def vehicle_spec(scenario: Scenario, vehicle: VehicleEntry) -> _core.VehicleSpec:
    """Return the core's spec of this vehicle. Raises ScenarioError or ValueError."""
    model = vehicle.model
    spec = _core.VehicleSpec()
    spec.name = vehicle.name
    squeeze = None if model.compressibility_1_pa is None else buoyancy_share(scenario, model.compressibility_1_pa)
    density_kg_m3, gravity = surface_density_kg_m3(scenario.water), gravity_m_s2(scenario.earth)
    spec.craft = craft(model, density_kg_m3, vehicle.trim or model.trim, squeeze, gravity)
    spec.actuators = actuators_spec(model, by_voltage=vehicle.battery is not None)
    if vehicle.battery is not None:
        spec.battery = battery_spec(vehicle.battery)
    if model.collision_pieces is not None:
        from uwsim.scenario.build.collision_pieces import (
            vehicle_pieces,
        )  # it needs scipy.sparse, which is slow to import

        spec.set_collision_pieces(vehicle_pieces(model))
    else:
        spec.shape = COLLISION_SHAPES[model.collision]
    spec.friction = model.friction
    spec.restitution = model.restitution
    position_m, yaw_rad = start_pose(scenario, vehicle)
    spec.set_start(position_m, about_z(yaw_rad))
    spec.docked = vehicle.start is None
    spec.windage = windage(model, density_kg_m3)
    spec.wrenches = [applied_wrench(wrench, scenario.step_s) for wrench in vehicle.wrenches]
    for name, sensor in model.sensors.items():
        if measures_temperature(sensor):
            require_temperature(scenario.water, f"sensor '{name}'", at=("sensors", name))
    spec.sensors = [sensor_spec(name, sensor, scenario.earth) for name, sensor in model.sensors.items()]
    if model.arm is not None or vehicle.droppers:
        spec.arm = link_specs(model.arm or {}) + held_links(scenario, vehicle)
    if model.sonar is not None:
        spec.sonars = [_sonar(scenario, vehicle, model.sonar.position_m)]
    return spec


def vehicle_control(scenario: Scenario, model: VehicleModel, spec: _core.VehicleSpec) -> ControlSettings:
    """Return the control settings of a vehicle whose spec is built. Raises ScenarioError."""
    return built_settings(
        model, spec.craft, spec.actuators, surface_density_kg_m3(scenario.water), gravity_m_s2(scenario.earth)
    )


@contextmanager
def vehicle_errors_at(scenario: Scenario, index: int) -> Iterator[None]:
    """Prefix errors raised while building a vehicle with file and line in both the scenario and the vehicle file."""
    file, model_file = scenario.source_file, scenario.vehicles[index].model.source_file
    keys = ("vehicles", index)
    try:
        yield
    except ScenarioError as error:
        part = model_file.line_prefix(*error.at) if error.at else model_file.file_prefix
        raise ScenarioError(f"{file.line_prefix(*keys)}{file.place(*keys)}.model: {part}{error}") from None
    except ValueError as error:
        raise ScenarioError(f"{file.line_prefix(*keys)}{file.place(*keys)}: {error}") from None


def authority(craft: _core.Craft, full_wrench_body: tuple[Floats, Floats]) -> Floats:
    """Return the acceleration from rest at full effort on each axis alone, deep in still water, (6,) [m/s2, rad/s2].

    full_wrench_body: ahead and astern wrenches, (6,) each; the smaller magnitude is used.
    """
    deep = _core.BodyState((0.0, 0.0, -1e3), (0.0, 0.0, 0.0, 1.0), np.zeros(6))
    water = _core.Water()
    still = craft.acceleration_body(deep, np.zeros(6), water)
    full = np.min(full_wrench_body, axis=0)
    gains = [craft.acceleration_body(deep, full * axis, water)[k] - still[k] for k, axis in enumerate(np.eye(6))]
    return np.abs(np.array(gains, np.float64))


def _sonar(scenario: Scenario, vehicle: VehicleEntry, mount_m: tuple[float, float, float]) -> _core.SonarSpec:
    sonar, model = vehicle.sonar, vehicle.sonar.loaded
    acoustics, bottoms = None, backscatter_by_label(scenario)
    if sonar.mode == "physics":
        acoustics = acoustic_spec(
            model,
            sonar.frequency_hz,
            bending=sonar.bending,
            rays_per_beam=sonar.rays_per_beam,
            bottoms=bottoms,
            volume_strength_db=scenario.water.volume_strength_db,
            water_targets=scenario.water_targets,
        )
    return _core.SonarSpec(
        "sonar",
        multibeam_model(model, sonar.frequency_hz, gain_db=sonar.gain_db),
        np.add(mount_m, model.mounting.position_m),
        model.mounting.orientation_xyzw,
        elevation_rad=-np.radians(sonar.tilt_deg),
        acoustics=acoustics,
        strengths_db=[bottom.strength_db for bottom in bottoms],
        on=sonar.on,
    )
