"""One mission flown twice: in this process, and with a vehicle behind rosbridge, as a real vehicle would be."""

import numpy as np

import uwsim
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.remote.flight import fly_remote
from uwsim.live import LiveSimulator
from uwsim.missions import OwnVehicle, Steps, goto, turn_to


def mission(vehicle: OwnVehicle) -> Steps[np.ndarray]:
    """Leave the dock, go to a position and turn back; return the vehicle's position."""
    vehicle.undock()
    yield from goto(vehicle, (0.0, 3.0), altitude_m=2.0)
    yield from turn_to(vehicle, -2.0)
    vehicle.log("looking back", nearest_m=float(np.nanmin(vehicle.sonar.ping().ranges_m)))
    return np.asarray(vehicle.pose.position_world_m)


def main() -> None:
    """Fly the mission both ways in the pool.

    The server could be anywhere: `uwsim run FILE --connect ws://HOST:9090`.
    """
    here_m = uwsim.fly(mission, "pool").result
    with LiveSimulator("pool", paused=True) as live, RosbridgeServer(live) as server:
        there_m = fly_remote(mission, server.url, lockstep=True).result
    print(
        f"here it ended at {here_m.round(2)} m, over the rosbridge {np.linalg.norm(here_m - there_m):.2f} m from there"
    )


if __name__ == "__main__":
    main()
