"""A boat carries an ROV to its site, launches it, and stays above it while it flies around."""

import numpy as np

import uwsim
from uwsim.missions import OwnVehicle, Steps, follow, goto, parallel, wait

SITE_M = (40.0, 10.0, 0.0)
ROUND_M = [[44.0, 14.0], [60.0, 14.0], [60.0, 30.0], [44.0, 30.0], [44.0, 14.0]]
NEAR_M = 8.0
"""The boat moves when the ROV is farther away than this."""


def apart_m(boat: OwnVehicle, rov: OwnVehicle) -> float:
    """Return the horizontal distance."""
    return float(np.linalg.norm(rov.pose.position_world_m[:2] - boat.pose.position_world_m[:2]))


def stay_above(boat: OwnVehicle, rov: OwnVehicle, done: list[str]) -> Steps[None]:
    """Go where the ROV is whenever it is farther away than NEAR_M, until it is done."""
    while not done:
        x, y, _ = rov.pose.position_world_m
        if apart_m(boat, rov) > NEAR_M:
            yield from goto(boat, (x, y, 0.0), speed_m_s=0.8, within_m=4.0)
        else:
            yield from wait(1.0)


def fly_round(rov: OwnVehicle, done: list[str]) -> Steps[None]:
    """Fly once around the site, 4 m above the bed."""
    rov.undock()
    rov.log("launched")
    try:
        yield from follow(rov, np.array(ROUND_M), altitude_m=4.0, speed_m_s=0.5)
    finally:
        done.append(rov.name)


def mission(vehicles: dict[str, OwnVehicle]) -> Steps[float]:
    """Return the horizontal distance between the two at the end."""
    boat, rov = vehicles["boat"], vehicles["rov"]
    yield from goto(boat, SITE_M, speed_m_s=1.2, within_m=3.0)
    done: list[str] = []
    yield from parallel(fly_round(rov, done), stay_above(boat, rov, done))
    return apart_m(boat, rov)


def main() -> None:
    """Fly the mission in the packaged scenario `lake_boat`."""
    flown = uwsim.fly(mission, "lake_boat")
    assert not flown.ended_early, flown.ended_because
    print(f"{flown.simulated_s:.0f} s, the boat {flown.result:.1f} m from the ROV at the end")


if __name__ == "__main__":
    main()
