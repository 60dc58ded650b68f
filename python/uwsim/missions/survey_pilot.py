"""The pilot of a survey: a Controller for thrusters, an Autopilot for forces along the axes."""

from __future__ import annotations

from collections.abc import Sequence

from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.protocols import SteeredVehicle

Pilot = Autopilot | Controller


def survey_pilot(vehicle: SteeredVehicle, period_s: float) -> Pilot:
    """Return the pilot of a vehicle, to be called once in each period.

    Thrusters that push below the centre of mass pitch the vehicle, and saturate together. An Autopilot, which has no
    model of that, pitched a BlueROV2 Heavy over 15 s into the lake's survey at 1.4 m/s; a Controller has a model.
    Without thrusters the vehicle receives exactly the commanded wrench: there the Autopilot, which does not plan its
    accelerations, is faster by 2 % and covers that much more.
    """
    settings = getattr(vehicle, "control", None)
    if settings is not None and getattr(settings, "thrusters", 0) > 0:
        return Controller(vehicle, period_s, settings=settings)
    return Autopilot(vehicle, period_s)


def memory_of(pilot: Pilot) -> tuple[float, ...]:
    """Return the state carried between periods: 3 numbers of an Autopilot, 25 of a Controller."""
    return tuple(pilot.memory.tolist()) if isinstance(pilot, Controller) else pilot.integrals


def remember(pilot: Pilot, memory: Sequence[float]) -> None:
    """Continue from the result of memory_of. Raises ValueError if it belongs to another kind of pilot."""
    expected = len(memory_of(pilot))
    if len(memory) != expected:
        raise ValueError(f"autopilot: {len(memory)} numbers: this vehicle's pilot has {expected}")
    if isinstance(pilot, Controller):
        pilot.memory = memory
    else:
        surge, sway, height = memory
        pilot.integrals = (surge, sway, height)
