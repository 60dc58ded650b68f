"""A scripted pilot of the exercise `hover` who steers all the time by what is seen, as if it were now.

uwsim exercise hover --pilot python/uwsim/examples/m16_steady_pilot.py --lag 0,0.5,1,2 --out steady
"""

import math

import numpy as np
from numpy.typing import NDArray

import uwsim
from uwsim.missions import Steps, Vehicle, wait

TARGET_M = np.array([0.0, 0.0, -2.5])
NORTH_RAD = math.pi / 2.0
PULL, BRAKE, TURN, FULL = 0.5, 0.4, 0.6, 0.6  # efforts per m, per m/s and per rad, and the largest
LOOK_S = 0.2


def away_body_m(vehicle: Vehicle) -> NDArray[np.float64]:
    """Return the way to the target (3,), in the axes of the vehicle as it is seen."""
    pose = vehicle.pose
    return np.asarray(pose.world_from_body[:3, :3].T @ (TARGET_M - pose.position_world_m), np.float64)


def off_north_rad(vehicle: Vehicle) -> float:
    """Return the turn to the north, counter-clockwise."""
    return math.remainder(NORTH_RAD - vehicle.pose.yaw_rad, 2.0 * math.pi)


def mission(vehicle: Vehicle) -> Steps[None]:
    """Pull towards the target, brake, and turn to the north, until the exercise is over."""
    while True:
        efforts = PULL * away_body_m(vehicle) - BRAKE * np.asarray(vehicle.velocity.linear_body_m_s)
        surge, sway, heave = np.clip(efforts, -FULL, FULL).tolist()
        yaw = min(max(TURN * off_north_rad(vehicle), -0.5 * FULL), 0.5 * FULL)
        vehicle.set_effort(surge=surge, sway=sway, heave=heave, yaw=yaw)
        yield wait(LOOK_S)


def main() -> None:
    """Fly for a minute in the pool without a lag."""
    sim = uwsim.Simulator("training_pool")
    sim.rov.undock()
    uwsim.fly(mission, sim, time_limit_s=60.0)
    print(f"{np.linalg.norm(sim.rov.pose.position_world_m - TARGET_M):.2f} m from the place after {sim.time_s:.0f} s")


if __name__ == "__main__":
    main()
