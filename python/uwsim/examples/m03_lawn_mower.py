"""A survey as one step of a mission: the adaptive lawn-mower over a polygon, with a map and its score."""

import tempfile

import uwsim
from uwsim.missions import LawnMowerPlan, OwnVehicle, Steps, hold, mow

AREA_M = [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]]


def mission(vehicle: OwnVehicle) -> Steps[None]:
    """Survey a square; log when it is done."""
    yield from mow(vehicle, LawnMowerPlan(area_m=AREA_M, altitude_m=2.0, line_spacing_m=2.0, speed_m_s=0.5))
    vehicle.log("mown")
    yield from hold(vehicle, 2.0)


def main() -> None:
    """Fly the mission in the pool."""
    with tempfile.TemporaryDirectory() as out:
        flown = uwsim.fly(mission, "pool", out, map=True, report="json")
    assert flown.score is not None
    pings, share = len(flown.all_pings_world_m), flown.score.coverage
    print(f"{pings} pings in {flown.simulated_s:.0f} s; {100 * share:.0f} % of the visible surface is mapped")


if __name__ == "__main__":
    main()
