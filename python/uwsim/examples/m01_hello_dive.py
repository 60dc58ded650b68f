"""A minimal mission: leave the dock, dive, read the altitude, come up."""

import uwsim
from uwsim.missions import Steps, Vehicle, dive_to, hold


def mission(vehicle: Vehicle, depth_m: float = 8.0) -> Steps[float]:
    """Dive to a depth, stay for five seconds, and come up to 3 m; return the altitude at the deepest point."""
    vehicle.undock()
    yield from dive_to(vehicle, depth_m)
    yield from hold(vehicle, 5.0)
    altitude_m = float(vehicle.sensors["altitude"].read())
    vehicle.log("deepest", depth_m=vehicle.telemetry().depth_m, altitude_m=altitude_m)
    yield from dive_to(vehicle, 3.0)
    return altitude_m


def main() -> None:
    """Fly the mission in the lake."""
    flown = uwsim.fly(mission, "lake")
    deepest_m = flown.samples["rov"]["depth_m"].max()
    print(f"{deepest_m:.1f} m deep, {flown.result:.1f} m above the bed, back after {flown.simulated_s:.0f} s")


if __name__ == "__main__":
    main()
