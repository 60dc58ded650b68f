"""Control settings from a vehicle's file: motion model, gains and limits."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from uwsim import _core
from uwsim.base.axes import AXES
from uwsim.scenario.build.actuator import actuators_spec
from uwsim.scenario.build.craft import craft
from uwsim.scenario.build.gravity import STANDARD_M_S2
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.control import Loop
from uwsim.scenario.spec.vehicle import VehicleModel, load_vehicle


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
