"""flyable: what an exercise needs before anyone can fly it, for the command, the station, courses and the editor."""

from __future__ import annotations

from uwsim.exercises.course import Course
from uwsim.exercises.exercise import Exercise
from uwsim.scenario import Scenario
from uwsim.simulator.simulator import Simulator


def flyable(
    exercise: Exercise, threads: int | None = None, scene: Scenario | None = None
) -> tuple[Exercise, Simulator]:
    """Return an exercise whose goals are in the world, and its simulator, in which its events have been tried.

    scene: its scenario, by default as its file has it. Raises ValueError or ScenarioError if the scenario cannot be
    built, or lacks what a goal, a limit or an event needs; OSError.
    """
    scene = exercise.scene() if scene is None else scene
    found = exercise.in_world(scene)
    sim = Simulator(found.made_scenario(scene), threads=threads)
    Course.require_events(found, sim)
    return found, sim
