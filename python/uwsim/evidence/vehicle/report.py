"""VehicleReport: everything that `uwsim vehicle` measures on a vehicle in open water."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.evidence.vehicle.estimates import Estimates, estimates
from uwsim.evidence.vehicle.figures import VehicleFigures
from uwsim.evidence.vehicle.linear_motion import Mode, model_motion, modes
from uwsim.evidence.vehicle.sheets import beside_makers
from uwsim.evidence.vehicle.trials import TurningCircle, terminal_speeds, turning_circles
from uwsim.evidence.vehicle.views import FieldOfView, fields_of_view
from uwsim.scenario.build.equipment import actuators_spec
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.simulator.simulator import Simulator

COMPARED_AT_M_S = 1.0
RANK_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Allocation:
    """The axes that a vehicle's thrusters and fins drive, and how strongly.

    rank: rank of the thrusters' forces and torques in still water; None without thrusters. rank_without: for each
    thruster, the rank that remains when it fails. full_ahead, full_astern: (6,) the largest wrench on each axis alone
    [N, N m].
    authority: (6,) the acceleration from rest at full effort [m/s2, rad/s2]. Fins are not included, since they need
    forward speed.
    """

    rank: int | None
    rank_without: dict[str, int]
    driven: tuple[str, ...]
    full_ahead: Floats
    full_astern: Floats
    authority: Floats


@dataclass(frozen=True, eq=False)
class VehicleReport:
    """The properties of a vehicle, measured in deep, still, fresh water.

    added_mass, linear_damping, quadratic_damping: (6,) diagonals from its file. estimates: coefficients estimated from
    its hull's shape.
    terminal: (6, 2) speeds at full effort ahead and astern, NaN on axes that nothing drives. motions: the modes, by
    speed ahead [m/s]. circles: turning circles at full yaw. views: its instruments' fields of view. beside_makers: rows
    of what its makers and owners state, see sheets.py.
    """

    model: VehicleModel
    figures: VehicleFigures
    added_mass: Floats
    linear_damping: Floats
    quadratic_damping: Floats
    estimates: Estimates
    terminal: Floats
    circles: tuple[TurningCircle, ...]
    motions: dict[float, tuple[Mode, ...]]
    allocation: Allocation
    views: tuple[FieldOfView, ...]
    beside_makers: tuple[tuple[str, str, str, str, str], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the report for print_json; rays and tracks are left out."""
        left_out = {"model", "views", "circles", "motions"}
        return {
            "vehicle": self.model.name,
            **{field.name: getattr(self, field.name) for field in fields(self) if field.name not in left_out},
            "circles": [{k: v for k, v in asdict(circle).items() if k != "track_m"} for circle in self.circles],
            "modes": [{"speed_m_s": speed, "modes": own} for speed, own in self.motions.items()],
            "own_hull": [{"label": v.label, "share": v.share, "nearest_m": v.nearest_m} for v in self.views],
        }


def vehicle_report(sim: Simulator, figures: VehicleFigures) -> VehicleReport:
    """Return the report on the first vehicle of a simulator in open water. figures: vehicle_figures in its water."""
    entry = sim.scenario.vehicles[0]
    model, density_kg_m3 = entry.model, figures.water_density_kg_m3
    terminal = terminal_speeds(sim.scenario)
    fastest = float(terminal[0, 0])
    speeds = [0.0] if np.isnan(fastest) else [0.0, round(fastest, 2)]
    if figures.metacentric_m is not None:
        speeds = []  # a boat's modes would be those of a submerged hull
    trim = entry.trim or model.trim
    compared_at = COMPARED_AT_M_S if np.isnan(fastest) else fastest
    report = VehicleReport(
        model=model,
        figures=figures,
        added_mass=np.diagonal(model.matrix("added_mass")).copy(),
        linear_damping=np.diagonal(model.matrix("linear_damping")).copy(),
        quadratic_damping=np.diagonal(model.matrix("quadratic_damping")).copy(),
        estimates=estimates(*vehicle_hull(model), figures.hull_gyration_m, density_kg_m3, compared_at),
        terminal=terminal,
        circles=turning_circles(sim.scenario),
        motions={speed: modes(model_motion(model, trim, density_kg_m3, speed)) for speed in speeds},
        allocation=allocation(sim),
        views=fields_of_view(sim),
    )
    return replace(report, beside_makers=tuple(beside_makers(report)))


def allocation(sim: Simulator) -> Allocation:
    """Return the allocation of the first vehicle of a simulator."""
    rov, model = sim.rov, sim.scenario.vehicles[0].model
    thrusters = actuators_spec(model).thrusters
    length_m = max(np.ptp(vehicle_hull(model)[0], axis=0))
    columns = [np.concatenate([t.axis_body, np.cross(t.position_body_m, t.axis_body) / length_m]) for t in thrusters]

    def rank(of: list[Floats]) -> int:
        return int(np.linalg.matrix_rank(np.array(of).T, tol=RANK_TOLERANCE)) if of else 0

    ahead, astern = rov.full_wrench_body
    return Allocation(
        rank=rank(columns) if thrusters else None,
        rank_without={t.name: rank(columns[:k] + columns[k + 1 :]) for k, t in enumerate(thrusters)},
        driven=tuple(axis for axis in AXES if axis in rov.controllable),
        full_ahead=np.array(ahead),
        full_astern=np.array(astern),
        authority=np.array(rov.authority),
    )
