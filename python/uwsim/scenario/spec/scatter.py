"""`scatter` of an entry under `objects:`: copies of a loose body at random places, such as debris."""

from __future__ import annotations

from typing import Annotated, cast

import numpy as np

from uwsim.scenario.spec.fields import InRange, Model
from uwsim.scenario.spec.obstacle import Bed, Placed

TRIES = 1000
Side = Annotated[float, InRange(0.1, 1e5, "m")]


class Scatter(Model):
    """Copies of a loose body, with the names NAME_1, NAME_2 and so on, in a rectangle about its position.

    per_100_m2: how many per 100 square metres, in all rounded to whole bodies. area_m: edges of the rectangle along the
    world's x and y. apart_m: least distance between two positions; by default, that at which they cannot meet whatever
    their headings. seed: of places and headings, which do not depend on the scenario's seed.
    """

    per_100_m2: Annotated[float, InRange(1e-4, 1e4)]
    area_m: tuple[Side, Side]
    apart_m: Annotated[float, InRange(0, 1e4, "m")] | None = None
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    @property
    def count(self) -> int:
        """How many bodies there are."""
        return round(0.01 * self.per_100_m2 * self.area_m[0] * self.area_m[1])

    def places(self, shape: Placed) -> list[tuple[float, float, float]]:
        """Return x, y [m] and heading [deg] of each copy of an obstacle; none if they do not fit."""
        random = np.random.default_rng(self.seed)
        apart_m = 2.0 * _radius_m(shape) if self.apart_m is None else self.apart_m
        half_m = 0.5 * np.array(self.area_m)
        places = np.empty((self.count, 3))
        for index in range(self.count):
            for _ in range(TRIES):
                at_m = shape.position_m[:2] + random.uniform(-half_m, half_m)
                if (np.linalg.norm(places[:index, :2] - at_m, axis=1) >= apart_m).all():
                    break
            else:
                return []
            places[index] = *at_m, random.uniform(0.0, 360.0)
        return [(x_m, y_m, heading_deg) for x_m, y_m, heading_deg in places.tolist()]


def _radius_m(shape: Placed) -> float:
    """Return how far an obstacle extends horizontally from its position."""
    vertices = shape.solid(cast(Bed, None)).vertices  # a shape that is placed uses no terrain
    return float(np.linalg.norm(vertices[:, :2] - np.asarray(shape.position_m)[:2], axis=1).max())
