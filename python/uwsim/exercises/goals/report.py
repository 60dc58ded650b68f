"""The goal `report`: a note reports what is at a place."""

from __future__ import annotations

import math
from typing import Literal

from uwsim.base.commands.notes import NoteCategory
from uwsim.exercises.goal import GoalModel, Progress, Within
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import Point3


class _Reporting(Progress):
    def judge(self, moment: Moment, period_s: float) -> None:
        away_m = [
            math.dist(place, self._goal.position_m)
            for note in moment.notes(self._goal.category)
            if (place := note.values["position_world_m"]) is not None
        ]
        if away_m and min(away_m) <= self._goal.within_m:
            self.note(moment.time_s, min(away_m))
            self.share = 1.0


class Report(GoalModel):
    """Report what is at a place by writing a note, either at the station or with the command `note`.

    position_m: position in the world. within_m: how close to it the note must be placed. category: the note's category.
    """

    progress = _Reporting

    kind: Literal["report"]
    position_m: Point3
    within_m: Within = 3.0
    category: NoteCategory = "defect"
