"""The suite `flights`: logs of real vehicles in a folder, each beside a model and the simplest one.

The folder has `flights.yaml`, which names each log, the vehicle that is flown beside it, and the water's density. A
model passes where its mean error is at most that of the double integrator, in the same windows.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

from uwsim.evidence.validate.check import Check, at_most
from uwsim.recording.real_flights.beside import ERRORS, SIMPLEST, fly_beside
from uwsim.recording.real_flights.motion import motion_of
from uwsim.recording.real_flights.read import read_flight
from uwsim.scenario import load_vehicle
from uwsim.scenario.read.spec_file import read_yaml
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import InRange, Model

LIST = "flights.yaml"
HORIZONS_S = (1.0, 2.0, 5.0, 10.0)


class LoggedFlight(Model):
    """A log. vehicle: a packaged one, or a file. columns, outputs: as of `uwsim replay`. source: whose it is."""

    file: Path
    vehicle: str
    density_kg_m3: Annotated[float, InRange(900, 1200, "kg/m3")] = 1025.0
    columns: str | None = None
    outputs: str | None = None
    source: str = ""


class _File(Model):
    flights: list[LoggedFlight]


def run(data: Path | None) -> list[Check]:
    """Return the checks of all flights.

    A log that is missing, or has nothing to compare, is left out with a warning. Raises ValueError if none is left.
    """
    if data is None:
        raise ValueError(
            f"validate flights: needs --data FOLDER, with logs and {LIST}; see docs/guides/real-flights.md"
        )
    document = read_yaml(data / LIST, str(data / LIST))
    found: list[Check] = []
    for flight in validated(_File, document.values, document).flights:
        try:
            found += checks_of(flight, data)
        except (OSError, ValueError) as error:
            warnings.warn(f"validate flights: {flight.file} is left out: {error}", stacklevel=2)
    if not found:
        raise ValueError(f"validate flights: nothing in {data} can be compared")
    return found


def checks_of(flight: LoggedFlight, folder: Path) -> list[Check]:
    """Return the checks of a flight. Raises OSError, or ValueError with the file and the rule."""
    model = load_vehicle(flight.vehicle, folder)
    motion, _ = motion_of(read_flight(folder / flight.file, flight.columns), model, flight.outputs)
    flown = fly_beside(motion, model, density_kg_m3=flight.density_kg_m3, horizons_s=HORIZONS_S)
    found = []
    for horizon_s, errors in flown.horizons.items():
        for name, unit in ERRORS.items():
            ours, simplest = errors[name], flown.integrator[horizon_s][name]
            if ours is None or simplest is None or simplest.value == 0.0:
                continue
            spread = "" if ours.low is None else f" ({ours.low:.2g} to {ours.high:.2g})"
            text = f"error of {name} after {horizon_s:g} s{spread}, that of the {SIMPLEST},"
            found.append(at_most(f"{flight.file}: {flight.vehicle}", text, simplest.value, ours.value, unit))
    return found
