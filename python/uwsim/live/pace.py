"""The pace of a live simulator: determines when steps are due, and measures how well the simulator keeps up."""

from __future__ import annotations

import math
from collections import deque
from typing import Literal

from uwsim.base.arguments import is_number

Speed = float | Literal["max"]

SLIP_S = 0.25
"""Longest delay that is made up for; beyond it the schedule slips, and simulated time stays behind."""
REST_S = 0.02
"""Maximum age of values read without a request. Steps that nothing waits for are made in batches."""
WINDOW_S, MARK_S = 1.0, 0.1  # the achieved factor is measured over about WINDOW_S, with a mark every MARK_S
BATCH_S = 1e-3  # target duration of a batch of steps, which is the longest wait of a command
BATCH_STEPS_MAX = 10_000


class Pace:
    """The schedule of steps at a given speed: simulated seconds per wall second, or "max".

    All now_s arguments are times on the same monotonic clock. lateness_s: the largest delay of a step relative to its
    schedule or, if that is later, to the time until which it was allowed to wait. slipped_s: total wall time by which
    the schedule has slipped. factor: speed achieved over the last second.
    """

    def __init__(self, speed: Speed, step_s: float) -> None:
        self.speed = checked_speed(speed)
        self.lateness_s = 0.0
        self.slipped_s = 0.0
        self._step_s = step_s
        self._start_s = math.nan  # wall time at which the schedule starts; nan: at the next step
        self._steps = 0  # steps made since then
        self._rest_s = -math.inf  # wall time until which steps may wait, because nothing needs them earlier
        self._step_cost_s = 1e-5
        self._marks: deque[tuple[float, float]] = deque()  # (wall time, simulated time made until then)
        self._made_s = 0.0

    @property
    def factor(self) -> float:
        """The simulated seconds per wall second during the last second of running, or 0 before the first step."""
        if len(self._marks) < 2 or self._marks[-1][0] <= self._marks[0][0]:
            return 0.0
        (first_s, made_first_s), (last_s, made_last_s) = self._marks[0], self._marks[-1]
        return (made_last_s - made_first_s) / (last_s - first_s)

    def restart(self) -> None:
        """Restart the schedule at the next step, after a pause or a jump in time."""
        self._start_s, self._rest_s = math.nan, -math.inf
        self._marks.clear()

    def set_speed(self, speed: Speed) -> None:
        """Change the speed. Raises ValueError and changes nothing if it is invalid."""
        self.speed = checked_speed(speed)
        self.restart()

    def forget_delays(self) -> None:
        """Restart the measurement of lateness and slip."""
        self.lateness_s = self.slipped_s = 0.0

    def due(self, now_s: float) -> int:
        """Return the number of steps to make now, at most a batch; 0 if none is due yet."""
        if math.isnan(self._start_s):
            self._start_s, self._steps = now_s, 0
        if self.speed == "max":
            return self.batch
        late_s = now_s - self._due_s
        if late_s < 0:
            return 0
        self.lateness_s = max(self.lateness_s, min(late_s, now_s - self._rest_s))
        if late_s > SLIP_S:
            self._start_s += late_s
            self.slipped_s += late_s
            late_s = 0.0
        return min(self.batch, 1 + int(late_s * self.speed / self._step_s))

    def wait_s(self, now_s: float, steps: int | None) -> float:
        """Return the wall time until steps must be made, which is zero or less if they are due.

        steps: the number of steps until a reading, alarm or similar is due, or None if nothing is due. All steps within
        REST_S may be made together, since waking up costs more than stepping.
        """
        if self.speed == "max" or math.isnan(self._start_s):
            return 0.0
        resting = max(1, int(REST_S * self.speed / self._step_s))
        together = resting if steps is None else min(steps, resting)
        self._rest_s = self._due_s + (together - 1) * self._step_s / self.speed
        return self._rest_s - now_s

    @property
    def batch(self) -> int:
        """The number of steps made together, lasting about BATCH_S."""
        return min(max(1, int(BATCH_S / self._step_cost_s)), BATCH_STEPS_MAX)

    def made(self, steps: int, began_s: float, now_s: float) -> None:
        """Record that `steps` were made from began_s to now_s."""
        self._steps += steps
        self._step_cost_s += 0.2 * ((now_s - began_s) / steps - self._step_cost_s)
        if not self._marks:
            self._marks.append((began_s, self._made_s))
        self._made_s += steps * self._step_s
        if now_s - self._marks[-1][0] >= MARK_S or len(self._marks) == 1:
            self._marks.append((now_s, self._made_s))
        while len(self._marks) > 2 and now_s - self._marks[0][0] > WINDOW_S:
            self._marks.popleft()

    @property
    def _due_s(self) -> float:
        """Wall time at which the next step is due."""
        assert self.speed != "max"
        return self._start_s + self._steps * self._step_s / self.speed


def checked_speed(speed: Speed) -> Speed:
    """Return the speed as a float or "max". Raises ValueError if it is invalid."""
    if isinstance(speed, str) and speed == "max":
        return "max"
    if not is_number(speed) or not 1e-3 <= speed <= 1e6:
        raise ValueError(f"speed = {speed!r:.60}: must be a factor in [0.001, 1000000], or 'max'")
    return float(speed)
