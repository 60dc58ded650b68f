"""Conduct: everything in an attempt at an exercise that was not the pilot's own steering: outside acts, and aids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from uwsim.channels.authority.rights import AidKind
from uwsim.exercises.exercise import Aid

ACTS_MAX = 1000


class OutsideAct(NamedTuple):
    """Something done by another than the pilot. time_s: since the beginning. changed: whether it changed the world."""

    time_s: float
    by: str
    text: str
    changed: bool


@dataclass
class Conduct:
    """The outside acts and the aids of one attempt.

    It is not part of a saved moment: what was done remains, even if the instructor returns to a time before. allowed:
    the aids that the exercise allows. omitted: the number of acts beyond ACTS_MAX, which are only counted.
    """

    allowed: Sequence[Aid]
    acts: list[OutsideAct] = field(default_factory=list)
    omitted: int = 0
    used_s: dict[AidKind, float] = field(default_factory=dict)
    _changed_by: list[str] = field(default_factory=list)

    def note(self, act: OutsideAct) -> None:
        """Add an outside act."""
        if act.changed and act.by not in self._changed_by:
            self._changed_by.append(act.by)
        if len(self.acts) < ACTS_MAX:
            self.acts.append(act)
        else:
            self.omitted += 1

    def note_aid(self, kind: AidKind, duration_s: float) -> None:
        """Add a time for which an aid was in use."""
        self.used_s[kind] = self.used_s.get(kind, 0.0) + duration_s

    @property
    def cost(self) -> float:
        """The points that the aids have cost."""
        return sum(aid.cost_per_s * self.used_s.get(aid.kind, 0.0) for aid in self.allowed)

    @property
    def invalid_because(self) -> str:
        """Why the score is not valid; "" if it is."""
        reasons = [f"the world was changed by {who}" for who in self._changed_by]
        kinds = [aid.kind for aid in self.allowed]
        reasons += [f"{kind} was used, an aid that is not allowed" for kind in self.used_s if kind not in kinds]
        return "; ".join(reasons)

    def aids(self) -> list[dict[str, Any]]:
        """Return kind, is_allowed, used_s, cost_per_s and cost of each aid that is allowed or was used."""
        costs = {aid.kind: aid.cost_per_s for aid in self.allowed}
        return [
            {
                "kind": kind, "is_allowed": kind in costs, "used_s": self.used_s.get(kind, 0.0),
                "cost_per_s": costs.get(kind, 0.0), "cost": costs.get(kind, 0.0) * self.used_s.get(kind, 0.0),
            }
            for kind in dict.fromkeys((*costs, *self.used_s))
        ]  # fmt: skip

    def outside_acts(self) -> list[dict[str, Any]]:
        """Return the outside acts, in order."""
        return [act._asdict() for act in self.acts]
