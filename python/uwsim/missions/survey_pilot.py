"""The pilot of a survey: a Controller for vehicles with thrusters, an Autopilot for vehicles without."""

from __future__ import annotations

from collections.abc import Sequence

from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.protocols import SteeredVehicle

Pilot = Autopilot | Controller


def survey_pilot(vehicle: SteeredVehicle, period_s: float) -> Pilot:
    """Return a pilot for a vehicle, to be called once every period_s.

    Thrusters that push below the centre of mass pitch the vehicle and saturate together. An Autopilot, which does not
    model this, made a BlueROV2 Heavy pitch over after 15 s of the lake survey at 1.4 m/s; a Controller models it. A
    vehicle without thrusters receives exactly the commanded wrench; for it, the Autopilot, which does not plan
    accelerations, is 2 % faster and covers 2 % more.
    """
    settings = getattr(vehicle, "control", None)
    if settings is not None and getattr(settings, "thrusters", 0) > 0:
        return Controller(vehicle, period_s, settings=settings)
    return Autopilot(vehicle, period_s)


def memory_of(pilot: Pilot) -> tuple[float, ...]:
    """Return the state carried between periods: 3 values for an Autopilot, 25 for a Controller."""
    return tuple(pilot.memory.tolist()) if isinstance(pilot, Controller) else pilot.integrals


def remember(pilot: Pilot, memory: Sequence[float]) -> None:
    """Restore a state returned by memory_of. Raises ValueError if it comes from the other kind of pilot."""
    expected = len(memory_of(pilot))
    if len(memory) != expected:
        raise ValueError(f"autopilot: {len(memory)} numbers: this vehicle's pilot has {expected}")
    if isinstance(pilot, Controller):
        pilot.memory = memory
    else:
        surge, sway, height = memory
        pilot.integrals = (surge, sway, height)
