"""A battery of cells: current drains it, its voltage depends on charge and load, and thrust depends on the voltage."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sites import flat, rov
from uwsim import ScenarioError, Simulator
from uwsim.evidence.validate.reality.thrust import LEFT_OUT, misses, read_sheets, without
from uwsim.scenario.spec.actuator import load_thruster
from uwsim.scenario.spec.battery import load_battery

SHEETS = Path(__file__).parents[4] / "shared/reality/t200/t200_10_14_16_20V.csv"
BATTERY = {"model": "bluerov2_18ah", "hotel_w": 40}


def made(battery: Any = BATTERY, model: str = "bluerov2_heavy", **more: Any) -> Simulator:
    supply = {} if battery is None else {"battery": battery}
    vehicle = rov(model, (0, 0, -20), trim={"net_buoyancy_n": 0}, **supply, **more)
    return Simulator(flat(vehicle, bed_m=-60.0, size_m=400, mission_time_s=5))


def test_a_sheet_that_was_not_used_is_met_where_the_square_of_the_voltage_is_not() -> None:
    if not SHEETS.is_file():
        pytest.skip(f"no {SHEETS}: the T200's sheets are from Blue Robotics' public performance data, September 2019")
    judges = read_sheets(SHEETS)
    for name, miss in misses(without(14.0, judges), 14.0, judges[14.0]).items():
        assert miss < LEFT_OUT[14.0][name], name
    squared = (14.0 / 16.0) ** 2 * judges[16.0]["force_kgf"]
    assert np.sqrt(np.mean((squared - judges[14.0]["force_kgf"]) ** 2)) > LEFT_OUT[14.0]["force_kgf"]


def test_thrust_and_current_are_those_of_the_sheets_at_the_voltage_that_the_battery_has() -> None:
    sim = made(BATTERY | {"initial_charge": 0.4})
    rov, sheets = sim.rov, load_thruster("t200_16v").performance()
    rov.set_thrusters({"front_left": -0.9, "rear_right": 0.6, "vertical_front_left": 0.3})
    sim.advance(2.0)
    battery = rov.battery
    for thruster in rov.thrusters.values():
        thrust_n, current_a, _ = sheets.at(thruster.command, battery.voltage_v)
        assert thruster.thrust_n == pytest.approx(thrust_n, rel=1e-4, abs=1e-9)
        assert thruster.current_a == pytest.approx(current_a, rel=1e-4, abs=1e-9)
    drawn_a = sum(thruster.current_a for thruster in rov.thrusters.values()) + 40.0 / battery.voltage_v
    assert battery.current_a == pytest.approx(drawn_a, rel=1e-9)
    cells = load_battery("bluerov2_18ah")
    charges, volts = zip(*cells.open_circuit_v, strict=True)
    at_rest_v = np.interp(battery.charge_ah / cells.capacity_ah, charges, volts)
    assert battery.voltage_v == pytest.approx(at_rest_v - cells.resistance_ohm * drawn_a, abs=1e-5)


def test_an_idle_vehicle_lasts_as_long_as_its_charge_at_constant_power() -> None:
    sim = made(BATTERY | {"hotel_w": 2000})
    cells = load_battery("bluerov2_18ah")
    charges, volts = map(np.array, zip(*cells.open_circuit_v, strict=True))
    share = np.linspace(1.0, 0.0, 200_001)
    at_rest_v = np.interp(share, charges, volts)
    with np.errstate(invalid="ignore"):  # at low charge, it cannot supply this power
        v = 0.5 * (at_rest_v + np.sqrt(at_rest_v**2 - 4.0 * cells.resistance_ohm * 2000.0))
    lasts = v >= cells.cutoff_v
    expected_s = np.sum(3600.0 * cells.capacity_ah * (share[0] - share[1]) * v[lasts] / 2000.0)
    while sim.rov.battery.percent > 0:
        sim.step()
    assert sim.time_s == pytest.approx(expected_s, abs=0.1)
    assert sim.time_s > sim.scenario.mission_time_s, "which is for vehicles without a battery of cells"


def test_a_vehicle_slows_as_its_battery_drains() -> None:
    def speed_m_s(charge: float) -> float:
        sim = made({"model": "bluerov2_18ah", "initial_charge": charge})
        sim.rov.set_effort(surge=0.8)
        sim.advance(4.0)
        return float(sim.rov.velocity.linear_body_m_s[0])

    full, low = speed_m_s(1.0), speed_m_s(0.1)
    assert 0.6 * full < low < 0.95 * full


def test_an_empty_battery_stops_the_thrusters_until_the_vehicle_has_been_docked() -> None:
    sim = made(BATTERY | {"initial_charge": 0.002})
    rov = sim.rov
    rov.set_effort(surge=0.5)
    sim.advance(2.0)
    assert rov.battery.percent == rov.telemetry().battery_percent == 0.0
    assert rov.battery.current_a == 0.0 and rov.battery.charge_ah > 0.0
    assert all(thruster.current_a == 0.0 for thruster in rov.thrusters.values())
    rov.place((0.0, 0.0, -2.0))
    rov.dock()
    rov.release()
    assert rov.battery.percent == 100.0
    rov.set_effort(surge=0.5)
    sim.advance(1.0)
    assert rov.battery.current_a > 5.0


def test_without_a_battery_the_mission_time_counts_as_before() -> None:
    sim = made(None)
    sim.rov.set_effort(surge=0.5)
    sim.advance(2.5)
    battery = sim.rov.battery
    assert battery.percent == pytest.approx(50.0) and math.isnan(battery.voltage_v) and math.isnan(battery.charge_ah)
    assert sim.rov.thrusters["front_left"].current_a == 0.0


def test_a_low_battery_calls_the_failsafe_and_a_sagging_one_is_no_thruster_fault() -> None:
    failsafe = {"battery_percent": 10, "battery_then": "surface", "thruster_then": "hold"}
    sim = made({"model": "bluerov2_18ah", "initial_charge": 0.12}, failsafe=failsafe)
    sim.rov.set_thrusters({"front_left": -1.0, "rear_right": 1.0})
    while sim.rov.battery.percent >= 10.0:
        assert sim.rov.failsafe.state == ""
        sim.advance(1.0)
    weak = sim.rov.thrusters["rear_right"].thrust_n / load_thruster("t200_16v").thrust_n[-1][1]
    assert weak < 0.75
    sim.advance(1.0)
    assert (sim.rov.failsafe.state, sim.rov.failsafe.cause) == ("surface", "battery")


def test_its_parameters_can_be_changed_in_a_run() -> None:
    sim = made()
    sim.rov.set_effort(surge=0.7)
    sim.advance(1.0)
    before_v = sim.rov.battery.voltage_v
    sim.parameters["rov.battery.resistance_ohm"] = 0.04
    sim.advance(1.0)
    assert sim.rov.battery.voltage_v < before_v - 0.2
    sim.parameters["rov.battery.hotel_w"] = 500.0
    sim.advance(0.1)
    assert sim.rov.battery.current_a > 30.0
    sim.parameters["rov.battery.capacity_ah"] = 9.0
    share = sim.rov.battery.percent
    assert sim.rov.battery.charge_ah == pytest.approx(0.09 * share)


def of_cells(*open_circuit_v: list[float], cutoff_v: float) -> dict[str, Any]:
    cells = {"name": "odd", "capacity_ah": 1, "open_circuit_v": open_circuit_v, "resistance_ohm": 0.1}
    return {"model": cells | {"cutoff_v": cutoff_v}}


@pytest.mark.parametrize(
    ("battery", "model", "message"),
    [
        ("nonesuch", "bluerov2_heavy", r"vehicles\[0\]\.battery.*unknown battery 'nonesuch'"),
        ("bluerov2_18ah", "rov", r"has no thrusters to supply: use mission_time_s"),
        ("bluerov2_18ah", "remus100", r"thruster 'propeller'.*has no `sheets`"),
        (
            of_cells([0, 9], [1, 12], cutoff_v=9),
            "bluerov2_heavy",
            r"9 to 12 V, must lie within those of thruster 'front_left', 10 to 20 V",
        ),
        (BATTERY | {"hotel_w": 9000}, "bluerov2_heavy", r"hotel_w = 9000 W: must be less than"),
        (of_cells([0, 13], [1, 12], cutoff_v=11), "bluerov2_heavy", r"voltages must not fall as the charge rises"),
    ],
)
def test_mistakes_are_met_at_the_door(battery: Any, model: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        made(battery, model)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("voltage_v,command\n10,0\n", r"mine\.csv: must begin with voltage_v,command,thrust_n,current_a,rpm"),
        ("# ours\nvoltage_v,command,thrust_n,current_a,rpm\n10,0,0\n", r"mine\.csv:3: 3 values: must be 5"),
        (
            "voltage_v,command,thrust_n,current_a,rpm\n10,0,x,0,0\n",
            r"mine\.csv:2: thrust_n = 'x': must be a finite number",
        ),
        ("voltage_v,command,thrust_n,current_a,rpm\n10,-1,-5,1,1\n10,1,5,1,1\n", r"= 1: must be those of at least 2"),
    ],
)
def test_an_invalid_sheet_is_refused_with_file_and_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(text)
    thruster = load_thruster("t200_16v").model_copy(update={"sheets": path})
    with pytest.raises(ScenarioError, match=message):
        thruster.performance()
