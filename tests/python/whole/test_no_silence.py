"""Every user setting takes effect, or raises an error that names the remedy."""

import copy
import pickle
import re

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.base.named import Named
from uwsim.mapping import OccupancyMap
from uwsim.missions import AdaptiveLawnMower, LawnMowerPlan, ObstacleMemory
from uwsim.navigation.control import Autopilot
from uwsim.navigation.control.autopilot import Gains
from uwsim.navigation.control.controller import VelocityHold


def lawn_mower(sim: Simulator) -> AdaptiveLawnMower:
    return AdaptiveLawnMower(sim.rov, sim, LawnMowerPlan([[0, 0], [9, 0], [9, 5], [0, 5]]))


@pytest.fixture(scope="module")
def sim() -> Simulator:
    return Simulator("pool")


@pytest.mark.parametrize(
    ("owner", "name", "message"),
    [
        ("sim.rov", "efort", r"Vehicle\.efort: unknown attribute; did you mean 'effort'\?"),
        ("sim.rov", "effort", r"Vehicle\.effort: cannot be assigned; use set_effort\(\)"),
        ("sim.rov", "pose", r"use place\(\)"),
        ("sim.rov", "released", r"use release\(\), undock\(\) or dock\(\)"),
        ("sim.rov", "set_effort", "it is a method: call it"),
        ("sim.rov", "name", "it is fixed when the simulator is made"),
        ("sim", "time_s", r"use step\(\) or advance\(\)"),
        ("sim", "optics", r"use set_optics\(\)"),
        ("sim", "vehicle", "unknown attribute; did you mean 'vehicles'"),
        ("sim.world.water", "current_world_m_s", r"water\.current_world_m_s: a running simulator's world is fixed"),
        ("sim.world.water", "salinity_psu", r"water\.salinity_psu: a running simulator's world is fixed"),
        ("sim.world.water", "waves", r"water\.waves"),
        ("sim.world.water", "salinty", "a running simulator's world is fixed"),
        ("sim.scenario", "seed", r"Scenario\.seed cannot be assigned"),
        ("sim.scenario.water", "salinity_psu", r"Water\.salinity_psu cannot be assigned"),
        ("sim.optics", "jerlov", r"Optics\.jerlov cannot be assigned"),
        ("sim.rov.sonar", "elevation_rad", r"use aim\(\)"),
        ("sim.rov.sonar", "elevation", "unknown attribute; did you mean 'elevation_rad'"),
        ("sim.rov.sonar.model", "range_max_m", "no setter"),
        ("sim.rov.sensors['imu']", "rate_hz", "it is fixed"),
        ("sim.rov.lamps['front']", "onn", "did you mean 'on'"),
        ("sim.rov.cameras['front']", "widht", "unknown attribute"),
        ("sim.rov.telemetry()", "depth_m", "no setter"),
        ("sim.rov.sonar.ping()", "ranges_m", "no setter"),
    ],
)
def test_an_assignment_without_effect_is_an_error(sim: Simulator, owner: str, name: str, message: str) -> None:
    with pytest.raises(AttributeError, match=message):
        setattr(eval(owner, {"sim": sim}), name, 1.0)


@pytest.mark.parametrize(
    ("make", "name", "message"),
    [
        (lambda sim: OccupancyMap(0.5), "resolution", "unknown attribute; did you mean 'resolution_m'"),
        (lambda sim: OccupancyMap(0.5), "resolution_m", "it is fixed when the map is made or read"),
        (lambda sim: Autopilot(sim.rov), "gain", "unknown attribute; did you mean 'gains'"),
        (lambda sim: Autopilot(sim.rov), "period_s", "it is fixed when the autopilot is made"),
        (lambda sim: VelocityHold(sim.rov, 0.1), "controller", "it is fixed when the controller is made"),
        (lambda sim: lawn_mower(sim), "lanes", "use the plan's lanes"),
        (lambda sim: lawn_mower(sim), "stat", "unknown attribute; did you mean 'state'"),
        (lambda sim: lawn_mower(sim).state, "lanes", "no attribute 'lanes'"),
        (lambda sim: lawn_mower(sim).plan, "altitude_m", "cannot assign to field"),
        (lambda sim: ObstacleMemory(), "ahead_m", "it is fixed when the memory is made"),
    ],
)
def test_maps_controllers_and_missions_refuse_such_assignments_too(sim, make, name: str, message: str) -> None:
    with pytest.raises(AttributeError, match=message):
        setattr(make(sim), name, 1.0)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("imuu", "sensors['imu']"),
        ("front", "cameras['front']"),
        ("sonr", "'sonar'"),
        ("efort", "'effort'"),
        ("position", "pose.position_world_m"),
        ("roll", "pose.orientation_xyzw"),
    ],
)
def test_an_unknown_attribute_is_refused_with_the_part_or_attribute_of_that_name(
    sim: Simulator, name: str, meant: str
) -> None:
    with pytest.raises(AttributeError) as refused:
        getattr(sim.rov, name)
    assert str(refused.value) == f"Vehicle.{name}: unknown attribute; did you mean {meant}?"
    assert str(pickle.loads(pickle.dumps(refused.value))) == str(refused.value)
    assert not hasattr(sim.rov, name)


def test_each_name_that_others_use_leads_to_something_that_is_there(sim: Simulator) -> None:
    for owner in (sim, sim.rov):
        for name, meant in type(owner)._meant.items():
            assert not hasattr(owner, name)
            for path in re.findall(r"[a-z]+[_.(][\w.()]*", meant):
                assert eval(f"owner.{path.removesuffix('()')}", {"owner": owner}) is not None


def test_new_gains_take_effect(sim: Simulator) -> None:
    autopilot = Autopilot(sim.rov)
    autopilot.gains = Gains(heading=0.0, heading_rate=0.0)
    autopilot.steer(sim.rov.pose.yaw_rad + 1.0, (0.0, 0.0), float(sim.rov.pose.position_world_m[2]))
    assert sim.rov.effort[5] == 0.0
    autopilot.gains = Gains(heading=0.5, heading_rate=0.0)
    autopilot.steer(sim.rov.pose.yaw_rad + 1.0, (0.0, 0.0), float(sim.rov.pose.position_world_m[2]))
    assert sim.rov.effort[5] == pytest.approx(0.5)
    sim.rov.set_effort()


def test_no_property_of_the_water_can_be_assigned(sim: Simulator) -> None:
    water = sim.world.water
    properties = [name for name, part in vars(_core.Water).items() if isinstance(part, property)]
    assert {"salinity_psu", "waves", "profile"} <= set(properties)
    for name in properties:
        with pytest.raises(AttributeError, match=f"water.{name}: a running simulator's world is fixed"):
            setattr(water, name, getattr(water, name))
    with pytest.raises(AttributeError, match="add_current"):
        water.add_current(_core.Current.tidal((0.1, 0, 0), 100.0))


def test_the_water_of_a_simulator_reads_as_it_is(sim: Simulator) -> None:
    water, spec = sim.world.water, sim.scenario.water
    np.testing.assert_array_equal(water.current_world_m_s, spec.current_world_m_s)
    state = sim.parameters["water.salinity_psu"], sim.parameters["water.density_kg_m3"]
    assert (water.salinity_psu, water.density_kg_m3) == state == (0.0, spec.density_kg_m3)
    with pytest.raises(AttributeError, match=r"world\.water: a running simulator's world is fixed"):
        sim.world.water = water
    with pytest.raises(AttributeError, match=r"world\.add_solid: a running simulator's world is fixed"):
        sim.world.add_solid("box", np.zeros((4, 3)), np.zeros((1, 3), np.uint32))


@pytest.mark.parametrize(
    "array",
    [
        "rov.pose.position_world_m",
        "rov.pose.orientation_xyzw",
        "rov.pose.world_from_body",
        "rov.velocity.linear_body_m_s",
        "rov.effort",
        "rov.full_wrench_body[0]",
        "rov.sonar.ping().ranges_m",
        "rov.sonar.ping().world_from_sonar",
        "world.water.current_world_m_s",
    ],
)
def test_arrays_that_are_copies_of_the_state_are_read_only(sim: Simulator, array: str) -> None:
    with pytest.raises(ValueError, match="read-only"):
        eval(f"sim.{array}", {"sim": sim})[0] = 1.0


@pytest.mark.parametrize(
    ("things", "wrong", "near"),
    [
        ("sim.rov.sensors", "imuu", "imu"),
        ("sim.rov.cameras", "frnt", "front"),
        ("sim.rov.lamps", "fron", "front"),
        ("sim.rov.sonars", "sonr", "sonar"),
        ("sim.cameras", "staton", "station"),
        ("sim.vehicles", "rvo", "rov"),
        ("sim.strengths_db", "terain", "terrain"),
    ],
)
def test_a_misspelt_name_names_the_nearest(sim: Simulator, things: str, wrong: str, near: str) -> None:
    named = eval(things, {"sim": sim})
    with pytest.raises(KeyError, match=rf"\['{wrong}'\]: must be one of .*{near}.*; did you mean '{near}'\?$"):
        named[wrong]
    assert named.get(wrong) is None
    assert wrong not in named and near in named
    with pytest.raises(TypeError, match="read-only"):
        named[near] = None
    with pytest.raises(TypeError, match="read-only"):
        named.pop(near)


def test_things_by_name_are_copied_as_they_are() -> None:
    named = Named({"a": 1, "b": 2}, "things")
    for again in (copy.deepcopy(named), pickle.loads(pickle.dumps(named))):
        assert again == named == {"a": 1, "b": 2}
        with pytest.raises(KeyError, match=r"things\['c'\]: must be one of a, b$"):
            again["c"]
    with pytest.raises(KeyError, match=r"fins\['rudder'\]: there are none$"):
        Named({}, "fins")["rudder"]


@pytest.mark.parametrize("wrong", ["0.5", True, np.True_, None, [0.5], 1j, b"1"])
def test_an_effort_that_is_no_number_is_refused_and_changes_nothing(sim: Simulator, wrong: object) -> None:
    sim.rov.set_effort(sway=0.25)
    with pytest.raises(ValueError, match=r"effort\.surge = .*: must be a number"):
        sim.rov.set_effort(surge=wrong)  # type: ignore[arg-type]
    assert sim.rov.effort.tolist() == [0, 0.25, 0, 0, 0, 0]
    sim.rov.set_effort()


@pytest.mark.parametrize("number", [1, np.float32(0.5), np.int64(1), 0.5])
def test_every_kind_of_number_is_an_effort(sim: Simulator, number: float) -> None:
    sim.rov.set_effort(surge=number)
    assert sim.rov.effort[0] == number
    sim.rov.set_effort()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("sim.advance('1')", r"duration_s = '1': must be a number \[s\]"),
        ("sim.advance(True)", r"duration_s = True: must be a number"),
        ("sim.rov.sonar.aim('0.1')", r"elevation_rad = '0.1': must be a number \[rad\]"),
        ("sim.rov.sonar.aim(float('nan'))", "nan"),
        ("sim.rov.set_wrench(['1', 0, 0])", r"force_body_n\[0\] = '1': must be a number \[N\]"),
        ("sim.rov.set_wrench([1, 0])", r"force_body_n.shape = \(2,\): expected \(3,\)"),
        ("sim.rov.set_thrusters({'nose': 0.5})", "thrusters = 'nose': "),
        ("sim.rov.set_fins({'rudder': 0.5})", "fins = 'rudder': the vehicle has none"),
    ],
)
def test_a_wrong_argument_is_named_with_its_unit(sim: Simulator, call: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        eval(call, {"sim": sim})
