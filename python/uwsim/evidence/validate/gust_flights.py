"""Flights of the BlueROV2 Heavy in a gusty current: station keeping, and a path at speed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, at_most
from uwsim.evidence.validate.flights import deep_water
from uwsim.evidence.validate.step_responses import PERIOD_S
from uwsim.navigation.control import Controller, EstimateLike, PathFollower
from uwsim.scenario import Scenario, VehicleModel
from uwsim.simulator.simulator import Simulator

MEAN_M_S, RMS_M_S, CORRELATION_S = 0.5, 0.2, 10.0  # mean eastward, horizontal gusts; assumed
SETTLE_S, HOLD_S = 20.0, 120.0
START_M, BED_DEPTH_M = (0.0, 0.0, -20.0), 25.0  # the bed is within the DVL's range
SPEED_M_S, LEG_M = 1.0, 56.0
LOOKAHEAD_M, CORNER_M = 1.5, 6.0  # the first CORNER_M after each corner are excluded
ALIGN_S = 60.0  # station keeping before the path, while the filter estimates its biases
TOP_SPEED_AFTER_S = 20.0
LEGS = 3  # legs at 45 degrees to the mean current, to alternate sides
SEEDS = (1, 2, 3, 4, 5, 6)
NEAR_START_M = (20.0, 10.0, 0.0)
ABOVE_MIDDLE_M = (60.0, 20.0, 0.0)  # above the zigzag: the USBL's cross-range error grows with range
WAYS = {  # position of the station, and duration of station keeping before the path
    "from rest, station at the start": (NEAR_START_M, 0.0),
    "after a minute, station at the start": (NEAR_START_M, ALIGN_S),
    "from rest, station above the middle": (ABOVE_MIDDLE_M, 0.0),
}


def gusty_water(model: VehicleModel, seed: int, station_m: Sequence[float] = NEAR_START_M) -> Simulator:
    """Return a simulator with a free vehicle near a flat bed, in a gusty eastward current.

    station_m: (3,), position of the station, which carries the USBL transceiver.
    """
    each_m_s = RMS_M_S / math.sqrt(2.0)
    gusts = {"kind": "gusts", "mean_m_s": (MEAN_M_S, 0.0, 0.0), "sigma_m_s": (each_m_s, each_m_s, each_m_s / 4),
             "correlation_time_s": CORRELATION_S}  # fmt: skip
    return Simulator(Scenario.model_validate({
        "name": "gusts", "seed": seed, "water": {"density_kg_m3": 1000.0, "current": gusts},
        "terrain": {"source": "noise", "size_m": [400, 400], "spacing_m": 50, "bed_depth_m": BED_DEPTH_M},
        "station": {"position_m": list(station_m)},
        "vehicles": [{"name": "rov", "model": model, "start": {"position_m": list(START_M)}}],
    }))  # fmt: skip


def station_keeping(sim: Simulator, estimate: EstimateLike, for_s: float = SETTLE_S + HOLD_S) -> Floats:
    """Keep station, facing along the mean current; return the true errors (n,) [m] in position after SETTLE_S."""
    controller = Controller(sim.rov, PERIOD_S, estimate=estimate)
    away = []
    for _ in range(round(for_s / PERIOD_S)):
        controller.hold(START_M, 0.0)
        sim.advance(PERIOD_S)
        away.append(float(np.linalg.norm(sim.rov.pose.position_world_m - START_M)))
    return np.array(away[round(SETTLE_S / PERIOD_S) :])


def path_at_speed(sim: Simulator, estimate: EstimateLike) -> tuple[Floats, Floats]:
    """Fly a zigzag at 1 m/s over ground; return the true cross-track error [m] and speed along the path [m/s], (n,).

    Sections within CORNER_M after a corner are excluded.
    """
    corners = _corners()
    controller = Controller(sim.rov, PERIOD_S, estimate=estimate)
    follower = PathFollower(controller, corners, SPEED_M_S, lookahead_m=LOOKAHEAD_M)
    across, speeds = [], []
    for _ in range(round(2 * LEGS * LEG_M / SPEED_M_S / PERIOD_S)):
        guidance = follower.steer()
        sim.advance(PERIOD_S)
        if guidance.is_done:
            break
        leg, along_m = divmod(max(guidance.along_m, 0.0), LEG_M)
        if along_m < CORNER_M:
            continue
        start, end = corners[int(leg)], corners[int(leg) + 1]
        ahead = (end - start)[:2] / LEG_M
        x, y = (sim.rov.pose.position_world_m - start)[:2]
        across.append(ahead[0] * y - ahead[1] * x)
        velocity = sim.rov.pose.world_from_body[:2, :3] @ sim.rov.velocity.linear_body_m_s
        speeds.append(float(ahead @ velocity))
    return np.array(across), np.array(speeds)


def _corners() -> Floats:
    """Return the corners of the zigzag, (LEGS + 1, 3)."""
    step_m = LEG_M / math.sqrt(2.0)
    return np.array([(k * step_m, (k % 2) * step_m, START_M[2]) for k in range(LEGS + 1)])


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def top_speed_m_s(model: VehicleModel) -> float:
    """Return the vehicle's forward speed through still water at full thrust."""
    sim = deep_water(model)
    controller = Controller(sim.rov, PERIOD_S)
    for _ in range(round(TOP_SPEED_AFTER_S / PERIOD_S)):
        controller.steer(0.0, (2.0, 0.0))
        sim.advance(PERIOD_S)
    return float(sim.rov.velocity.linear_body_m_s[0])


def gust_checks(name: str, model: VehicleModel, seeds: Sequence[int] = SEEDS) -> list[Check]:
    """Fly all variants with each seed and compare the worst flight of each with the limits."""
    flights = [_GustFlights(model, seed) for seed in seeds]
    group = f"{len(seeds)} flights in gusts"
    own = f"{group}, by its own estimate"
    slowness = SPEED_M_S / min(f.speed_m_s for f in flights)
    kept_m = max(f.kept_m for f in flights)
    across = (
        at_most(name, f"{own}, {way}: cross-track, rms of the worst", 0.2, max(f.across_m[way] for f in flights), "m")
        for way in WAYS
    )
    return [
        at_most(name, f"{own}: station keeping, rms of the worst", 0.15, kept_m, "m"),
        *across,
        at_most(name, f"{own}: 1 m/s over the slowest flight's mean speed", 1.05, slowness),
    ]


class _GustFlights:
    """The results of one seed's flights.

    kept_m, across_m: RMS distance from the target and from each path. speed_m_s: slowest mean.
    """

    def __init__(self, model: VehicleModel, seed: int) -> None:
        kept = gusty_water(model, seed)
        self.kept_m = rms(station_keeping(kept, kept.rov.estimate))
        self.across_m: dict[str, float] = {}
        self.speed_m_s = math.inf
        for way, (station_m, align_s) in WAYS.items():
            sim = gusty_water(model, seed, station_m)
            if align_s > 0.0:
                station_keeping(sim, sim.rov.estimate, for_s=align_s)
            across, speeds = path_at_speed(sim, sim.rov.estimate)
            self.across_m[way] = rms(across)
            self.speed_m_s = min(self.speed_m_s, float(speeds.mean()))
