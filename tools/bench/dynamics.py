"""Steps per second of a vehicle with all its forces, compared with Bullet's bare step.

Each case runs on one thread and is measured by that thread's processor time.
"""

from __future__ import annotations

import subprocess
import time
from typing import Any

from _harness import Case, Rounds, alternated, lake_fleet, medians, native_program, ratio, show, spent_s

from uwsim import Simulator
from uwsim.scenario import load, vehicle_hull
from uwsim.scenario.spec.settings import Dynamics
from uwsim.scenario.spec.water import JonswapSurface

VEHICLE, STEP_S = "bluerov2_heavy", 0.005
MIDDLE_M = (20.0, -5.0)  # over the lake
MANY = 64
SEA = {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.0}  # 64 waves
GOALS = {
    "against_bare_bullet": ">= 0.35",
    "real_time_factor": ">= 2000",
    "resting": ">= 200000",
    "surface": ">= 20000",
    "floating": ">= 150000",
    "floating_in_waves": ">= 50000",
    "under_waves": ">= 300000",
}


def main(rounds: Rounds = 15) -> dict[str, Any]:
    """Measure all cases alternately and print medians: steps per second, and ratios of rates."""
    cases: dict[str, Case] = {
        "open_water": Flight(500, 20, depth_m=10.0),
        "above_bottom": Flight(500, 10, above_bed_m=0.5),
        "surface": Flight(20, 20),
        "resting": Flight(2000, above_bed_m=0.3, settled=-0.6),
        "floating": Flight(2000, settled=0.1),
        "floating_in_waves": Flight(2000, settled=0.1, waves=True),
        "bullet_open_water": Flight(500, 10, depth_m=10.0, engine="bullet"),
        "bullet_resting": Flight(2000, above_bed_m=0.3, settled=-0.6, engine="bullet"),
        "under_waves": Flight(100, 10, depth_m=3.0, waves=True),
        "vehicles_1": Flight(200, 2, depth_m=10.0),
        f"vehicles_{MANY}": Flight(200, 2, depth_m=10.0, count=MANY),
    }
    if program := native_program("bullet_bare_step"):
        cases["bare_bullet"] = lambda: bare_bullet(program)
    rates = alternated(cases, rounds)
    results = medians(rates)
    results["real_time_factor"] = results["open_water"] * STEP_S
    results["waves_against_still"] = ratio(rates["floating_in_waves"], rates["floating"])
    results["fleet_against_one"] = ratio(rates["vehicles_1"], rates[f"vehicles_{MANY}"]) / MANY
    if "bare_bullet" in rates:
        results["against_bare_bullet"] = ratio(rates["open_water"], rates["bare_bullet"])
        results["above_bottom_against_bare_bullet"] = ratio(rates["above_bottom"], rates["bare_bullet"])
        results["bullet_engine_against_bare_bullet"] = ratio(rates["bullet_open_water"], rates["bare_bullet"])
    show(f"{VEHICLE} over the lake, step {1e3 * STEP_S:g} ms, one core: steps per second, and ratios", results, GOALS)
    return results


class Flight:
    """Vehicles over the lake; a call returns steps per second.

    Runs of `steps` steps are timed, each from the initial state, so that all are the same. settled: the effort in heave
    with which the vehicle comes to rest once, before anything is timed, on the bed or at the surface.
    """

    def __init__(
        self,
        steps: int,
        repeats: int = 1,
        *,
        depth_m: float = 0.0,
        above_bed_m: float | None = None,
        settled: float | None = None,
        count: int = 1,
        waves: bool = False,
        engine: str = "uwsim",
    ) -> None:
        self._steps, self._repeats, self._settled = steps, repeats, settled
        water = load("lake").water
        water = water.model_copy(update={"surface": JonswapSurface.model_validate(SEA)}) if waves else water
        self._starts = [(MIDDLE_M[0] + 5.0 * (k % 8), MIDDLE_M[1] + 5.0 * (k // 8), -depth_m) for k in range(count)]
        dynamics = Dynamics.model_validate({"engine": engine})
        scenario = lake_fleet(self._starts, VEHICLE, step_s=STEP_S, water=water, dynamics=dynamics)
        self._sim = sim = Simulator(scenario)
        if above_bed_m is not None:
            lowest_m = float(vehicle_hull(scenario.vehicles[0].model)[0][:, 2].min())
            self._starts = [(*MIDDLE_M, float(sim.world.height_at([MIDDLE_M])[0]) + above_bed_m - lowest_m)]
        self._place()
        for vehicle in sim.vehicles.values():
            vehicle.set_effort(surge=0.3, sway=0.05, heave=0.05, yaw=0.1)
        if settled is not None:
            sim.step()
            sim.rov.set_effort(heave=settled)
            sim.step(4000)
            height_m = sim.rov.pose.position_world_m[2]
            rests = sim.rov.telemetry().collision_warning if above_bed_m is not None else waves or abs(height_m) < 0.13
            if not rests:
                raise RuntimeError(f"the vehicle is not at rest on the bed or at the surface: z = {height_m:.3f} m")

    def _place(self) -> None:
        for vehicle, start in zip(self._sim.vehicles.values(), self._starts, strict=True):
            vehicle.place(start)

    def __call__(self) -> float:
        """Return steps per second."""
        elapsed_s = 0.0
        for _ in range(self._repeats):
            if self._settled is None:
                self._place()
            elapsed_s += spent_s(lambda: self._sim.step(self._steps), time.thread_time)
        return self._steps * self._repeats / elapsed_s


def bare_bullet(program: Any) -> float:
    """Return steps per second of Bullet's stepSimulation with one free body, run in its own process."""
    steps = 100_000
    output = subprocess.run([program, str(steps)], check=True, capture_output=True, text=True).stdout
    return steps / float(output)
