"""Conduct: what was done in an attempt at an exercise besides steering: the pilot's acts, outside acts, and aids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from uwsim.channels.authority.rights import AidKind
from uwsim.exercises.exercise import Aid

ACTS_MAX = 1000
AGAIN_S = 1.0  # an act repeated within this time is listed once
UNLISTED = ("aim", "aim_camera")  # sent several times a second while a key is held


class OutsideAct(NamedTuple):
    """Something done by another than the pilot. time_s: since the beginning. changed: whether it changed the world."""

    time_s: float
    by: str
    text: str
    changed: bool


class PilotAct(NamedTuple):
    """A command to the vehicle other than an effort, such as a lamp's switch. time_s: since the beginning."""

    time_s: float
    text: str


@dataclass
class Conduct:
    """The acts and the aids of one attempt.

    allowed: the aids that the exercise allows. acts: those of others than the pilot. pilot_acts: commands to the
    vehicle. omitted, pilot_omitted: the numbers of acts beyond ACTS_MAX, which are only counted.
    """

    allowed: Sequence[Aid]
    acts: list[OutsideAct] = field(default_factory=list)
    omitted: int = 0
    pilot_acts: list[PilotAct] = field(default_factory=list)
    pilot_omitted: int = 0
    _last: dict[str, float] = field(default_factory=dict)
    used_s: dict[AidKind, float] = field(default_factory=dict)
    _changed_by: list[str] = field(default_factory=list)
    _other_pilots: list[str] = field(default_factory=list)

    def note(self, act: OutsideAct) -> None:
        """Add an outside act."""
        if act.changed and act.by not in self._changed_by:
            self._changed_by.append(act.by)
        if len(self.acts) < ACTS_MAX:
            self.acts.append(act)
        else:
            self.omitted += 1

    def note_command(self, time_s: float, name: str, text: str) -> None:
        """Add a command to the vehicle, unless it repeats one by less than AGAIN_S."""
        if name in UNLISTED:
            return
        again_s, is_full = time_s - self._last.get(text, -AGAIN_S), len(self.pilot_acts) >= ACTS_MAX
        if text in self._last or not is_full:
            self._last[text] = time_s
        if 0.0 <= again_s < AGAIN_S:  # negative if time was set back
            return
        if is_full:
            self.pilot_omitted += 1
        else:
            self.pilot_acts.append(PilotAct(time_s, text))

    def note_pilot(self, name: str) -> None:
        """Note that another person than the one who began has the controls."""
        if name not in self._other_pilots:
            self._other_pilots.append(name)

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
        reasons += [f"{name} had the controls, too" for name in self._other_pilots]
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

    def listed(self) -> dict[str, Any]:
        """Return all acts in order, as in the score sheet."""
        return {
            "acts": [act._asdict() for act in self.pilot_acts], "acts_omitted": self.pilot_omitted,
            "outside_acts": [act._asdict() for act in self.acts], "outside_acts_omitted": self.omitted,
        }  # fmt: skip
