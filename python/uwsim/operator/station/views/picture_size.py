"""Chooses the largest picture size at which a stream maintains its rate under the machine's current load."""

from __future__ import annotations

SHARES = (1.5, 1.0, 0.75, 0.5)  # of the camera's width
USUAL = SHARES.index(1.0)
"""The share at the start; larger pictures, at HASTE times the rate, are shown where the machine has room for them."""
HASTE = 1.5
TOO_LONG, SHORT = 0.8, 0.65  # fractions of a period: above the first, shrink; below the second, try a larger size
SMOOTHING = 0.25
LEAST_PICTURES = 4  # minimum number before the size changes; the first picture fills caches
LEAST_BEHIND = 15  # the same while the steps are behind: longer than the time over which their pace is measured
PATIENCE, PATIENCE_MAX = 20, 640  # pictures before a larger size is tried; doubled after each failure


class Fit:
    """Chooses the fraction of the full width from rendering times, which are proportional to the number of pixels."""

    def __init__(self) -> None:
        self._step = USUAL
        self._patience = PATIENCE
        self._has_grown = False
        self._pictures, self._took_s = 0, 0.0  # at the current size

    @property
    def share(self) -> float:
        """Fraction of the full width, in (0, 1.5]."""
        return SHARES[self._step]

    @property
    def is_large(self) -> bool:
        """True for pictures that are larger than the camera's, and more frequent."""
        return self._step < USUAL

    def note(self, took_s: float, period_s: float, *, has_room: bool = False, is_behind: bool = False) -> None:
        """Record how long a picture at the current size took, and choose the size of the next one.

        period_s: of pictures of the usual size. has_room: whether larger pictures would slow nothing else. is_behind:
        whether the steps do not reach the requested speed; pictures then leave them the processor.
        """
        period_s = period_s / HASTE if self.is_large else period_s
        self._pictures += 1
        self._took_s = took_s if self._pictures <= 2 else self._took_s + SMOOTHING * (took_s - self._took_s)
        if self._pictures < LEAST_PICTURES:
            return
        must_shrink = self._took_s > TOO_LONG * period_s or (self.is_large and not has_room)
        must_shrink = must_shrink or (is_behind and self._pictures >= LEAST_BEHIND)
        if must_shrink and self._step < len(SHARES) - 1:
            if self._has_grown:
                self._patience = min(2 * self._patience, PATIENCE_MAX)
            self._turn(1)
        elif not is_behind and self._pictures >= self._patience and self._step > (0 if has_room else USUAL):
            growth = (SHARES[self._step - 1] / self.share) ** 2
            if growth * self._took_s < SHORT * (period_s / HASTE if self._step == USUAL else period_s):
                self._turn(-1)

    def _turn(self, steps: int) -> None:
        self._step += steps
        self._has_grown = steps < 0
        self._pictures, self._took_s = 0, 0.0
