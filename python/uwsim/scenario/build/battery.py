"""A vehicle's battery as the core's BatterySpec."""

from __future__ import annotations

from uwsim import _core
from uwsim.scenario.spec.battery import BatterySetup


def battery_spec(setup: BatterySetup) -> _core.BatterySpec:
    """Return the spec of a battery's cells and its constant load."""
    spec, cells = _core.BatterySpec(), setup.model
    spec.capacity_ah = cells.capacity_ah
    spec.charges, spec.open_circuit_v = map(list, zip(*cells.open_circuit_v, strict=True))
    spec.resistance_ohm = cells.resistance_ohm
    spec.cutoff_v = cells.cutoff_v
    spec.hotel_w = setup.hotel_w
    spec.initial_charge = setup.initial_charge
    return spec
