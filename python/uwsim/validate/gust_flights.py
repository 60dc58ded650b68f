"""Flights of the BlueROV2 Heavy in a gusting current: station keeping, and a path at speed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uwsim.control import Controller, EstimateLike, PathFollower
from uwsim.scenario import Scenario, VehicleModel
from uwsim.simulator import Simulator
from uwsim.validate.check import Check, at_most
from uwsim.validate.step_responses import PERIOD_S

Array = NDArray[np.float64]
Estimate = Callable[[Simulator], EstimateLike]
MEAN_M_S, RMS_M_S, CORRELATION_S = 0.5, 0.2, 10.0  # the correlation time is assumed
SETTLE_S, HOLD_S = 20.0, 120.0
START_M, BED_DEPTH_M = (0.0, 0.0, -20.0), 25.0  # within the DVL's range of the bed
SIDE_M, SPEED_M_S = 40.0, 1.0


def gusty_water(model: VehicleModel, seed: int = 1) -> Simulator:
    """Return a simulator with one free vehicle near a flat bed, in a current of 0.5 m/s eastward with 0.2 m/s of gusts.

    The gusts' rms is along each horizontal axis; the vertical has a quarter of it.
    """
    gusts = {
        "kind": "gusts",
        "mean_m_s": (MEAN_M_S, 0.0, 0.0),
        "sigma_m_s": (RMS_M_S, RMS_M_S, RMS_M_S / 4),
        "correlation_time_s": CORRELATION_S,
    }
    return Simulator(
        Scenario.model_validate(
            {
                "name": "gusts",
                "seed": seed,
                "water": {"current": gusts},
                "terrain": {"source": "noise", "size_m": [400, 400], "spacing_m": 50, "bed_depth_m": BED_DEPTH_M},
                "station": {"position_m": [-150, -150, 0]},
                "vehicles": [{"name": "rov", "model": model, "start": {"position_m": list(START_M)}}],
            }
        )
    )


def station_keeping(sim: Simulator, estimate: EstimateLike) -> Array:
    """Keep a place for two minutes; return the true position's distance from it at each period, (n,) [m]."""
    controller = Controller(sim.rov, PERIOD_S, estimate=estimate)
    away = []
    for _ in range(round((SETTLE_S + HOLD_S) / PERIOD_S)):
        controller.hold(START_M, 0.5)
        sim.advance(PERIOD_S)
        away.append(float(np.linalg.norm(sim.rov.pose.position_world_m - START_M)))
    return np.array(away[round(SETTLE_S / PERIOD_S) :])


def square(sim: Simulator, estimate: EstimateLike) -> tuple[Array, Array]:
    """Fly a square at 1 m/s; return the true cross-track error and the true speed along the path, (n,) each.

    Without what is within two look-aheads of a corner.
    """
    corners = [(0, 0), (SIDE_M, 0), (SIDE_M, SIDE_M), (0, SIDE_M), (0, 0)]
    points = np.array([(x, y, START_M[2]) for x, y in corners])
    controller = Controller(sim.rov, PERIOD_S, estimate=estimate)
    follower = PathFollower(controller, points, SPEED_M_S)
    across, speeds = [], []
    for _ in range(round(20 * SIDE_M / SPEED_M_S / PERIOD_S)):
        guidance = follower.steer()
        sim.advance(PERIOD_S)
        if guidance.is_done:
            break
        side, along_m = divmod(max(guidance.along_m, 0.0), SIDE_M)
        if not follower.lookahead_m * 2 < along_m < SIDE_M:
            continue
        start, end = points[int(side)], points[int(side) + 1]
        ahead = (end - start)[:2] / SIDE_M
        x, y = (sim.rov.pose.position_world_m - start)[:2]
        across.append(ahead[0] * y - ahead[1] * x)
        velocity = sim.rov.pose.world_from_body[:2, :3] @ sim.rov.velocity.linear_body_m_s
        speeds.append(float(ahead @ velocity))
    return np.array(across), np.array(speeds)


def rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def gust_checks(name: str, model: VehicleModel, estimate: Estimate) -> list[Check]:
    """Compare both flights with their limits."""
    kept, flown = gusty_water(model), gusty_water(model)
    away_m = rms(station_keeping(kept, estimate(kept)))
    across_m, _ = square(flown, estimate(flown))
    return [
        at_most(name, "gusts of 0.5 + 0.2 m/s rms: station keeping, rms", 0.15, away_m, "m"),
        at_most(name, "gusts of 0.5 + 0.2 m/s rms: cross-track, rms", 0.2, rms(across_m), "m"),
    ]
