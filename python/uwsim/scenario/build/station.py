"""The station in the world frame, and what begins there: starts of vehicles, tethers, and the link, as core objects."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.quaternions import about_z, turned
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_file import Triangles, Vertices, load_mesh
from uwsim.scenario.spec.link import BOTTOMS, LinkSetup, ModemModel
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.settings import Station
from uwsim.scenario.spec.tether import Anchor, BodyAnchor, Tethered
from uwsim.scenario.spec.vehicle_entry import VehicleEntry

EXIT_M = 3.0  # default distance from the dock forward to the exit


def carrier_index(scenario: Scenario) -> int | None:
    """Return the index of the vehicle that carries the station, or None."""
    carrier = scenario.station.carrier
    return None if carrier is None else [vehicle.name for vehicle in scenario.vehicles].index(carrier)


def station_at_start(scenario: Scenario) -> Station:
    """Return the station where it is at the start, in the world frame."""
    station, index = scenario.station, carrier_index(scenario)
    start = None if index is None else scenario.vehicles[index].start
    if start is None:
        return station
    x, y, z = turned(about_z(math.radians(start.yaw_deg)), station.position_m) + np.asarray(start.position_m)
    moved = {"carrier": None, "position_m": (float(x), float(y), float(z)), "yaw_deg": start.yaw_deg + station.yaw_deg}
    return station.model_copy(update=moved)


def dock_position(station: Station) -> NDArray[np.float64]:
    """Return the origin of a docked vehicle, (3,), in the world or the carrier's frame."""
    return in_world(station, station.dock_m)


def exit_position(station: Station) -> NDArray[np.float64]:
    """Return the origin of a vehicle just after undocking, (3,), in the world or the carrier's frame."""
    return in_world(station, np.add(station.dock_m, (EXIT_M, 0.0, 0.0)) if station.exit_m is None else station.exit_m)


def in_world(station: Station, point_m: ArrayLike) -> NDArray[np.float64]:
    """Convert points (3,) or (n, 3) from the station's frame to the world's, or to its carrier's if it has one."""
    return turned(about_z(math.radians(station.yaw_deg)), point_m) + np.asarray(station.position_m, np.float64)


def station_mesh(station: Station) -> tuple[Vertices, Triangles]:
    """Return the station's vertices (n, 3), world frame, and triangles (m, 3). The station must have a mesh."""
    assert station.mesh is not None
    vertices, triangles = load_mesh(station.mesh)
    return in_world(station, vertices), triangles


def start_pose(scenario: Scenario, vehicle: VehicleEntry) -> tuple[tuple[float, float, float], float]:
    """Return the vehicle's initial position (world, metres) and yaw (radians), docked or free."""
    if vehicle.start is not None:
        return vehicle.start.position_m, float(np.radians(vehicle.start.yaw_deg))
    station = station_at_start(scenario)
    x, y, z = dock_position(station)
    return (float(x), float(y), float(z)), float(np.radians(station.yaw_deg))


SAME = (
    "length_m", "elements", "diameter_m", "mass_kg_m", "axial_stiffness_n", "bending_stiffness_n_m2",
    "axial_damping_n_s", "normal_drag", "tangential_drag", "normal_added_mass", "tangential_added_mass", "friction",
    "breaking_load_n",
)  # fmt: skip


def tether_specs(scenario: Scenario) -> dict[str, _core.TetherSpec]:
    """Return the core's spec of each tether by the name of its vehicle or object, in order."""
    return {one.name: _spec(scenario, one) for one in scenario.tethered}


def tethered_through(scenario: Scenario, name: str) -> list[str]:
    """Return whose tethers the cable of a vehicle or object goes through: its own, that of its anchor, and so on."""
    tethers = {one.name: one.tether for one in scenario.tethered}
    found: list[str] = []
    while name in tethers and name not in found:
        found.append(name)
        anchor = tethers[name].anchor
        name = anchor.to if isinstance(anchor, BodyAnchor) else ""
    return found


def add_tethers(scenario: Scenario, simulation: _core.Simulation) -> None:
    """Add the tethers to a simulation, after all vehicles and objects. Raises ScenarioError, with its place."""
    file = scenario.source_file
    for one in scenario.tethered:
        try:
            simulation.add_tether(_spec(scenario, one))
        except ValueError as error:
            raise ScenarioError(f"{file.line_prefix(*one.keys, 'tether')}{file.place(*one.keys)}.{error}") from None


def _first_end(scenario: Scenario, anchor: Anchor) -> _core.TetherEnd:
    """Return it. The core's bodies are the vehicles and then the objects."""
    if isinstance(anchor, BodyAnchor):
        bodies = [vehicle.name for vehicle in scenario.vehicles] + [body.name for body in scenario.objects]
        return _core.TetherEnd(anchor.at_m, bodies.index(anchor.to))
    if anchor != "station":
        return _core.TetherEnd(anchor)
    dock_m, carrier = dock_position(scenario.station), carrier_index(scenario)
    return _core.TetherEnd(dock_m) if carrier is None else _core.TetherEnd(dock_m, carrier)


def _spec(scenario: Scenario, one: Tethered) -> _core.TetherSpec:
    spec, tether = _core.TetherSpec(), one.tether
    spec.name = f"tether of '{one.name}'"
    spec.first = _first_end(scenario, tether.anchor)
    spec.second = _core.TetherEnd(tether.at_m, one.body)
    for name in SAME:
        setattr(spec, name, getattr(tether, name))
    if tether.winch is not None:
        spec.longest_m = tether.winch.longest_m
        spec.shortest_m = tether.winch.shortest_m or 0.0
        spec.fastest_m_s = tether.winch.fastest_m_s
        spec.strongest_n = tether.winch.strongest_n
    return spec


KINDS = {"cable": _core.LinkKind.CABLE, "ideal": _core.LinkKind.IDEAL, "modem": _core.LinkKind.MODEM}
ACCESS = {"aloha": _core.MediumAccess.ALOHA, "tdma": _core.MediumAccess.TDMA}
MODULATION = {"psk": _core.Modulation.PSK, "fsk": _core.Modulation.FSK}
AS_THEY_ARE = (
    "latency_s", "packet_bytes", "header_bytes", "preamble_s", "receiver_noise_db_hz", "fading", "coding_gain_db",
    "multipath_window_s", "symbol_s", "speed_max_m_s", "slot_s", "guard_s", "backoff_s", "queue_bytes",
    "retransmissions", "acknowledgement_bytes",
)  # fmt: skip

TRANSDUCER_DEPTH_M = 3.0


def modem_spec(modem: ModemModel, access: str | None = None) -> _core.ModemSpec:
    """Return the modem's parameters. access: overrides the modem's access scheme. Not for modems of kind `none`."""
    spec = _core.ModemSpec()
    spec.kind = KINDS[modem.kind]
    spec.access = ACCESS[access or modem.access]
    spec.modulation = MODULATION[modem.modulation]
    spec.bit_rate_bit_s = modem.bit_rate_bit_s or 0.0
    for key in AS_THEY_ARE:
        setattr(spec, key, getattr(modem, key))
    for key in ("frequency_hz", "bandwidth_hz", "source_level_db"):
        value = getattr(modem, key)
        if value is not None:
            setattr(spec, key, value)
    return spec


def station_transducer(link: LinkSetup, station: Station, world: _core.World) -> NDArray[np.float64]:
    """Return the station's transducer (3,) [m], in the world's or its carrier's frame.

    Raises ScenarioError for one above the water, and for a modem whose station stands on land, with no default.
    """
    if link.station_transducer_m is not None:
        given = in_world(station, link.station_transducer_m)
        if station.carrier is None and given[2] > 0.0:
            x, y, z = link.station_transducer_m
            raise ScenarioError(
                f"link.station_transducer_m = [{x:g}, {y:g}, {z:g}] m: is {given[2]:g} m above the water, since the "
                f"station is at z = {station.position_m[2]:g} m: must be under water",
                at=("link", "station_transducer_m"),
            )
        return given
    x, y, _ = station.position_m
    if station.carrier is not None:
        return np.array([x, y, -TRANSDUCER_DEPTH_M])
    bed_m = float(world.height_at(np.array([[x, y]]))[0])  # NaN beyond the terrain
    if bed_m >= 0.0 and link.modem.kind == "modem":
        raise ScenarioError(
            f"link.modem = {link.modem.name}: the station at ({x:g}, {y:g}) m stands on land, {bed_m:.3g} m above the "
            "water: give link.station_transducer_m, under water",
            at=("link", "modem"),
        )
    return np.array([x, y, min(0.5 * bed_m, 0.0) if bed_m > -TRANSDUCER_DEPTH_M else -TRANSDUCER_DEPTH_M])


def link_spec(link: LinkSetup, station: Station, world: _core.World) -> _core.LinkSpec | None:
    """Return the link, or None if messages are delivered at once. Raises ScenarioError, see `station_transducer`."""
    if link.modem.kind == "none":
        return None
    spec = _core.LinkSpec()
    spec.modem = modem_spec(link.modem, link.access)
    if link.retransmissions is not None:
        spec.modem.retransmissions = link.retransmissions
    spec.station_transducer_world_m = station_transducer(link, station, world)
    spec.wind_m_s = link.wind_m_s
    spec.shipping = link.shipping
    spec.set_bottom(*BOTTOMS[link.bottom])
    spec.faults = [_core.LinkFault(fault.from_s, fault.until_s, fault.loss) for fault in link.faults]
    return spec
