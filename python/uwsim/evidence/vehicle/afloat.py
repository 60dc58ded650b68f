"""A vehicle upright at the surface, as its wet triangles are drawn."""

from __future__ import annotations

from typing import NamedTuple

from uwsim.scenario.build.hull import vehicle_hull
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.wet_triangles import WetTriangles

HALVINGS = 50


class Afloat(NamedTuple):
    """wet: the triangles that are under water. water_z_m: height of the surface above the body's origin.

    floats: whether their push balances the weight; otherwise half of the hull's height is under water.
    """

    wet: WetTriangles
    water_z_m: float
    floats: bool


def afloat(sim: Simulator) -> Afloat:
    """Put the first vehicle of a simulator in open water upright where it floats, at rest; it is left there."""
    rov = sim.rov
    vertices, _ = vehicle_hull(sim.scenario.vehicles[0].model)
    low_m, high_m = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    weight_n = -float(rov.forces["weight"].force_body_n[2])

    def at(water_z_m: float) -> WetTriangles:
        rov.place([0.0, 0.0, -water_z_m])
        return rov.wet_triangles()

    def push_n(wet: WetTriangles) -> float:
        return float(wet.forces_body_n[:, 2].sum())

    if push_n(at(high_m)) <= weight_n * (1 + 1e-9):
        half_m = 0.5 * (low_m + high_m)
        return Afloat(at(half_m), half_m, False)
    for _ in range(HALVINGS):
        middle_m = 0.5 * (low_m + high_m)
        low_m, high_m = (low_m, middle_m) if push_n(at(middle_m)) > weight_n else (middle_m, high_m)
    return Afloat(at(high_m), high_m, True)
