"""Track: a line on the bed, and positions along it."""

from __future__ import annotations

import numpy as np

from uwsim.learning.task import Floats


class Track:
    """A polyline through points_m (k, 2). length_m: its total length."""

    def __init__(self, points_m: Floats) -> None:
        self._points = points_m
        steps = np.diff(points_m, axis=0)
        self._lengths = np.linalg.norm(steps, axis=1)
        self._directions = steps / self._lengths[:, None]
        self._begins = np.concatenate([[0.0], np.cumsum(self._lengths)])
        self.length_m = float(self._begins[-1])

    def at(self, along_m: Floats) -> tuple[Floats, Floats]:
        """Return the points (m, 2) at distances (m,) along the line, and the line directions (m, 2) there."""
        piece = np.clip(np.searchsorted(self._begins, along_m, side="right") - 1, 0, len(self._lengths) - 1)
        direction = self._directions[piece]
        return self._points[piece] + (along_m - self._begins[piece])[:, None] * direction, direction

    def nearest(self, places_m: Floats) -> tuple[Floats, Floats]:
        """Return the distances along the line of the points nearest to places (n, 2), and their offsets: (n,) each."""
        away = places_m[:, None] - self._points[None, :-1]
        along = np.clip(np.einsum("nkj,kj->nk", away, self._directions), 0.0, self._lengths)
        apart = np.linalg.norm(away - along[:, :, None] * self._directions, axis=2)
        best = apart.argmin(axis=1)
        rows = np.arange(len(places_m))
        return self._begins[best] + along[rows, best], apart[rows, best]
