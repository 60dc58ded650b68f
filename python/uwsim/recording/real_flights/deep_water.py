"""A vehicle alone in still water, deep or, of a boat, at the surface: what its motion depends on, and nothing else."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

from uwsim.scenario import Scenario, VehicleModel
from uwsim.scenario.build.hull import floating_height_m, is_boat
from uwsim.scenario.build.vehicle import completed

VEHICLE = "vehicle"
DEPTH_M, BED_M = 400.0, 1000.0
WITHOUT: dict[str, Any] = {"sensors": {}, "sonar": None, "imaging_sonars": {}, "cameras": {}}
STEP_S, BOAT_STEP_S = 0.005, 0.02
"""The longer one is for the many simulations of an identification: a hull that the surface cuts takes 10 us a step."""
BOX = (
    (1, 2, 4), (1, 4, 3), (5, 8, 6), (5, 7, 8), (1, 6, 2), (1, 5, 6),
    (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4),
)  # fmt: skip
"""The triangles of a box, outward, with its corners in binary order."""


def in_deep_water(model: VehicleModel, density_kg_m3: float, folder: Path, step_s: float = STEP_S) -> Scenario:
    """Return the scenario, in which a boat starts afloat, others at DEPTH_M. folder: for the hull, read again later."""
    if is_boat(model, density_kg_m3):
        body, height_m = model.model_copy(update=WITHOUT), floating_height_m(model, density_kg_m3)
    else:
        body, height_m = _bare(model, density_kg_m3, folder), -DEPTH_M
    return Scenario.model_validate(
        {
            "name": "deep_water",
            "step_s": step_s,
            "water": {"density_kg_m3": density_kg_m3},
            "terrain": {"source": "noise", "size_m": [1000, 1000], "spacing_m": 100, "bed_depth_m": BED_M},
            "station": {"position_m": [0, 0, 0]},
            "vehicles": [
                {
                    "name": VEHICLE,
                    "model": body,
                    "start": {"position_m": [0, 0, height_m]},
                }
            ],
        }
    )


def start_m(alone: Scenario) -> tuple[float, float, float]:
    """Return where the vehicle of such a scenario starts."""
    start = alone.vehicles[0].start
    assert start is not None and start.position_m is not None
    return start.position_m


def _bare(model: VehicleModel, density_kg_m3: float, folder: Path) -> VehicleModel:
    """Return the vehicle without instruments, and with a box of its volume for its hull.

    Deep under water, only the volume of a hull and its centre matter.
    """
    completed_model, _ = completed(model, density_kg_m3)
    volume_m3, centre_m = completed_model.volume_m3, completed_model.centre_of_buoyancy_m
    assert volume_m3 is not None and centre_m is not None
    side_m = volume_m3 ** (1 / 3)
    corners = [
        [c + side_m * (bit - 0.5) for c, bit in zip(centre_m, bits, strict=True)] for bits in product((0, 1), repeat=3)
    ]
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in BOX]
    path = folder / "box.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    update = {**WITHOUT, "trim": None, "mesh": path, "mesh_scale": 1.0, "mesh_up": None, "mesh_forward": None}
    update |= {"collision": "hull", "collision_pieces": None}
    return completed_model.model_copy(update=update)
