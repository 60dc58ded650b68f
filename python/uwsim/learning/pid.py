"""The PID controller from the vehicle file as a policy, for comparison with learned policies."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import BatchController
from uwsim.learning.episodes import Episodes

Floats = NDArray[np.float64]


class Pid:
    """Holds a position (3,) and heading in all members with the control loops in the vehicle file; see `Controller`.

    Like a policy, it acts once per period. It receives the true motion.
    """

    def __init__(self, episodes: Episodes, place_world_m: Floats, heading_rad: float = 0.0) -> None:
        self._controller = BatchController(episodes.batch, episodes.period_s)
        self._place, self._heading = place_world_m, heading_rad

    def __call__(self, observation: Any) -> Floats:
        """Return the efforts of all members, (n, 6). observation: ignored."""
        return self._controller.hold_efforts(self._place, self._heading)
