"""A glider without a propeller dives and climbs, and counts the work of its pump for each kilometre.

The pump's work is the water's pressure times the volume that it pushes out at the bottom; near the surface the volume
is drawn in again for nothing. Between the surface and any depth that is the net buoyancy times the slope for each metre
of ground. A real pump's battery gives several times as much; its losses are not modelled.
"""

import numpy as np

import uwsim
from uwsim.missions import OwnVehicle, Steps, wait

UPPER_M, LOWER_M, DIVES = 12.0, 100.0, 3
BATTERY = 0.2
"""How far the battery moves for the slope, as a share of its travel."""
STROKE_M3 = 2 * 0.25e-3  # from full to empty: assets/thrusters/slocum_pump.yaml
WEIGHT_N_M3 = 1025.0 * 9.80665


def glide(vehicle: OwnVehicle, to_m: float) -> Steps[float]:
    """Pump and move the battery, then glide until this depth; return the depth at which it was pumped."""
    from_m = -float(vehicle.pose.position_world_m[2])
    down = to_m > from_m
    vehicle.set_thrusters({"pump": -1.0 if down else 1.0, "battery": -BATTERY if down else BATTERY})
    while (-float(vehicle.pose.position_world_m[2]) < to_m) is down:
        yield wait(1.0)
    return from_m


def mission(vehicle: OwnVehicle) -> Steps[tuple[float, float]]:
    """Return the ground covered [m] and the work of the pump [J]."""
    start_m, work_j = vehicle.pose.position_world_m[:2].copy(), 0.0
    for dive in range(DIVES):
        yield from glide(vehicle, LOWER_M)
        bottom_m = yield from glide(vehicle, UPPER_M)
        work_j += STROKE_M3 * WEIGHT_N_M3 * bottom_m
        vehicle.log("dive", number=dive + 1, bottom_m=bottom_m, pump_j=work_j)
    ground_m = float(np.linalg.norm(vehicle.pose.position_world_m[:2] - start_m))
    vehicle.set_thrusters({"pump": 0.0, "battery": 0.0})
    return ground_m, work_j


def main() -> None:
    """Fly the mission in the packaged scenario `shelf`."""
    flown = uwsim.fly(mission, "shelf")
    assert not flown.ended_early, flown.ended_because
    ground_m, work_j = flown.result
    print(f"{flown.simulated_s:.0f} s, {ground_m:.0f} m, {1e3 * work_j / ground_m:.0f} J of pumping a kilometre")


if __name__ == "__main__":
    main()
