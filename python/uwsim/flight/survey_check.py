"""checked: the verdict on a scenario that `uwsim scenario check`, the station's editor and `uwsim survey` share."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from uwsim.base.caught_warnings import caught_warnings
from uwsim.flight.flyable_lanes import required_plan
from uwsim.scenario import Scenario
from uwsim.simulator.simulator import Simulator


class Checked(NamedTuple):
    """A verdict. mistakes, warnings: one line each. simulator: the scenario's, None if it cannot be built."""

    mistakes: tuple[str, ...]
    warnings: tuple[str, ...]
    simulator: Simulator | None


def checked(load: Callable[[], Scenario], threads: int | None = None) -> Checked:
    """Build a scenario's simulator and plan its survey, if it has one, as a flight of it would.

    load: returns the scenario, or raises ValueError. Raises OSError.
    """
    simulator, left_out = None, None
    mistakes: tuple[str, ...] = ()
    with caught_warnings() as issued:
        try:
            simulator = Simulator(load(), threads=threads)
            if simulator.scenario.survey is not None:
                left_out = required_plan(simulator)[1]
        except ValueError as error:
            mistakes = tuple(getattr(error, "mistakes", ())) or (str(error),)
    notes = [str(each.message) for each in issued if issubclass(each.category, UserWarning)]
    if simulator is not None and left_out is not None:
        notes.append(f"{simulator.scenario.source_file.line_prefix('survey', 'area_m')}{left_out}")
    return Checked(mistakes, tuple(dict.fromkeys(notes)), simulator)
