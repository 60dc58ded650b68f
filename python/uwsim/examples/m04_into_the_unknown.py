"""The adaptive lawn-mower in unknown water: it turns where its sonar finds an obstacle or the bed."""

import uwsim
from uwsim.missions import OwnVehicle, Steps
from uwsim.missions.planners.unknown_water import MownWater, mow_unknown_water


def mission(vehicle: OwnVehicle, bound_m: float = 25.0) -> Steps[MownWater]:
    """Survey all water that can be reached within a distance of the station, without a given polygon."""
    vehicle.undock()
    return (yield from mow_unknown_water(vehicle, bound_m, line_spacing_m=5.0, altitude_m=3.0, speed_m_s=0.7))


def main() -> None:
    """Fly the mission in the cove, around an island in its centre."""
    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    openings = sum(event.name == "opening" for event in flown.events)
    print(
        f"{flown.result.flown_m2:.0f} m2 mown in {flown.simulated_s:.0f} s, {openings} openings revisited, "
        f"{flown.collisions} collisions"
    )


if __name__ == "__main__":
    main()
