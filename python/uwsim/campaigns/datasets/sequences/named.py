"""Named sequences: a scenario, a mission, cameras and a seed, so that results of several labs compare."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from uwsim.base.sockets import planner
from uwsim.campaigns.datasets.sequences.make import Sequence, make_sequence
from uwsim.flight.missions import SURVEY
from uwsim.flight.terminal import Silent
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import InRange, Model, Name

FOLDER = "sequences"


class NamedSequence(Model):
    """A sequence that others can make again.

    version: raised whenever its bytes change their meaning. scenario: a packaged name. mission: the name of a planner,
    or survey for the scenario's own. cameras, instruments: as for make_sequence.
    """

    name: Name
    version: Annotated[int, InRange(1, 1000)]
    task: str = Field(min_length=1, max_length=300)
    scenario: str
    mission: Name
    cameras: list[Name]
    instruments: list[Name] | None = None
    seed: Annotated[int, InRange(0, 2**63 - 1)]
    time_limit_s: Annotated[float, InRange(0.001, 1e7, "s")]


def load_sequence(name: str | Path) -> NamedSequence:
    """Return a packaged sequence's definition, or that of a file. Raises ScenarioError."""
    return read_spec(NamedSequence, name, FOLDER)


def make_named_sequence(
    name: str | Path, out: str | Path, *, bag: bool = True, threads: int | None = None, screen: Silent | None = None
) -> Sequence:
    """Make a packaged sequence, or that of a file, with its baselines; see make_sequence. Raises its errors."""
    spec = load_sequence(name)
    mission = None if spec.mission == SURVEY else planner(spec.mission)
    return make_sequence(
        spec.scenario, mission, out, cameras=spec.cameras, instruments=spec.instruments, bag=bag, baselines=True,
        seed=spec.seed, time_limit_s=spec.time_limit_s, threads=threads, screen=screen,
    )  # fmt: skip
