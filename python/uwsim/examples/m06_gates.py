"""Gate passing by sonar: the vehicle finds the posts in level pings and passes between them, there and back."""

import uwsim
from uwsim.missions import OwnVehicle, Steps, goto
from uwsim.missions.planners.gate import pass_gate


def mission(vehicle: OwnVehicle) -> Steps[list[float]]:
    """Pass a gate of known size and approximate position twice; return the measured widths."""
    vehicle.undock()
    yield from goto(vehicle, (-13.0, 0.0), altitude_m=3.0)
    widths_m = []
    for _ in range(2):
        gate = yield from pass_gate(vehicle, near_m=(-5.0, 3.0), width_m=4.0, height_m=4.0)
        widths_m.append(gate.width_m)
    return widths_m


def main() -> None:
    """Fly the mission in the cove."""
    flown = uwsim.fly(mission, "cove")
    widths = " and ".join(f"{width_m:.2f} m" for width_m in flown.result)
    print(f"passed twice in {flown.simulated_s:.0f} s, {flown.collisions} collisions; measured {widths}")


if __name__ == "__main__":
    main()
