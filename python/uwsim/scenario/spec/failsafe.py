"""What a vehicle does by itself when nobody speaks to it, or something aboard fails."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.scenario.spec.fields import InRange, Model, broken

Behaviour = Literal["hold", "surface", "return", "go_on"]
"""hold: depth, heading and place. surface: ascend. return: fly back to where it was released. go_on: only tell."""
Percent = Annotated[float, InRange(0, 100, "%")]


class Failsafe(Model):
    """What a released vehicle does, in simulated time and by its own controller.

    silence_s: without a command, or in a scenario with a link without anything from the station through that, after
    which it does `then`; none: never. The next word ends it. then: what it does after such silence.
    battery_percent, battery_then: the charge below which it does that; 0: never. leak_then, thruster_then, sensor_then:
    what it does when it notices water inside, a thruster that does not obey, a sensor that is silent or stuck; none: it
    is not watched. These stay until they are overridden; meanwhile commands have no effect.
    ascent_m_s: the rate of `surface` and of the climb of `return`. surface_m: the depth at which it stops. speed_m_s:
    of the way back. return_depth_m: its depth; none: that of where it was released. height_m: above the bed, which
    `return` keeps at least.
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
            raise broken("watches nothing: give silence_s, battery_percent, leak_then, thruster_then or sensor_then")
        return self
