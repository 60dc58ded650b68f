"""New goals of an exercise: what they name in its scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from uwsim.channels.guest import Values
from uwsim.exercises.goal import GoalModel
from uwsim.operator.station.editor.files import EXERCISE, SceneFiles
from uwsim.scenario import Scenario

MARKED = ("net", "pipeline")
"""Kinds of obstacles on which there is something to find."""


def goal_values(scenario: Scenario, goals: Sequence[GoalModel], values: Values, own: Mapping[str, Any]) -> Values:
    """Return the values of a goal that follows others.

    values: those with which its kind begins. own: those that were chosen. A body, an obstacle or a joint that it needs
    is the first of the scene that it can be about. Raises ValueError if there is none.
    """
    kind, names = str(values["kind"]), [goal.name for goal in goals]
    first = {"kind": kind, "name": free_name(kind, names), "title": kind.replace("_", " ").capitalize()}
    after = {"after": names[-1]} if names else {}
    in_prop = {"position_m": [0.0, 0.0, 0.0]} if own.get("of") and "position_m" in values else {}
    found = {**first, **values, **first, **after, **in_prop, **own}
    bodies = {body.name: body for body in scenario.objects if _is_for(kind, body)}
    marked = [each.name for each in scenario.obstacles if each.kind in MARKED]
    for key, known in (("object", list(bodies)), ("obstacle", marked)):
        if found.get(key) == "" and not known:
            raise ValueError(f"{kind}: there is no {key} that it can be about: add one first")
        if found.get(key) == "":
            found[key] = known[0]
    if found.get("joint") == "" and found["object"] in bodies:
        found["joint"] = next(iter(bodies[found["object"]].links or ()), "")
    return {key: value for key, value in found.items() if value is not None}


def choices(scenario: Scenario, goals: Sequence[GoalModel], own: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return what the fields of a goal, an event or the layout may name, by field; a list of goals is text."""
    kind, names = str(own.get("kind", "")), [goal.name for goal in goals]
    earlier = names[: names.index(own["name"])] if own.get("name") in names else names
    body = next((each for each in scenario.objects if each.name == own.get("object")), None)
    return {
        "object": [each.name for each in scenario.objects if _is_for(kind, each)],
        "obstacle": [each.name for each in scenario.obstacles if each.kind in MARKED],
        "joint": list(body.links or ()) if body else [],
        **{key: [each.name for each in scenario.placed_props] for key in ("of", "prop")},
        **({} if kind == "time_left" or isinstance(own.get("after"), list) else {"after": earlier}),
    }


def referring(files: SceneFiles, old: str, new: str | None) -> SceneFiles:
    """Return files in which what comes after a goal comes after another one, or after none."""
    for section in ("goals", "events"):
        for k, part in enumerate(files.values[EXERCISE].get(section) or ()):
            place, after = (EXERCISE, section, k, "after"), part.get("after")
            if isinstance(after, list) and old in after:
                files = files.with_value(place, [new if each == old else each for each in after if each != old or new])
            elif after == old:
                files = files.without(place) if new is None else files.with_value(place, new)
    return files


def exchanged(files: SceneFiles, one: int, other: int) -> SceneFiles:
    """Return files in which two goals have changed places: what came after one comes after the other."""
    goals = files.values[EXERCISE]["goals"]
    names = [goal["name"] for goal in goals]
    became = dict(zip(names, names, strict=True)) | {names[one]: names[other], names[other]: names[one]}
    for k, there in enumerate(goals):
        goal = {key: value for key, value in goals[{one: other, other: one}.get(k, k)].items() if key != "after"}
        if (after := there.get("after")) is not None:  # belongs to the place
            goal["after"] = became[after] if isinstance(after, str) else [became[name] for name in after]
        if goal != there:
            files = files.with_value((EXERCISE, "goals", k), goal)
    return files


def first_prop(scenario: Scenario, layout: Sequence[Values], own: Mapping[str, Any]) -> Values:
    """Return the prop that a new part of the layout moves: the first that no other does. Raises ValueError."""
    moved = [each["prop"] for each in layout]
    names = [prop.name for prop in scenario.placed_props if prop.name not in moved]
    if not names and "prop" not in own:
        raise ValueError("layout: there is no other prop that it could move: add one first")
    return {"prop": own.get("prop") or names[0]}


def free_name(base: str, taken: Sequence[Any]) -> str:
    """Return a name that is not taken: base, or with a number after it."""
    names = (base if k == 1 else f"{base}_{k}" for k in range(1, len(taken) + 3))
    return next(name for name in names if name not in taken)


def _is_for(kind: str, body: Any) -> bool:
    """Return whether a goal of a kind can be about a body."""
    if kind == "move_joint":
        return body.links is not None
    return kind != "bring" or (body.path is None and not body.fixed)
