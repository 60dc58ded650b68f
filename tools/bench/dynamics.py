"""Steps per second of a vehicle with all its forces, compared with Bullet's bare step and pybullet with NumPy forces.

All cases alternate within one run, so that other load on the machine affects them equally; medians over the rounds are
reported. Each case runs on one thread and is measured by that thread's processor time.
"""

from __future__ import annotations

import functools
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import PlotFile, alternated, console, goal_cells, medians, native_program, new_table, ratio
from rich.table import Table

from uwsim import Simulator
from uwsim.scenario import VehicleEntry, load
from uwsim.scenario.spec.scenario import Dynamics
from uwsim.scenario.spec.water import JonswapSurface

VEHICLE = "bluerov2_heavy"
STEP_S = 0.005
MIDDLE_M = (20.0, -5.0)  # over the lake
COUNTS = (1, 2, 4, 8, 16, 32, 64)
SEA = {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.0}  # 64 waves
# Ratio to Bullet's bare step, ratio to pybullet, real-time factors, steps/s while crossing and floating at the surface,
# in calm water and in waves, and below the waves.
GOALS = {
    "against_bare_bullet": 0.35,
    "against_pybullet": 6.0,
    "real_time_factor": 2000.0,
    "resting_real_time_factor": 1000.0,
    "surface": 20_000.0,
    "floating": 150_000.0,
    "floating_in_waves": 50_000.0,
    "under_waves": 300_000.0,
}


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured. Medians are reported.")] = 15,
    plot: PlotFile = None,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    cases: dict[str, Callable[[], float]] = {
        "open_water": Flight(depth_m=10.0, steps=500, repeats=20),
        "above_bottom": Flight(above_bed_m=0.5, steps=500, repeats=10),
        "surface": Flight(depth_m=0.0, steps=20, repeats=20),
        "resting": Settled(above_bed_m=0.3, heave=-0.6),
        "floating": Settled(heave=0.1),
        "floating_in_waves": Settled(heave=0.1, steps=200, waves=True),
        "bullet_open_water": Flight(depth_m=10.0, steps=500, repeats=10, engine="bullet"),
        "bullet_resting": Settled(above_bed_m=0.3, heave=-0.6, engine="bullet"),
        "under_waves": Flight(depth_m=3.0, steps=100, repeats=10, waves=True),
        **{f"vehicles_{count}": Flight(depth_m=10.0, steps=200, repeats=2, count=count) for count in COUNTS},
    }
    if bare := native_program("bullet_bare_step"):
        cases["bare_bullet"] = lambda: bare_bullet(bare)
    if (peer := pybullet_peer()) is not None:
        cases["pybullet"] = peer(on_bed=False)
        cases["pybullet_resting"] = peer(on_bed=True)
    else:
        console.print("without pybullet: not installed (pip install pybullet)")
    results = summarise(alternated(cases, rounds))
    console.print(_table(results))
    if plot is not None:
        _draw(results, plot)
    return results


def summarise(rates: dict[str, list[float]]) -> dict[str, float]:
    """Return the median steps per second of each case, and the medians of the per-round ratios."""
    results = medians(rates)
    results["real_time_factor"] = results["open_water"] * STEP_S
    results["resting_real_time_factor"] = results["resting"] * STEP_S
    results["waves_against_still"] = ratio(rates["floating_in_waves"], rates["floating"])
    most = COUNTS[-1]
    results["fleet_against_one"] = ratio(rates["vehicles_1"], rates[f"vehicles_{most}"]) / most
    if "bare_bullet" in rates:
        results["against_bare_bullet"] = ratio(rates["open_water"], rates["bare_bullet"])
        results["above_bottom_against_bare_bullet"] = ratio(rates["above_bottom"], rates["bare_bullet"])
        results["bullet_engine_against_bare_bullet"] = ratio(rates["bullet_open_water"], rates["bare_bullet"])
    if "pybullet" in rates:
        results["against_pybullet"] = ratio(rates["open_water"], rates["pybullet"])
        results["resting_against_pybullet"] = ratio(rates["resting"], rates["pybullet_resting"])
    return results


class Flight:
    """Vehicles that move over the lake; a call returns steps per second.

    Runs of `steps` steps are timed. The vehicles are returned to their initial state before each run, so that all runs
    are the same.
    """

    def __init__(
        self,
        *,
        steps: int,
        repeats: int,
        depth_m: float = 0.0,
        above_bed_m: float | None = None,
        count: int = 1,
        waves: bool = False,
        engine: str = "uwsim",
    ) -> None:
        self._steps, self._repeats = steps, repeats
        scenario = load("lake").model_copy(update={"dynamics": Dynamics.model_validate({"engine": engine})})
        if waves:
            sea = scenario.water.model_copy(update={"surface": JonswapSurface.model_validate(SEA)})
            scenario = scenario.model_copy(update={"water": sea})
        self._starts = [(MIDDLE_M[0] + 5.0 * (k % 8), MIDDLE_M[1] + 5.0 * (k // 8), -depth_m) for k in range(count)]
        vehicles = tuple(
            VehicleEntry.model_validate({"name": f"body{k}", "model": VEHICLE, "start": {"position_m": start}})
            for k, start in enumerate(self._starts)
        )
        self.simulator = self._sim = Simulator(scenario.model_copy(update={"vehicles": vehicles, "step_s": STEP_S}))
        if above_bed_m is not None:
            x, y, _ = self._starts[0]
            lowest = _lowest_m(vehicles[0])
            self._starts = [(x, y, float(self._sim.world.height_at([[x, y]])[0]) + above_bed_m - lowest)]
        for vehicle in self._sim.vehicles.values():
            vehicle.set_effort(surge=0.3, sway=0.05, heave=0.05, yaw=0.1)

    def __call__(self) -> float:
        """Return steps per second."""
        elapsed_s = 0.0
        for _ in range(self._repeats):
            for vehicle, start in zip(self._sim.vehicles.values(), self._starts, strict=True):
                vehicle.place(start)
            started_s = time.thread_time()
            self._sim.step(self._steps)
            elapsed_s += time.thread_time() - started_s
        return self._steps * self._repeats / elapsed_s


class Settled:
    """A vehicle that rests on the lake's bed or floats at its surface; a call returns steps per second.

    The vehicle settles once, before anything is timed.
    """

    def __init__(
        self,
        *,
        heave: float,
        above_bed_m: float | None = None,
        waves: bool = False,
        steps: int = 2000,
        engine: str = "uwsim",
    ) -> None:
        self._steps = steps
        flight = Flight(steps=1, repeats=1, above_bed_m=above_bed_m, waves=waves, engine=engine)
        flight()
        self._sim = flight.simulator
        self._sim.rov.set_effort(heave=heave)
        self._sim.step(4000)
        touches, height_m = self._sim.rov.telemetry().collision_warning, self._sim.rov.pose.position_world_m[2]
        if above_bed_m is not None and not touches:
            raise RuntimeError("the vehicle does not rest on the bed")
        if above_bed_m is None and not waves and abs(height_m) > 0.13:  # half its height
            raise RuntimeError(f"the vehicle does not float: it is at z = {height_m:.3f} m")

    def __call__(self) -> float:
        """Return steps per second."""
        started_s = time.thread_time()
        self._sim.step(self._steps)
        return self._steps / (time.thread_time() - started_s)


def _lowest_m(vehicle: VehicleEntry) -> float:
    from uwsim.scenario import vehicle_hull

    return float(vehicle_hull(vehicle.model)[0][:, 2].min())


def bare_bullet(program: Path) -> float:
    """Return steps per second of Bullet's stepSimulation with one free body, run in its own process."""
    steps = 100_000
    output = subprocess.run([program, str(steps)], check=True, capture_output=True, text=True).stdout
    return steps / float(output)


def pybullet_peer() -> Callable[..., PybulletPeer] | None:
    """Return a class that simulates the same body in pybullet, with drag and thrust by NumPy; None without pybullet."""
    try:
        import pybullet
    except ImportError:
        return None
    return functools.partial(PybulletPeer, pybullet)


class PybulletPeer:
    """A BlueROV2 Heavy in pybullet: no added mass; drag and thrust are computed in Python and applied at every step.

    With `on_bed`, it lies on a plane and is 20 N heavier than its buoyancy.
    """

    def __init__(self, pybullet: Any, *, on_bed: bool) -> None:
        from pybullet_utils import bullet_client

        self._p = p = bullet_client.BulletClient(connection_mode=pybullet.DIRECT)
        p.setGravity(0, 0, -9.80665)
        p.setTimeStep(STEP_S)
        self._start = [0.0, 0.0, 0.127 if on_bed else -10.0]
        if on_bed:
            p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
        box = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.2285, 0.2875, 0.127])
        self._body = p.createMultiBody(13.5, box, basePosition=self._start)
        self._linear = np.array([13.7, 0.0, 33.0, 0.0, 0.8, 0.0])
        self._quadratic = np.array([141.0, 217.0, 190.0, 1.192, 0.470, 1.5])
        self._wrench_from_thrusters = np.random.default_rng(0).normal(size=(6, 8))
        self._thrusts = np.full(8, 0.0 if on_bed else 2.0)
        self._lift = np.array([0.0, 0.0, 13.5 * 9.80665 - 20.0 if on_bed else 0.0134 * 1000 * 9.80665])

    def _step(self) -> None:
        p, body = self._p, self._body
        position, orientation = p.getBasePositionAndOrientation(body)
        linear, angular = p.getBaseVelocity(body)
        rotation = np.array(p.getMatrixFromQuaternion(orientation)).reshape(3, 3)
        nu = np.concatenate([rotation.T @ linear, rotation.T @ angular])
        wrench = self._wrench_from_thrusters @ self._thrusts - self._linear * nu - self._quadratic * np.abs(nu) * nu
        force = rotation @ wrench[:3] + self._lift
        torque = rotation @ (wrench[3:] + np.cross([0.0, 0.0, 0.01], rotation.T @ self._lift))
        p.applyExternalForce(body, -1, force.tolist(), position, p.WORLD_FRAME)
        p.applyExternalTorque(body, -1, torque.tolist(), p.WORLD_FRAME)
        p.stepSimulation()

    def __call__(self) -> float:
        """Return steps per second."""
        steps = 1000
        self._p.resetBasePositionAndOrientation(self._body, self._start, [0, 0, 0, 1])
        self._p.resetBaseVelocity(self._body, [0, 0, 0], [0, 0, 0])
        started_s = time.thread_time()
        for _ in range(steps):
            self._step()
        return steps / (time.thread_time() - started_s)


def _table(results: dict[str, float]) -> Table:
    rows = [
        ("open water", "open_water", None),
        ("0.5 m above the bottom", "above_bottom", None),
        ("crossing the surface", "surface", GOALS["surface"]),
        ("resting on the bed", "resting", None),
        ("open water, dynamics.engine: bullet", "bullet_open_water", None),
        ("resting on the bed, dynamics.engine: bullet", "bullet_resting", None),
        ("floating at the surface", "floating", GOALS["floating"]),
        ("floating in waves of 0.5 m", "floating_in_waves", GOALS["floating_in_waves"]),
        ("3 m under them", "under_waves", GOALS["under_waves"]),
        ("Bullet's bare step", "bare_bullet", None),
        ("pybullet and NumPy", "pybullet", None),
        ("pybullet and NumPy, resting on a plane", "pybullet_resting", None),
    ]
    title = f"{VEHICLE} over the lake, step {1e3 * STEP_S:g} ms, one core: medians"
    table = new_table(title, "case", "steps/s", "us per step", "goal", "met")
    for label, key, goal in rows:
        if key in results:
            rate = results[key]
            table.add_row(label, f"{rate:,.0f}", f"{1e6 / rate:.3f}", *goal_cells(rate, goal))
    table.add_section()
    for label, key in (
        ("open water / Bullet's bare step", "against_bare_bullet"),
        ("0.5 m above the bottom / Bullet's bare step", "above_bottom_against_bare_bullet"),
        ("dynamics.engine: bullet / Bullet's bare step", "bullet_engine_against_bare_bullet"),
        ("floating in waves / floating", "waves_against_still"),
        (f"one of {COUNTS[-1]} vehicles / one alone, cost", "fleet_against_one"),
        ("open water / pybullet and NumPy", "against_pybullet"),
        ("resting / pybullet and NumPy", "resting_against_pybullet"),
        ("real-time factor", "real_time_factor"),
        ("real-time factor, resting", "resting_real_time_factor"),
    ):
        if key in results:
            table.add_row(label, f"{results[key]:,.2f}", "", *goal_cells(results[key], GOALS.get(key)))
    table.add_section()
    for count in COUNTS:
        rate = results[f"vehicles_{count}"]
        table.add_row(f"{count} vehicles", f"{rate:,.0f}", f"{1e6 / rate:.2f}", "", "")
    return table


def _draw(results: dict[str, float], path: Path) -> None:
    import matplotlib.pyplot as plt

    counts = np.array(COUNTS)
    cost_us = np.array([1e6 / results[f"vehicles_{count}"] for count in COUNTS])
    figure, panel = plt.subplots(figsize=(6, 4), layout="constrained")
    panel.plot(counts, cost_us, "o-", label="measured")
    panel.plot(counts, counts * cost_us[-1] / counts[-1], "--", alpha=0.6, label="linear")
    panel.set(xlabel="vehicles", ylabel="time of a step [us]", title=f"{VEHICLE}: cost against the number of vehicles")
    panel.grid(alpha=0.3)
    panel.legend()
    figure.savefig(path, dpi=120)
    plt.close(figure)
