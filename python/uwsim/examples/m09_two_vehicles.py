"""Two vehicles share a survey: each flies half of the lanes, and the pings of both sonars go into one map."""

import numpy as np

import uwsim
from uwsim.missions import OwnVehicle, Steps, follow, lawn_mower_lanes, parallel

HALVES_M = {
    "rov": [[-8.0, 2.0], [20.0, 2.0], [20.0, 20.0], [-8.0, 20.0]],
    "scout": [[-8.0, -20.0], [20.0, -20.0], [20.0, -2.0], [-8.0, -2.0]],
}


def mow_half(vehicle: OwnVehicle) -> Steps[None]:
    """Fly the lanes in this vehicle's half."""
    if not vehicle.released:
        vehicle.undock()
    vehicle.sonar.aim(-0.5)
    lanes = lawn_mower_lanes(HALVES_M[vehicle.name], 6.0, 0.0, np.asarray(vehicle.pose.position_world_m[:2]))
    points = [end for lane in lanes for end in (lane.start_m, lane.end_m)]
    yield from follow(vehicle, np.array(points), altitude_m=5.0, speed_m_s=0.6)
    vehicle.log("half_done", lanes=len(lanes))


def mission(vehicles: dict[str, OwnVehicle]) -> Steps[None]:
    """Fly both vehicles at the same time."""
    yield from parallel(*(mow_half(vehicle) for vehicle in vehicles.values()))


def main() -> None:
    """Fly the mission in the basin of the packaged scenario `pair`."""
    flown = uwsim.fly(mission, "pair", map=True, voxel_m=0.5)
    assert flown.occupancy is not None
    pings = {name: len(path) for name, path in flown.pings_world_m.items()}
    assert not flown.ended_early, flown.ended_because
    print(f"{pings} pings in {flown.simulated_s:.0f} s, {flown.occupancy.statistics().occupied_voxels} voxels, one map")


if __name__ == "__main__":
    main()
