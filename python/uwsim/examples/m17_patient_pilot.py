"""A scripted pilot of the exercise `hover` who moves and waits, as people do over a delay (Ferrell 1965).

uwsim exercise hover --pilot python/uwsim/examples/m17_patient_pilot.py --lag 0,0.5,1,2 --out patient

W. R. Ferrell, "Remote manipulation with transmission delay", IEEE Transactions on Human Factors in Electronics 6, 1965.
"""

import numpy as np

import uwsim
from uwsim.examples.m16_steady_pilot import TARGET_M, away_body_m, off_north_rad
from uwsim.missions import Steps, Vehicle, until, wait

NEAR_M, NORTH_RAD = 0.2, 0.08
PUSH, PUSH_S_PER_M, TURN, TURN_S_PER_RAD = 0.3, 0.8, 0.2, 0.8
SHORTEST_S, LONGEST_S, PATIENCE_S = 0.2, 3.0, 8.0
MOVING, RESTING = 0.1, 0.08  # m/s or rad/s


def seen_speed(vehicle: Vehicle) -> float:
    """Return the larger of the speed [m/s] and the rate of turn [rad/s] that are seen."""
    velocity = vehicle.velocity
    return float(max(np.linalg.norm(velocity.linear_body_m_s), abs(velocity.angular_body_rad_s[2])))


def push(vehicle: Vehicle, duration_s: float, **efforts: float) -> Steps[None]:
    """Push for a while; then wait until that has been seen to begin, and to end."""
    vehicle.set_effort(**efforts)
    yield wait(min(max(duration_s, SHORTEST_S), LONGEST_S))
    vehicle.set_effort()
    yield from until(lambda: seen_speed(vehicle) > MOVING, timeout_s=PATIENCE_S)
    yield from until(lambda: seen_speed(vehicle) < RESTING, timeout_s=PATIENCE_S)


def mission(vehicle: Vehicle) -> Steps[None]:
    """Push towards the target, or turn to the north, one at a time, until the exercise is over."""
    while True:
        away_m, turn_rad = away_body_m(vehicle), off_north_rad(vehicle)
        distance_m = float(np.linalg.norm(away_m))
        if distance_m > NEAR_M:
            surge, sway, heave = (PUSH * away_m / distance_m).tolist()
            yield from push(vehicle, PUSH_S_PER_M * distance_m, surge=surge, sway=sway, heave=heave)
        elif abs(turn_rad) > NORTH_RAD:
            yield from push(vehicle, TURN_S_PER_RAD * abs(turn_rad), yaw=float(np.copysign(TURN, turn_rad)))
        else:
            yield wait(0.5)


def main() -> None:
    """Fly for a minute in the pool without a lag."""
    sim = uwsim.Simulator("training_pool")
    sim.rov.undock()
    uwsim.fly(mission, sim, time_limit_s=60.0)
    print(f"{np.linalg.norm(sim.rov.pose.position_world_m - TARGET_M):.2f} m from the place after {sim.time_s:.0f} s")


if __name__ == "__main__":
    main()
