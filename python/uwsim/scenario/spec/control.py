"""Gains and limits of a vehicle's control loops, for uwsim.navigation.control.Controller."""

from __future__ import annotations

from typing import Annotated

from uwsim.scenario.spec.fields import InRange, Model

Rate = Annotated[float, InRange(0, 100, "1/s")]
Seconds = Annotated[float, InRange(0.001, 100, "s")]


class Loop(Model):
    """The cascaded loops of one axis; position errors are in m or rad.

    position_1_s: reference velocity per unit of position error. velocity_1_s: acceleration per unit of velocity error.
    integral_1_s2: acceleration per unit of the velocity error's integral. acceleration_share: fraction of the measured
    acceleration that is opposed, like added inertia.
    """

    position_1_s: Rate = 1.0
    velocity_1_s: Rate = 3.0
    integral_1_s2: Annotated[float, InRange(0, 1000, "1/s2")] = 1.5
    acceleration_share: Annotated[float, InRange(0, 10)] = 0.0


class TurningLoop(Loop):
    """The cascaded loops of roll, pitch or yaw."""

    position_1_s: Rate = 2.0
    velocity_1_s: Rate = 4.0
    integral_1_s2: Annotated[float, InRange(0, 1000, "1/s2")] = 4.0


class Control(Model):
    """Gains and limits of all loops. An axis without actuators has none.

    surge, sway, heave, roll, pitch, yaw: gains of each axis. filter_s: time constant of the filter of measured
    acceleration. tracking_s: time constant with which a saturated integral follows the actual thrust. speed_min_m_s:
    the speed below which fins do not turn the vehicle; surveys fly no slower. speed_max_m_s, climb_max_m_s,
    turn_max_rad_s: limits on the reference velocities towards a position (horizontal, vertical) and an attitude.
    acceleration_max_m_s2, turn_acceleration_max_rad_s2: limits on the rate of change of the reference velocities.
    """

    surge: Loop = Loop.model_construct()
    sway: Loop = Loop.model_construct()
    heave: Loop = Loop.model_construct()
    roll: TurningLoop = TurningLoop.model_construct()
    pitch: TurningLoop = TurningLoop.model_construct()
    yaw: TurningLoop = TurningLoop.model_construct()
    filter_s: Seconds = 0.2
    tracking_s: Seconds = 1.0
    speed_min_m_s: Annotated[float, InRange(0, 20, "m/s")] = 0.0
    speed_max_m_s: Annotated[float, InRange(0.01, 20, "m/s")] = 1.0
    climb_max_m_s: Annotated[float, InRange(0.01, 20, "m/s")] = 0.4
    turn_max_rad_s: Annotated[float, InRange(0.01, 10, "rad/s")] = 0.5
    acceleration_max_m_s2: Annotated[float, InRange(0.01, 20, "m/s2")] = 0.5
    turn_acceleration_max_rad_s2: Annotated[float, InRange(0.01, 20, "rad/s2")] = 1.0
