"""Shows the adaptive lawn-mower in water of which nothing is known: it turns where the sonar says so."""

import uwsim
from uwsim.missions import OwnVehicle, Steps
from uwsim.missions.planners.unknown_water import MownWater, mow_unknown_water


def mission(vehicle: OwnVehicle, bound_m: float = 25.0) -> Steps[MownWater]:
    """Mow all water within a distance of the station that can be reached; no polygon is given."""
    vehicle.undock()
    return (yield from mow_unknown_water(vehicle, bound_m, line_spacing_m=5.0, altitude_m=3.0, speed_m_s=0.7))


def main() -> None:
    """Fly it in the cove, from whose middle an island rises."""
    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    openings = sum(event.name == "opening" for event in flown.events)
    print(
        f"{flown.result.flown_m2:.0f} m2 mown in {flown.simulated_s:.0f} s, {openings} openings gone back to, "
        f"{flown.collisions} collisions"
    )


if __name__ == "__main__":
    main()
