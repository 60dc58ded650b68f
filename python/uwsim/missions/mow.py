"""mow: the adaptive lawn-mower as a mission step."""

from __future__ import annotations

from uwsim.missions.lawn_mower import COVERED, AdaptiveLawnMower
from uwsim.missions.lawn_mower_plan import LawnMowerPlan
from uwsim.missions.own_vehicle import own_vehicle
from uwsim.missions.steps import Steps, StoppedError
from uwsim.missions.vehicle import Vehicle


def mow(vehicle: Vehicle, plan: LawnMowerPlan) -> Steps[None]:
    """Fly the lanes of a plan with the adaptive lawn-mower. Raises StoppedError unless all lanes are flown."""
    own = own_vehicle(vehicle)
    ended = yield from AdaptiveLawnMower(own, own, plan).steps()
    if ended != COVERED:
        raise StoppedError(ended)
