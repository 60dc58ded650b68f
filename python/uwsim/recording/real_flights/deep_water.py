"""A vehicle alone in deep, still water, far from both surface and bed: what its motion depends on, and nothing else."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

from uwsim.scenario import Scenario, VehicleModel
from uwsim.scenario.build.hull import rigid_body

VEHICLE = "vehicle"
DEPTH_M, BED_M = 400.0, 1000.0
STEP_S = 0.005
BOX = (
    (1, 2, 4), (1, 4, 3), (5, 8, 6), (5, 7, 8), (1, 6, 2), (1, 5, 6),
    (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4),
)  # fmt: skip
"""The triangles of a box, outward, with its corners in binary order."""


def in_deep_water(model: VehicleModel, density_kg_m3: float, folder: Path) -> Scenario:
    """Return the scenario. folder: for the hull, which is read again later."""
    body = _bare(model, density_kg_m3, folder)
    return Scenario.model_validate(
        {
            "name": "deep_water",
            "step_s": STEP_S,
            "water": {"density_kg_m3": density_kg_m3},
            "terrain": {"source": "noise", "size_m": [1000, 1000], "spacing_m": 100, "bed_depth_m": BED_M},
            "station": {"position_m": [0, 0, 0]},
            "vehicles": [
                {
                    "name": VEHICLE,
                    "model": body,
                    "start": {"position_m": [0, 0, -DEPTH_M]},
                }
            ],
        }
    )


def completed(model: VehicleModel, density_kg_m3: float) -> tuple[VehicleModel, tuple[str, ...]]:
    """Return a vehicle that states its volume, centre of buoyancy and inertia, and the keys that were added.

    What its file does not state is that of its hull, in water of this density.
    """
    body = rigid_body(model, density_kg_m3)
    own = {
        "volume_m3": body.volume_m3,
        "centre_of_buoyancy_m": tuple(map(float, body.centre_of_buoyancy_m)),
        "inertia_kg_m2": tuple(map(float, body.inertia_kg_m2)),
    }
    added = {key: value for key, value in own.items() if getattr(model, key) is None}
    return model.model_copy(update=added), tuple(added)


def double_integrator(model: VehicleModel, density_kg_m3: float) -> VehicleModel:
    """Return the simplest model of a vehicle: its masses and thrusters, neutral, without drag, lift and righting."""
    whole, _ = completed(model, density_kg_m3)
    return whole.model_copy(
        update={
            "linear_damping": (0.0,) * 6,
            "quadratic_damping": (0.0,) * 6,
            "linear_damping_matrix": None,
            "quadratic_damping_matrix": None,
            "munk_share": 0.0,
            "fins": {},
            "buoyancy": "neutral",
            "mass_kg": None,
            "centre_of_buoyancy_m": whole.centre_of_mass_m,
        }
    )


def _bare(model: VehicleModel, density_kg_m3: float, folder: Path) -> VehicleModel:
    """Return the vehicle without instruments, and with a box of its volume for its hull.

    Deep under water, only the volume of a hull and its centre matter.
    """
    update: dict[str, Any] = {"sensors": {}, "sonar": None, "imaging_sonars": {}, "cameras": {}, "trim": None}
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
    update |= {"mesh": path, "mesh_scale": 1.0, "mesh_up": None, "mesh_forward": None}
    update |= {"collision": "hull", "collision_pieces": None}
    return completed_model.model_copy(update=update)
