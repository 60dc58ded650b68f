"""Team: the model of a team's file, which states what flies, and which course."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from uwsim.exercises import Exercise, load_exercise
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import InRange, Model
from uwsim.scenario.spec.scenario import Scenario

TEAM = "team.yaml"


class Team(Model):
    """A team and its program.

    name: on the results. course: a packaged exercise, or the path of one, that the program flies. program: the words of
    its command, started in the team's folder; python3 is the Python that runs uwsim. period_s: the simulated time
    between two answers of the program. pictures_hz: the rate of the vehicle's pictures, at most that of each camera,
    rate_hz, which is the default.
    """

    name: str = Field(min_length=1, max_length=80)
    course: str
    program: Annotated[list[str], Field(min_length=1, max_length=100)]
    period_s: Annotated[float, InRange(0.01, 1.0, "s")] = 0.1
    pictures_hz: Annotated[float, InRange(0.01, 10, "Hz")] | None = None

    def require_rate(self, scenario: Scenario) -> None:
        """Raise ScenarioError if a camera of a scenario's first vehicle takes fewer pictures."""
        for name, camera in scenario.vehicles[0].model.cameras.items():
            if self.pictures_hz is not None and self.pictures_hz > camera.rate_hz:
                rule = f"must be at most {camera.rate_hz:g} Hz, the rate of the course's camera '{name}'"
                raise ScenarioError(f"team: pictures_hz = {self.pictures_hz:g} Hz: {rule}")


def load_team(folder: str | Path) -> Team:
    """Return the team of a folder. Raises ScenarioError, with one line for each mistake, or OSError."""
    path = Path(folder) / TEAM
    if not path.is_file():
        raise FileNotFoundError(f"'{path}': no such file: `uwsim course new` makes a team's folder")
    return read_spec(Team, path, "")


def load_course(name: str, folder: str | Path) -> Exercise:
    """Return a course by packaged name or by path, first in a team's folder.

    Raises ScenarioError if it cannot be read, or if no program may fly it.
    """
    beside = Path(folder) / name
    found = load_exercise(beside if beside.is_file() else name)
    if all(aid.kind != "program" for aid in found.aids):
        raise ScenarioError(f"course '{name}': aids: must have the kind program, since a program flies it")
    if found.lag_s:
        raise ScenarioError(f"course '{name}': lag_s = {found.lag_s:g} s: must be 0 for a program, which is aboard")
    return found
