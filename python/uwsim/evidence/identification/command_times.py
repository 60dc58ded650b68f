"""The times at which a log's commands take effect: known up to a common delay and, if sampled, up to the sampling.

A change of the efforts that was logged with its own time takes effect at that time, plus the delay. One that was only
found at a sample lies somewhere between this sample and the previous one: its time is the middle, with the standard
deviation of a uniform distribution. Changes are superposed, so that the motion is a continuous function of each time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.recording.real_flights.deep_water import STEP_S

Indices = NDArray[np.intp]
REACH_S = 2.0  # changes this far outside a segment may still take effect in it: delays and shifts are shorter
MOST_SHIFTS = 40
"""Number of changes in a segment whose times may shift, the largest first; a shift of a small change has no effect."""


@dataclass(frozen=True)
class Segment:
    """The changes of the efforts near one segment of a log.

    first: the efforts (6,) before them, or as many commands of thrusters. ticks (c,): their times, in steps after the
    segment's start. changes (c, 6): the differences. shifting: indices (m,) of those whose times may shift. sd_s (m,):
    by how much.
    """

    first: Floats
    ticks: Floats
    changes: Floats
    shifting: Indices
    sd_s: Floats

    def efforts(self, delay_ticks: int, shift_ticks: NDArray[np.int64], count: int) -> Floats:
        """Return the efforts (count, 2 + m, 6) in each step.

        delay_ticks: by which changes are late; shift_ticks (m,): instead, for those that may shift. Of the efforts, the
        first come at these times; in the second, changes that may not shift come one step later, and in each of the
        others one that may shift. A change within a step enters by its share of the step.
        """
        base = self.ticks + delay_ticks
        base[self.shifting] = self.ticks[self.shifting] + shift_ticks
        fixed = np.ones(len(base))
        fixed[self.shifting] = 0.0
        later = [base, base + fixed, *(base + (np.arange(len(base)) == k) for k in self.shifting)]
        return np.clip(np.stack([self._held(ticks, count) for ticks in later], axis=1), -1.0, 1.0)

    def _held(self, ticks: Floats, count: int) -> Floats:
        low = np.floor(ticks)
        share = (ticks - low)[:, None]
        total = np.zeros((count + 1, self.changes.shape[1]))
        np.add.at(total, np.clip(low, 0, count).astype(int), (1.0 - share) * self.changes)
        np.add.at(total, np.clip(low + 1, 0, count).astype(int), share * self.changes)
        return np.asarray(self.first + np.cumsum(total, axis=0)[:count])


def segment_of(
    times_s: Floats, efforts: Floats, sd_s: Floats, start_s: float, end_s: float, step_s: float = STEP_S
) -> Segment:
    """Return the changes near a segment from the times (n,), efforts (n, 6) and deviations (n,) of a log's commands."""
    near = slice(*np.searchsorted(times_s, (start_s - REACH_S, end_s + REACH_S)))
    first = efforts[near.start - 1] if near.start else np.zeros(efforts.shape[1])
    changes = np.diff(np.vstack([first, efforts[near]]), axis=0)
    kept = np.flatnonzero(changes.any(axis=1))
    changes, times, sd = changes[kept], times_s[near][kept], sd_s[near][kept]
    ticks = (times - start_s) / step_s
    ticks = np.where(np.abs(ticks - np.round(ticks)) < 1e-3, np.round(ticks), ticks)
    may = np.flatnonzero((sd > 0) & (times > start_s - 4 * sd) & (times < end_s + 4 * sd))
    shifting = np.sort(may[np.argsort(-np.abs(changes[may]).sum(axis=1), kind="stable")][:MOST_SHIFTS])
    return Segment(first, ticks, changes, shifting, sd[shifting])
