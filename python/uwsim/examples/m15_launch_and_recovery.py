"""A boat lowers an ROV by its winch, follows it by its USBL while it works, and winds it up again.

The boat knows its own position, by its filter from GNSS, compass and IMU, and its USBL's fixes of the ROV. Both steer
by their own estimates, never by the truth.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import uwsim
from uwsim.missions import OwnVehicle, Steps, dive_to, follow, goto, parallel, until, wait

HEAD_M, SHEAVE_M = (-0.5, 0.0, 0.0), (-1.45, 0.0, 1.2)
"""The USBL's origin and the A-frame's sheave in the boat's frame: assets/scenarios/lake_tender.yaml."""
SITE_M = [[14.0, 10.0], [34.0, 10.0], [34.0, 26.0], [14.0, 26.0], [14.0, 10.0]]
NEAR_M, SPEED_M_S, PER_S = 3.0, 0.9, 0.3
"""The boat stays where it is while the ROV is nearer than NEAR_M, and drives to it the faster the farther it is."""
WINCH_M_S, WINCH_N = 0.3, 5.0
"""The winch lowers and recovers at this rate; while the ROV works, it keeps this tension, light enough to fly with."""
LOWERED_M, HUNG_M = 4.0, 0.5
"""Lengths out when it has been lowered, and when it hangs on the A-frame."""


def on_boat(boat: OwnVehicle, point_m: Sequence[float]) -> NDArray[np.float64]:
    """Return where a point of the boat is in the world, by its estimate."""
    world_from_body = boat.pose.world_from_body
    return np.asarray(world_from_body[:3, :3] @ point_m + world_from_body[:3, 3])


def seen(boat: OwnVehicle, rov: OwnVehicle) -> NDArray[np.float64]:
    """Return where the boat sees the ROV: by its own position and the newest fix of its USBL."""
    return np.asarray(on_boat(boat, HEAD_M) + rov.sensors["usbl"].read().position_m)


def stay_near(boat: OwnVehicle, rov: OwnVehicle, done: list[str]) -> Steps[None]:
    """Drive to where the ROV is seen whenever it is farther away than NEAR_M, until it is done."""
    pilot, heading_rad = boat.autopilot, boat.pose.yaw_rad
    while not done:
        away_m = (seen(boat, rov) - boat.pose.position_world_m)[:2]
        gap_m = float(np.linalg.norm(away_m))
        speed_m_s = min(SPEED_M_S, PER_S * max(gap_m - NEAR_M, 0.0))
        if gap_m > NEAR_M:
            heading_rad = math.atan2(away_m[1], away_m[0])
        pilot.steer(heading_rad, speed_m_s / max(gap_m, 1e-9) * away_m, 0.0)
        yield wait(pilot.period_s)


def wind(rov: OwnVehicle, length_m: float) -> Steps[None]:
    """Pay out or recover until this length is out."""
    tether = rov.tether
    assert tether is not None
    rate_m_s = math.copysign(WINCH_M_S, length_m - tether.read().length_m)
    rov.set_winch(rate_m_s=rate_m_s)
    yield from until(lambda: (tether.read().length_m - length_m) * rate_m_s >= 0.0, timeout_s=120.0, every_s=0.1)
    rov.set_winch()


def work(boat: OwnVehicle, rov: OwnVehicle, done: list[str]) -> Steps[None]:
    """Fly round the site, 4 m above the bed, and back under the A-frame, where the fixes lead."""
    try:
        yield from follow(rov, np.array(SITE_M), altitude_m=4.0, speed_m_s=0.5)
        yield from dive_to(rov, 4.0)
        while np.linalg.norm((left_m := on_boat(boat, SHEAVE_M) - seen(boat, rov))[:2]) > 1.5:
            x, y, _ = rov.pose.position_world_m + left_m
            yield from goto(rov, (x, y, -4.0), within_m=1.0)
    finally:
        done.append(rov.name)


def mission(vehicles: dict[str, OwnVehicle]) -> Steps[None]:
    """Lower the ROV, work, and wind it up; the boat's propellers rest while the ROV is near them."""
    boat, rov = vehicles["boat"], vehicles["rov"]
    yield from wind(rov, LOWERED_M)
    rov.log("lowered")
    rov.set_winch(tension_n=WINCH_N)
    back: list[str] = []
    yield from parallel(work(boat, rov, back), stay_near(boat, rov, back))
    rov.log("back")
    boat.set_effort()
    rov.set_effort()
    yield from wind(rov, HUNG_M)
    rov.log("wound up")
    yield wait(10.0)


def main() -> None:
    """Fly the mission in the packaged scenario `lake_tender`."""
    flown = uwsim.fly(mission, "lake_tender", estimate="filter")
    assert not flown.ended_early, flown.ended_because
    print(f"{flown.simulated_s:.0f} s")


if __name__ == "__main__":
    main()
