"""The law of thrust `knee`: a motor whose current is limited."""

from typing import Annotated, Literal

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.spec.actuator import ThrustLaw
from uwsim.scenario.spec.fields import InRange


class Knee(ThrustLaw):
    """Thrust that grows with the command up to 0.8 of it.

    most_n: the thrust there and beyond.
    """

    kind: Literal["knee"]
    most_n: Annotated[float, InRange(0, 1e6, "N")]

    def thrusts_n(self, commands: Floats) -> Floats:
        """Return the thrust at each command."""
        return self.most_n * np.clip(commands / 0.8, -1.0, 1.0)
