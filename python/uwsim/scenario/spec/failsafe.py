"""A vehicle's reaction to loss of contact or an onboard failure."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.scenario.spec.fields import InRange, Model, broken

Behaviour = Literal["hold", "surface", "return", "go_on"]
"""hold: keep depth, heading and position. surface: ascend. return: fly to the place of release. go_on: only report."""
Percent = Annotated[float, InRange(0, 100, "%")]


class Failsafe(Model):
    """The reaction of a released vehicle, in simulated time and by its own controller.

    silence_s: time without a command, or in a scenario with a link without any message from the station, after which it
    does `then`; none: never. The next message ends the reaction. then: the reaction to such silence. battery_percent,
    battery_then: the charge below which it reacts, and how; 0: never. leak_then, thruster_then, sensor_then: the
    reaction when it detects water inside, a thruster that does not respond, a sensor that is silent or stuck; none: not
    monitored. These reactions last until they are overridden; meanwhile commands have no effect. ascent_m_s: rate of
    ascent in `surface` and `return`. surface_m: the depth at which the ascent stops. speed_m_s: speed of the return.
    return_depth_m: depth of the return; none: the depth at release. height_m: minimum height above the bed during
    `return`.
    """

    silence_s: Annotated[float, InRange(0.1, 1e6, "s")] | None = None
    then: Behaviour = "hold"
    battery_percent: Percent = 0.0
    battery_then: Behaviour = "return"
    leak_then: Behaviour | None = None
    thruster_then: Behaviour | None = None
    sensor_then: Behaviour | None = None
    ascent_m_s: Annotated[float, InRange(0.01, 5, "m/s")] = 0.3
    surface_m: Annotated[float, InRange(0, 100, "m")] = 0.5
    speed_m_s: Annotated[float, InRange(0.05, 5, "m/s")] = 0.5
    return_depth_m: Annotated[float, InRange(0, 10_000, "m")] | None = None
    height_m: Annotated[float, InRange(0, 1000, "m")] = 3.0

    @model_validator(mode="after")
    def _watches_something(self) -> Failsafe:
        watched = (self.silence_s, self.leak_then, self.thruster_then, self.sensor_then)
        if self.battery_percent == 0 and all(value is None for value in watched):
            raise broken("monitors nothing: give silence_s, battery_percent, leak_then, thruster_then or sensor_then")
        return self
