"""The orders of IHO S-44 that a survey's soundings meet: by their own uncertainties, and by the true bed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.mapping.ranging import CONFIDENCE as VERTICAL_95
from uwsim.mapping.ranging import HORIZONTAL_CONFIDENCE as HORIZONTAL_95
from uwsim.scoring.s44 import CONFIDENCE, ORDERS, Order
from uwsim.scoring.true_surface import TERRAIN_LABEL

MARGIN_M = 1.0  # rays start this far above the world's highest point


class SoundingQuality:
    """Counts the soundings of consecutive pings that are within the limits of each order.

    Only soundings over terrain are judged: on an obstacle, depth changes by more than any order allows within a
    horizontal error that it allows. stated: those of them with an uncertainty; count: all that are judged.
    """

    def __init__(self, world: _core.World, rays: _core.RayScene) -> None:
        self._world, self._rays = world, rays
        top_m = world.highest_m
        self._top_m = (top_m if np.isfinite(top_m) else 0.0) + MARGIN_M
        self.count = self.stated = self._kept = 0
        self._by_tpu, self._by_truth = np.zeros(len(ORDERS), np.int64), np.zeros(len(ORDERS), np.int64)

    def add(self, soundings_world_m: Floats, vertical_m: Floats, horizontal_m: Floats) -> None:
        """Count a ping: soundings (n, 3), and their standard deviations (n,), nan or 0 where unknown."""
        seen = np.isfinite(soundings_world_m).all(axis=1)
        points, vertical, horizontal = soundings_world_m[seen], vertical_m[seen], horizontal_m[seen]
        bed_m = np.asarray(self._world.height_at(points[:, :2]), np.float64)
        judged = np.isfinite(bed_m) & self._is_terrain(points)
        points, bed_m, tvu, thu = (
            points[judged], bed_m[judged], VERTICAL_95 * vertical[judged], HORIZONTAL_95 * horizontal[judged]
        )  # fmt: skip
        error, depth, known = np.abs(points[:, 2] - bed_m), -bed_m, np.isfinite(tvu) & (tvu > 0.0)
        self.count += len(points)
        self.stated += int(known.sum())
        self._kept += int((error <= tvu)[known].sum())
        for k, order in enumerate(ORDERS):
            allowed_m = order.tvu_m(depth)
            self._by_truth[k] += int((error <= allowed_m).sum())
            self._by_tpu[k] += int((known & (tvu <= allowed_m) & (thu <= order.thu_m(depth))).sum())

    def _is_terrain(self, points: Floats) -> NDArray[np.bool_]:
        origins = np.column_stack([points[:, :2], np.full(len(points), self._top_m)])
        down = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
        reach_m = self._top_m - min(0.0, float(self._world.lowest_m)) + MARGIN_M
        found = self._rays.cast(origins, down, reach_m)
        return np.asarray(np.isfinite(found.ranges_m) & (found.labels == TERRAIN_LABEL))

    @property
    def by_tpu(self) -> Order | None:
        """The strictest order whose TVU and THU 95 % of the soundings meet by their own uncertainties."""
        return _met(self._by_tpu, self.stated)

    @property
    def by_truth(self) -> Order | None:
        """The strictest order whose TVU 95 % of the soundings meet by their distance to the true bed below them."""
        return _met(self._by_truth, self.count)

    @property
    def within_own(self) -> float:
        """Share of soundings whose true error is within their own TVU; near 0.95 if it is right, nan if unknown."""
        return self._kept / self.stated if self.stated else float("nan")

    def rows(self) -> list[tuple[str, str]]:
        """Return rows of (name, value) for a table."""
        from uwsim.scoring.score_text import percentage

        own = "-" if not self.stated else _name(self.by_tpu)
        return [
            ("soundings over terrain", f"{self.count:,}"),
            ("S-44 order of the soundings by TPU", own),
            ("S-44 order of the soundings by truth", _name(self.by_truth) if self.count else "-"),
            ("soundings within their own TVU", percentage(self.within_own)),
        ]

    def values(self) -> dict[str, Any]:
        """Return the same by name for JSON, with the shares for each order."""
        shares = {
            order.name.lower(): {
                "by_tpu": float(self._by_tpu[k] / self.stated) if self.stated else None,
                "by_truth": float(self._by_truth[k] / self.count) if self.count else None,
            }
            for k, order in enumerate(ORDERS)
        }
        return {
            "count": self.count,
            "with_uncertainty": self.stated,
            "s44_order_by_tpu": self.by_tpu.name if self.by_tpu is not None else None,
            "s44_order_by_truth": self.by_truth.name if self.by_truth is not None else None,
            "s44_shares": shares,
            "share_within_own_tvu": self.within_own if self.stated else None,
        }


def _met(counts: NDArray[np.int64], of: int) -> Order | None:
    return next((order for order, count in zip(ORDERS, counts, strict=True) if of and count >= CONFIDENCE * of), None)


def _name(order: Order | None) -> str:
    return "none" if order is None else order.name
