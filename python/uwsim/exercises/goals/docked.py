"""The goal `docked`: the station's dock holds the vehicle."""

from __future__ import annotations

from typing import Literal

from uwsim.exercises.goal import GoalModel
from uwsim.exercises.moment import Moment


class Docked(GoalModel):
    """Dock at the station: `Dock` of the page, or the command `dock`, within the dock's limits of place and speed."""

    kind: Literal["docked"]

    def is_met_at(self, moment: Moment) -> bool:
        """See GoalModel."""
        return not moment.vehicle.released
