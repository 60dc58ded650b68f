"""Computes the share of a modem's time taken up by the pings of instruments that share the modem."""

from __future__ import annotations

from uwsim import _core
from uwsim.link.rates import airtime_s
from uwsim.scenario.spec.link import Access, ModemModel
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.sensor_kind import sensor_kind
from uwsim.simulator.simulator import Simulator


def ranging_share(sim: Simulator, vehicle: str, modem: ModemModel, access: Access, nodes: int) -> float:
    """Return the share of time for which a vehicle's pings occupy its modem, with one ping at a time per instrument."""
    mounts = next(entry.model.sensors for entry in sim.parameters.scenario.vehicles if entry.name == vehicle)
    cost_s = airtime_s(modem, access, _core.RANGING_PING_BYTES)
    turns_s = nodes * (modem.slot_s + modem.guard_s)
    exchange_s = turns_s if access == "tdma" else 2.0 * cost_s
    shared = [mount for mount in mounts.values() if _shares_modem(mount)]
    return sum(min(mount.rate_hz or 1.0 / sim.step_s, 1.0 / exchange_s) * cost_s for mount in shared)


def _shares_modem(mount: SensorMount) -> bool:
    known = sensor_kind(mount.kind).parameters.get("shares_modem")
    return known is not None and bool(mount.parameters.get("shares_modem", (known.by_default,))[0])
