"""Coverage: survey a plot of the bed by sonar; the observation includes a map of the surveyed cells."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict, spread

CELLS, CELL_M = 40, 0.5
PLOT_M = CELLS * CELL_M
DEPTH_M = 3.5
FULL_PAY, STRUCK, DONE = 100.0, -5.0, 10.0
ENOUGH = 0.95
LOST_M = 4.0  # an episode ends this far outside the plot
CLIMB_1_M, DAMP_S_M = 2.0, 2.0  # gains of the depth control


class Coverage(Task):
    """Survey a plot of 20 x 20 m with a tilted sonar. Actions set surge, sway and yaw; depth is kept at 3.5 m.

    The map is an image (1, 40, 40): 255 for surveyed cells of 0.5 m; rows from south to north, columns from west to
    east. Start: in the plot, with any heading. Reward per step: 100 x the newly surveyed share of the plot, except for
    the first ping; 10 on reaching 95 %, -5 for a collision. Termination: 95 % surveyed, a collision, or 4 m outside the
    plot.
    """

    scenario = PACKAGED / "plot.yaml"
    period_s = 0.2
    duration_s = 180.0
    axes = ("surge", "sway", "yaw")
    draws = 3
    pings = True
    goal_fields = (
        Field("position_plot", 2, 2.0, "1", "from the plot's centre, east and north, in halves of its side"),
        Field("heading", 2, 1.0, "1", "cosine and sine of the angle from east, counter-clockwise"),
    )

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        self._seen = np.zeros((batch.n, CELLS, CELLS), np.bool_)
        self._count = np.zeros(batch.n, np.intp)

    @property
    def observation_space(self) -> Space[Any]:
        """The Gymnasium space of the vehicle's state and the map."""
        return Dict({"state": super().observation_space, "map": Box(0, 255, (1, CELLS, CELLS), np.uint8)})

    def efforts(self, actions: Floats, now: Motion) -> Floats:
        """Return the efforts of the actions, plus a heave effort that maintains the depth."""
        efforts = super().efforts(actions, now)
        up_m_s = np.einsum("ni,ni->n", now.up_body, now.velocity_body[:, :3])
        efforts[:, 2] = np.clip(CLIMB_1_M * (-DEPTH_M - now.position_world_m[:, 2]) - DAMP_S_M * up_m_s, -1.0, 1.0)
        return efforts

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin at random positions in the plot, with empty maps."""
        self._seen[members] = False
        self._count[members] = 0
        places = spread(draws[:, :2], -0.4 * PLOT_M, 0.4 * PLOT_M)
        depth_m = np.full(len(members), -DEPTH_M)
        return Start(np.column_stack([places, depth_m]), spread(draws[:, 2], -math.pi, math.pi))

    def goal(self, now: Motion) -> Floats:
        """Return position and heading."""
        return np.concatenate([now.position_world_m[:, :2] / (0.5 * PLOT_M), now.heading], axis=1)

    def observe(self, now: Motion, actions: Floats) -> Any:
        """Ping, and return state and map."""
        self._mark_seen()
        seen = np.where(self._seen[:, None], np.uint8(255), np.uint8(0))
        return {"state": super().observe(now, actions), "map": seen}

    def _mark_seen(self) -> None:
        """Mark the cells that contain an echo."""
        ping = self.batch.ping(self.vehicle)
        turn, place = ping.world_from_sonar[:, :2, :3], ping.world_from_sonar[:, None, :2, 3]
        points = np.nan_to_num(ping.points_sonar_m) @ turn.transpose(0, 2, 1) + place
        cells = np.floor(points / CELL_M).astype(np.intp) + CELLS // 2
        inside = ping.valid & ((cells >= 0) & (cells < CELLS)).all(axis=2)
        members, _ = np.nonzero(inside)
        columns, rows = cells[inside].T
        self._seen[members, rows, columns] = True

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding newly surveyed cells."""
        count = self._seen.sum(axis=(1, 2))
        share = count / CELLS**2
        done, struck = share >= ENOUGH, now.collisions > 0
        reward = FULL_PAY / CELLS**2 * (count - self._count) + DONE * done + STRUCK * struck
        self._count = count
        outside = (np.abs(now.position_world_m[:, :2]) > 0.5 * PLOT_M + LOST_M).any(axis=1)
        return Verdict(reward, done | struck | outside, {"seen_share": share, "success": done})
