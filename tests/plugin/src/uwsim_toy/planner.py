"""The planner `square`, a mission for `uwsim compare`."""

from uwsim.missions import Steps, goto
from uwsim.missions.own_vehicle import OwnVehicle


def square(vehicle: OwnVehicle, side_m: float = 4.0) -> Steps[None]:
    """Fly round a square whose first corner is where the vehicle is."""
    if not vehicle.released:
        vehicle.undock()
    x, y, z = vehicle.pose.position_world_m.tolist()
    for east, north in ((1, 0), (1, 1), (0, 1), (0, 0)):
        yield from goto(vehicle, (x + side_m * east, y + side_m * north, z))
