"""Exercises for pilots: YAML files with a scenario, goals, limits, events and points; judged against the truth."""

from uwsim.exercises.course import Course
from uwsim.exercises.exercise import Exercise, exercise_names, load_exercise

__all__ = ["Course", "Exercise", "exercise_names", "load_exercise"]
