"""A mission of your own: circle a point while facing it. See docs/guides/missions.md for more."""

import numpy as np

import uwsim
from uwsim.missions import OwnVehicle, Steps, run, wait


def circle(vehicle: OwnVehicle, centre_m: np.ndarray, radius_m: float, z_m: float) -> Steps[None]:
    """Fly once around `centre_m` (2,) at 0.5 m/s, facing inwards, at height z_m."""
    period_s = vehicle.autopilot.period_s
    for angle in np.arange(0.0, 2 * np.pi, 0.5 * period_s / radius_m):
        out = np.array([np.cos(angle), np.sin(angle)])
        ahead = np.array([-out[1], out[0]])
        off_m = centre_m + radius_m * out - vehicle.pose.position_world_m[:2]
        vehicle.autopilot.steer(angle + np.pi, 0.5 * ahead + 0.5 * off_m, z_m)
        yield wait(period_s)


def mission(vehicle: OwnVehicle) -> Steps[None]:
    """Circle the box in the pool."""
    yield from circle(vehicle, np.array([3.0, 0.0]), radius_m=4.0, z_m=-3.5)


def main() -> None:
    """Place the vehicle beside the box and fly the mission."""
    sim = uwsim.Simulator("pool")
    sim.rov.release()
    sim.rov.place([7.0, 0.0, -3.5], [0.0, 0.0, 1.0, 0.0])
    run(mission, sim.rov, sim)
    position_m = sim.rov.pose.position_world_m.round(2)
    print(f"once round in {sim.time_s:.0f} s, {sim.rov.collisions} collisions, now at {position_m}")


if __name__ == "__main__":
    main()
