"""A learned policy flown as a mission: it holds a position in gusts and is compared with the vehicle's PID."""

import numpy as np

import uwsim
from uwsim.learning.motion import Motion
from uwsim.learning.policy import LinearPolicy
from uwsim.learning.task import observed
from uwsim.learning.tasks import StationKeeping
from uwsim.learning.tasks.station_keeping import way_to
from uwsim.missions import OwnVehicle, Steps, wait
from uwsim.navigation.control import Controller
from uwsim.scenario.read.assets import assets_folder

PLACE_M = StationKeeping.place_m
FOR_S = 40.0


def mission(vehicle: OwnVehicle) -> Steps[None]:
    """Hold the position with the packaged policy."""
    policy, effort = LinearPolicy.load("station_keeping"), np.zeros(6)
    for _ in range(round(FOR_S / StationKeeping.period_s)):
        now = Motion.of_one(vehicle)
        effort = policy(observed(StationKeeping.fields(), way_to(PLACE_M, now), now, effort[None])[0])
        vehicle.set_effort(*effort)
        yield from wait(StationKeeping.period_s)


def by_pid(vehicle: OwnVehicle) -> Steps[None]:
    """Hold the position with the control loops in the vehicle's file."""
    controller = Controller(vehicle)
    for _ in range(round(FOR_S / controller.period_s)):
        controller.hold(PLACE_M, 0.0)
        yield from wait(controller.period_s)


def main() -> None:
    """Fly both in the same gusts, starting 1.5 m from the position."""
    scenario = assets_folder() / "learning" / "open_water.yaml"
    for name, fly_it in (("learned", mission), ("PID", by_pid)):
        sim = uwsim.Simulator(scenario, seed=12)
        sim.parameters["water.current_world_m_s"] = [0.25, -0.2, 0.0]
        sim.rov.place(PLACE_M + np.array([1.0, -1.0, 0.5]))
        samples = uwsim.fly(fly_it, sim).samples["rov"]
        off_m = np.linalg.norm(samples.path_world_m - PLACE_M, axis=1)
        late_m = off_m[samples["time_s"] > FOR_S / 2]
        there_s = samples["time_s"][np.argmax(off_m < 0.1)]
        print(f"{name}: within 0.1 m after {there_s:.1f} s, then {np.sqrt((late_m**2).mean()):.3f} m rms")


if __name__ == "__main__":
    main()
