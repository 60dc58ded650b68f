"""Measures the step responses of a vehicle's control loops in deep, still water."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.evidence.validate.check import Curve
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.navigation.control import Controller
from uwsim.scenario import VehicleModel
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

PERIOD_S, DURATION_S, STEADY_S, SETTLE_S = 0.05, 30.0, 5.0, 20.0
CRUISE_M_S = 1.5  # about 3 knots, at which such AUVs cruise
SETTLED = 0.05  # share of the step


@dataclass(frozen=True)
class Step:
    """A step in one quantity. needs: the axis that must have actuators. command, read: set and read the quantity.

    under_way_m_s: forward speed at which the step begins, after SETTLE_S at that speed; 0 to begin from rest.
    """

    name: str
    unit: str
    size: float
    needs: str
    command: Callable[[Controller, float], None]
    read: Callable[[Vehicle], float]
    under_way_m_s: float = 0.0


def _at(x_m: float = 0.0, y_m: float = 0.0, z_m: float = 0.0) -> Floats:
    return np.add(START_M, (x_m, y_m, z_m), dtype=np.float64)


def _tilt(rov: Vehicle, row: int) -> float:
    return math.asin(float(np.clip(rov.pose.world_from_body[2, row], -1.0, 1.0)))


def _velocity(axis: int) -> Callable[[Controller, float], None]:
    return lambda c, s: c.velocity(tuple(s * np.eye(6)[axis]))


def _depth(rov: Vehicle) -> float:
    return float(rov.pose.position_world_m[2] - START_M[2])


STEPS = (
    Step("ahead", "m", 2.0, "surge", lambda c, s: c.hold(_at(x_m=s), 0.0), lambda r: r.pose.position_world_m[0]),
    Step("sideways", "m", 2.0, "sway", lambda c, s: c.hold(_at(y_m=s), 0.0), lambda r: r.pose.position_world_m[1]),
    Step("depth", "m", 1.0, "heave", lambda c, s: c.hold(_at(z_m=s), 0.0), _depth),
    Step("heading", "rad", math.pi / 2, "yaw", lambda c, s: c.hold(START_M, s), lambda r: r.pose.yaw_rad),
    Step("roll", "rad", 0.1, "roll", lambda c, s: c.hold(START_M, 0.0, roll_rad=s), lambda r: _tilt(r, 1)),
    Step("pitch", "rad", 0.1, "pitch", lambda c, s: c.hold(START_M, 0.0, pitch_rad=s), lambda r: -_tilt(r, 0)),
    Step("surge", "m/s", 0.5, "surge", _velocity(0), lambda r: r.velocity.linear_body_m_s[0]),
    Step("sway", "m/s", 0.3, "sway", _velocity(1), lambda r: r.velocity.linear_body_m_s[1]),
    Step("yaw rate", "rad/s", 0.3, "yaw", _velocity(5), lambda r: r.velocity.angular_body_rad_s[2]),
)


def _ahead(c: Controller, heading_rad: float = 0.0, z_m: float | None = None, pitch_rad: float = 0.0) -> None:
    """Continue at cruising speed."""
    velocity_m_s = (CRUISE_M_S * math.cos(heading_rad), CRUISE_M_S * math.sin(heading_rad))
    c.steer(heading_rad, velocity_m_s, z_m, pitch_rad=pitch_rad)


STEPS_UNDER_WAY = (
    Step("depth under way", "m", 2.0, "pitch", lambda c, s: _ahead(c, z_m=START_M[2] + s), _depth, CRUISE_M_S),
    Step("heading under way", "rad", 0.5, "yaw", lambda c, s: _ahead(c, s, START_M[2]), lambda r: r.pose.yaw_rad,
         CRUISE_M_S),
    Step("pitch under way", "rad", 0.1, "pitch", lambda c, s: _ahead(c, pitch_rad=s), lambda r: -_tilt(r, 0),
         CRUISE_M_S),
    Step("surge under way", "m/s", 0.3, "surge", lambda c, s: c.steer(0.0, (CRUISE_M_S + s, 0.0), START_M[2]),
         lambda r: r.velocity.linear_body_m_s[0] - CRUISE_M_S, CRUISE_M_S),
)  # fmt: skip
"""Steps for vehicles without vertical thrust: they climb by pitching, and fins turn them only under way."""


@dataclass(frozen=True, eq=False)
class StepResponse:
    """The response to a step: values (n,), as shares of the step, at times_s (n,)."""

    vehicle: str
    step: Step
    times_s: Floats
    values: Floats

    @property
    def rise_s(self) -> float:
        """Time from 10 to 90 % of the step; inf if either is not reached."""
        return self._first(0.9) - self._first(0.1)

    @property
    def overshoot(self) -> float:
        """Largest overshoot beyond the step, as a share of the step."""
        return max(0.0, float(self.values.max()) - 1.0)

    @property
    def settling_s(self) -> float:
        """Time after which the value stays within 5 % of the step; inf if it never does."""
        out = np.flatnonzero(~(np.abs(self.values - 1.0) <= SETTLED))
        if len(out) == 0:
            return 0.0
        return math.inf if out[-1] + 1 == len(self.values) else float(self.times_s[out[-1] + 1])

    @property
    def steady_error(self) -> float:
        """Largest error in the last seconds, as a share of the step."""
        return float(np.abs(self.values[self.times_s > self.times_s[-1] - STEADY_S] - 1.0).max())

    def curve(self, before: StepResponse | None = None) -> Curve:
        """Return the response as it is drawn. before: the response to the same step with other gains, if any."""
        size, found = self.step.size, {} if before is None else {"before": before.step.size * before.values}
        title = (
            f"{self.step.name}: rise {self.rise_s:.1f} s, overshoot {self.overshoot:.1%},\nsettling "
            f"{self.settling_s:.1f} s, steady error {self.steady_error:.2%}"
        )
        lines = {"step": np.full_like(self.values, size), **found, "response": size * self.values}
        return Curve(self.times_s, lines, up=self.step.unit, title=title)

    def _first(self, share: float) -> float:
        reached = np.flatnonzero(self.values >= share)
        return float(self.times_s[reached[0]]) if len(reached) else math.inf


def step_responses(name: str, model: VehicleModel) -> list[StepResponse]:
    """Return the responses to all steps that the actuators can drive, under way if there is no vertical thrust."""
    sim = deep_water(model)
    driven = dict(zip(AXES, sim.rov.control.model.driven, strict=True))
    return [_fly(name, sim, step) for step in (STEPS if driven["heave"] else STEPS_UNDER_WAY) if driven[step.needs]]


def _fly(name: str, sim: Simulator, step: Step) -> StepResponse:
    rov = sim.rov
    rov.set_effort()
    sim.advance(2.0)  # until the thrusters have stopped
    rov.place(START_M, velocity_body=step.under_way_m_s * np.eye(6)[0])
    controller = Controller(rov, PERIOD_S)
    for _ in range(round(SETTLE_S / PERIOD_S) if step.under_way_m_s else 0):
        step.command(controller, 0.0)
        sim.advance(PERIOD_S)
    values = []
    for _ in range(round(DURATION_S / PERIOD_S)):
        step.command(controller, step.size)
        sim.advance(PERIOD_S)
        values.append(step.read(rov) / step.size)
    times_s = np.asarray(PERIOD_S * np.arange(1, len(values) + 1), np.float64)
    return StepResponse(name, step, times_s, np.array(values, np.float64))
