"""Restoring an earlier state, or resetting, undoes all later changes in every part of a simulator; replays repeat them.

The parts are found by walking the objects, calling every query of the native simulation, and issuing every command.
A part that is added later but not saved or not reset fails here.
"""

from __future__ import annotations

import enum
import hashlib
import inspect
import re
import warnings
from collections.abc import Iterator, Mapping, Set
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from uwsim import Batch, Simulator, _core
from uwsim.base.commands import COMMANDS, bound_command
from uwsim.live import LiveSimulator, replay
from uwsim.recording import Recorder
from uwsim.recording.replay import replay as replay_recording
from uwsim.simulator.docking import DockedWarning

pytestmark = pytest.mark.filterwarnings("ignore")

SCENARIO = """
name: everything
mission_time_s: 600
water:
  current: [{kind: gusts, sigma_m_s: [0.1, 0.1, 0.0], correlation_time_s: 5.0}]
terrain: {source: noise, size_m: [60, 60], spacing_m: 1, bed_depth_m: 12}
station: {position_m: [-15, 0, 0], mesh: meshes/station.obj, dock_m: [0, 0, -5]}
link: {modem: s2cm_hs}
faults:
  - {kind: sensor, name: often, sensor: depth, mode: bias, bias: 0.2, rate_per_h: 5000, for_s: 0.1}
vehicles:
  - name: rov
    model: rov
    start: station
    failsafe: {silence_s: 0.5, then: hold, leak_then: surface}
  - name: scout
    model: bluerov2_heavy_alpha5
    start: {position_m: [0, 0, -5], yaw_deg: 180}
    battery: bluerov2_18ah
    tether: {anchor: [0, 2, -4], length_m: 20, winch: {longest_m: 30}}
    droppers: {bay: {position_m: [0, 0.4, -0.3], holds: [marker, dart], spring_j: 0.5, jet_n: 1, jet_s: 0.5}}
  - {name: torpedo, model: remus100, start: {position_m: [0, 10, -5]}}
objects:
  - {shape: {kind: sphere, name: marker, position_m: [0, 0, -1], radius_m: 0.03}, density_kg_m3: 2000}
  - {shape: {kind: sphere, name: dart, position_m: [0, 0, -1], radius_m: 0.03}, density_kg_m3: 1100}
  - shape: {kind: sphere, name: ball, position_m: [9, 9, -3], radius_m: 0.2}
    density_kg_m3: 1000
    tether: {anchor: [9, 6, -4], length_m: 5, winch: {longest_m: 8}}
  - shape: {kind: box, name: post, position_m: [9, -6, -4], size_m: [0.3, 0.3, 0.3]}
    fixed: true
    links:
      bob:
        hinge: {axis: [0, 1, 0], start_deg: 60}
        mass_kg: 3
        centre_of_mass_m: [0, 0, -0.4]
        inertia_kg_m2: [0.05, 0.05, 0.05]
        volume_m3: 0.001
  - shape: {kind: sphere, name: diver, position_m: [0, -12, -3], radius_m: 0.3}
    path: {points_m: [[9, -12, -3], [9, -14, -4]], speed_m_s: 0.5, closed: true, climbs: true}
"""
for number, (end, x_m, y_m) in enumerate((("post", 9, -9), ("diver", 0, -15), ("ball", 9, 12), ("scout", 0, -3))):
    SCENARIO += f"""
  - shape: {{kind: box, name: buoy{number}, position_m: [{x_m}, {y_m}, -4], size_m: [0.4, 0.4, 0.4]}}
    density_kg_m3: 800
    tether: {{anchor: {{to: {end}}}, length_m: 5, elements: 4}}"""
PAUSE_STEPS = 20
EPISODE: list[tuple[str, dict[str, Any]]] = [
    ("set_effort", {"vehicle": "rov", "surge": 0.1}),
    ("undock", {"vehicle": "rov"}),
    ("set_wrench", {"vehicle": "rov", "force_body_n": [50.0, 20.0, -30.0]}),
    ("place", {"vehicle": "rov", "position_world_m": [-15.2, 0.1, -5.0]}),
    ("dock", {"vehicle": "rov"}),
    ("release", {"vehicle": "rov"}),
    ("start_navigation", {"vehicle": "rov"}),
    ("start_navigation", {"vehicle": "torpedo"}),
    ("set_effort", {"vehicle": "rov", "surge": 0.5, "yaw": 0.2}),
    ("set_thrusters", {"vehicle": "scout", "commands": {"front_left": 0.4, "rear_right": -0.3}}),
    ("set_fins", {"vehicle": "torpedo", "angles_rad": {"port": 0.1, "starboard": 0.1}}),
    ("aim", {"vehicle": "rov", "elevation_rad": -0.3}),
    ("set_lamp", {"vehicle": "rov", "lamp": "front", "on": True}),
    ("aim_camera", {"vehicle": "rov", "camera": "front", "pan_rad": 0.5, "tilt_rad": 0.2}),
    ("set_optics", {"jerlov": "5C"}),
    ("set_parameter", {"name": "rov.mass_kg", "value": 250.0}),
    ("set_parameters", {"changes": {"rov.sensors.depth.noise.std": 0.1, "scout.sensors.imu.on": False}}),
    ("reset_parameters", {"name": "rov.mass_kg"}),
    ("inject_fault", {"kind": "leak", "name": "leak", "kg_per_s": 0.5}),
    ("inject_fault", {"kind": "sensor", "name": "stuck", "sensor": "compass", "mode": "stuck"}),
    ("inject_fault", {"kind": "link", "name": "deaf", "vehicle": "scout"}),
    ("inject_fault", {"kind": "battery", "name": "weak", "vehicle": "scout", "thrust": 0.5, "for_s": 0.5}),
    ("link_send", {"sender": "rov", "receiver": "station", "topic": "t", "payload": b"x" * 200, "repeats": 2}),
    ("end_fault", {"name": "stuck"}),
    ("set_effort", {"vehicle": "rov", "heave": -0.2}),
    ("override_failsafe", {"vehicle": "rov"}),
    ("note", {"vehicle": "rov", "text": "rust", "position_world_m": [1.0, 2.0, -3.0]}),
    ("inject_fault", {"kind": "sensor", "name": "compass_sticks", "sensor": "compass", "mode": "stuck"}),
    ("hold", {"vehicle": "torpedo", "heading": True, "depth": True}),
    ("hold_at", {"vehicle": "torpedo", "heading_rad": 0.5}),
    ("set_effort", {"vehicle": "torpedo", "surge": 0.5, "yaw": 0.2}),
    ("set_effort", {"vehicle": "torpedo", "surge": 0.5}),
    ("set_effort", {"vehicle": "rov", "sway": 0.3}),
    ("set_winch", {"vehicle": "scout", "rate_m_s": 0.4}),
    ("cut_tether", {"vehicle": "scout", "at_m": 5.0}),
    ("set_object_winch", {"object": "ball", "rate_m_s": 0.4}),
    ("cut_object_tether", {"object": "ball", "at_m": 2.0}),
    ("set_joints", {"vehicle": "scout", "positions": {"shoulder": 0.4}, "torques": {"wrist": 0.3}}),
    ("drop", {"vehicle": "scout", "dropper": "bay"}),
    ("reload", {"vehicle": "scout", "dropper": "bay"}),
    ("drop", {"vehicle": "scout", "dropper": "bay"}),
    ("apply_wrench", {"vehicle": "rov", "force_n": [40.0, 0.0, 10.0], "axes": "world", "duration_s": 0.3}),
    ("push_object", {"object": "ball", "force_n": [5.0, 0.0, 0.0], "torque_nm": [0.0, 0.1, 0.0], "duration_s": 2.0}),
]
NO_STATE = {
    "Vehicle._last_motion": "a cache of the present version",
    "Vehicle._last_panel": "a cache of the present version",
    "Navigator._now_ns": "when it took in samples last: it looks again after a restore",
    "Navigator._imu_stream": "a restore ends streams; it asks for others from its _from_ns on",
    "Navigator._streams": "likewise",
    "Navigator._open": "likewise",
    "SampleSource._newest": "for streams to come, which a restored source watches for again",
    "SampleSource._watched_ns": "likewise",
    "OnboardNavigation.due_tick": "when it takes in samples at the latest: no estimate depends on it",
    "Helm._warned": "warnings are given again after a restore",
}
NOT_YET_STATE = {"servo_frames"}
"""Commands for steps to come, of which a replay repeats all before the next command: they leave nothing to save."""
SMALL = 64
"""Arrays of fewer numbers are compared as numbers, others by their digests."""
LEAVES = (type(None), bool, int, float, complex, str, bytes, enum.Enum, Path)


def episode() -> list[tuple[str, dict[str, Any]]]:
    """Return EPISODE, plus each missing command that needs only a vehicle as its argument."""
    steps, given = list(EPISODE), {name for name, _ in EPISODE}
    for name in sorted(COMMANDS.keys() - given - NOT_YET_STATE):
        needed = [argument.name for argument in COMMANDS[name].all_arguments if argument.is_required]
        assert needed == ["vehicle"], f"a new command, {name}: give it arguments in EPISODE"
        steps.insert(len(steps) // 2, (name, {"vehicle": "rov"}))
    return steps


def walked(sim: Simulator) -> dict[str, str]:
    """Return every value reachable from the simulator's Python objects, by its path."""
    found: dict[str, str] = {}
    seen: dict[int, str] = {}

    def visit(value: Any, path: str) -> None:
        if isinstance(value, LEAVES):
            found[path] = repr(value)
        elif isinstance(value, np.ndarray | np.generic):
            found[path] = repr((value.dtype, np.shape(value), np.asarray(value).tobytes()))
        elif isinstance(value, BaseModel):
            found[path] = digest(value.model_dump_json().encode())
        elif id(value) in seen and not isinstance(value, tuple):
            found[path] = f"-> {seen[id(value)]}"
        elif isinstance(value, _core.NavigationFilter):
            found[path] = digest(value.save())
        elif isinstance(value, Mapping | list | tuple) or type(value).__module__.split(".")[0] == "uwsim":
            seen[id(value)] = path
            parts = list(parts_of(value))
            found[path] = f"{type(value).__name__} of {len(parts)}"
            for name, part in parts:
                visit(part, f"{path}.{name}")
        elif isinstance(value, Set):
            found[path] = repr(sorted(each if isinstance(each, str | int) else type(each).__name__ for each in value))

    visit(sim, "sim")
    return found


def parts_of(value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping) and type(value).__module__.split(".")[0] != "uwsim":
        yield from sorted(((str(key), part) for key, part in value.items()), key=lambda item: item[0])
    elif isinstance(value, list | tuple):
        yield from ((str(k), part) for k, part in enumerate(value))
    else:
        slots = [name for each in type(value).__mro__ for name in vars(each).get("__slots__", ())]
        held = {
            **getattr(value, "__dict__", {}),
            **{name: getattr(value, name) for name in slots if hasattr(value, name)},
        }
        owner = type(value).__name__
        held = {
            name: part for name, part in held.items() if f"{owner}.{name}" not in NO_STATE and name != "__weakref__"
        }
        yield from sorted(held.items(), key=lambda item: item[0])


@cache
def queries() -> list[tuple[str, bool]]:
    """Return the names of the native queries without an argument, or (True) with a vehicle's or node's index."""
    found = []
    for name in dir(_core.Simulation):
        line = (getattr(_core.Simulation, name).__doc__ or "").partition("\n")[0]
        asked = re.fullmatch(rf"{name}\(self: [\w.]+(?P<index>, (vehicle|node): [^,=]+)?\) -> (?P<answer>.+)", line)
        if not name.startswith("_") and asked and asked["answer"] not in ("None", "uwsim._core.RayScene"):
            found.append((name, asked["index"] is not None))
    return found


def answers(sim: Simulator) -> dict[str, str]:
    """Return the results of all queries, of each vehicle's instruments, and of the link."""
    found = {"tick": str(sim.tick)}
    for name, has_index in queries():
        for index in range(len(sim.vehicles)) if has_index else [None]:
            try:
                answer = plain(getattr(sim._core, name)(*([] if index is None else [index])))
            except ValueError as error:  # of a part that this vehicle does not have
                answer = str(error)
            found[f"{name}({index})"] = repr(answer)
    assert sim.link is not None
    found["counts"] = repr(plain(sim.link.counts()))
    found |= {f"received by {node}": repr(plain(sim.link.received(node))) for node in sim.link.nodes}
    for rov in sim.vehicles.values():
        for sensor in rov.sensors.values():
            found[f"{rov.name}.{sensor.name}"] = repr(plain(vars(sensor.sample())))
        found |= {f"{rov.name}.sonar {name}": repr(sonar.elevation_rad) for name, sonar in rov.sonars.items()}
    return found


def plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist() if value.size < SMALL else (value.shape, digest(value.tobytes()))
    if isinstance(value, LEAVES):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, Set):
        return sorted(map(repr, value))
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    names = [name for name, part in inspect.getmembers(type(value)) if isinstance(part, property)]
    own = {name: plain(part) for name, part in getattr(value, "__dict__", {}).items()}
    return {name: plain(getattr(value, name)) for name in names} | own


def digest(data: bytes) -> str:
    return hashlib.blake2b(data, digest_size=12).hexdigest()


def everything(sim: Simulator) -> dict[str, str]:
    return {"saved state": digest(sim.save_state()), **walked(sim), **answers(sim)}


def fly(sim: Simulator, parts: tuple[int, ...] = (PAUSE_STEPS,)) -> Iterator[None]:
    """Issue every command; pause after each, and some times afterwards. parts: the steps that are made at once."""
    for name, arguments in [*episode(), *[("", {})] * 10]:
        if name:
            bound_command(name, arguments)(sim)
        yield
        for steps in parts:
            sim.step(steps)
    yield


def flown(sim: Simulator) -> list[dict[str, str]]:
    """Return all values at each pause of the episode."""
    return [everything(sim) for _ in fly(sim)]


def differences(expected: dict[str, str], got: dict[str, str]) -> list[str]:
    names = sorted(expected.keys() | got.keys())
    return [f"{n}: {expected.get(n)} became {got.get(n)}"[:300] for n in names if expected.get(n) != got.get(n)]


def require_same(expected: list[dict[str, str]], got: list[dict[str, str]]) -> None:
    assert len(expected) == len(got)
    for k, (first, second) in enumerate(zip(expected, got, strict=True)):
        assert differences(first, second) == [], f"at {k}"


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("all_state") / "everything.yaml"
    path.write_text(SCENARIO)
    return path


@pytest.fixture
def sim(scenario: Path) -> Simulator:
    return Simulator(scenario, seed=5, threads=1)


@pytest.fixture(scope="module")
def first(scenario: Path) -> list[dict[str, str]]:
    """All values of a new simulator, and at each pause of its episode."""
    sim = Simulator(scenario, seed=5, threads=1)
    return [everything(sim), *flown(sim)]


def test_the_episode_sets_everything_going(first: list[dict[str, str]]) -> None:
    start, *trace = first
    changed = "\n".join({line.partition(":")[0] for at in trace for line in differences(start, at)})
    for part in (
        "_events", "._faults.", "water_kg", "_distortion", ".is_driven", "_navigation._navigator", "observers",
        "_state", "_cause", "_steered.last", "_pilot", "_alarms", "._on", "_motion", "_parameters._changes", "optics",
        "link_waiting", "counts", "received", "released", "effort", "thruster_commands", "fin_angles_rad", "sonar",
        "telemetry", "compass", "usbl", "dvl", "battery(1)", "currents_a",
    ):  # fmt: skip
        assert part in changed, part


def test_a_restored_early_state_and_a_reset_undo_everything(sim: Simulator, first: list[dict[str, str]]) -> None:
    early = sim.save_state()
    for _ in fly(sim):
        pass
    for undo in (lambda: sim.restore_state(early), sim.reset):
        undo()
        require_same(first, [everything(sim), *flown(sim)])


def test_how_many_steps_are_made_at_once_does_not_matter(sim: Simulator, first: list[dict[str, str]]) -> None:
    for _ in fly(sim, (1, 13, 6)):
        pass
    assert differences(first[-1], everything(sim)) == []


def test_the_episode_is_replayed_from_its_log_and_its_recording(sim: Simulator, scenario: Path, tmp_path: Path) -> None:
    path, orders = tmp_path / "run.mcap", episode()
    with LiveSimulator(sim, paused=True, speed="max") as live:
        live.command("set_parameter", name="rov.friction", value=0.6).result()  # before the recording begins
        live.step(PAUSE_STEPS)
        with Recorder(live, path, topics=["rov/imu"]):
            for name, arguments in orders:
                live.command(name, **arguments).result()
                live.step(PAUSE_STEPS)
        state, tick, log = sim.save_state(), live.tick, live.log
    assert replay(Simulator(scenario, seed=5, threads=1), log, tick).save_state() == state
    found = replay_recording(path, threads=1)
    assert found.difference is None and found.state_compared and found.commands == len(orders)


def test_a_member_of_a_batch_equals_it(sim: Simulator) -> None:
    batch = Batch(sim.scenario, n=2, seeds=[4, 5], threads=1)
    batch.step(100)
    sim.step(100)
    assert batch.save_state(1) == sim.save_state()


def test_a_restored_late_state_is_as_it_was(sim: Simulator, scenario: Path) -> None:
    for _ in fly(sim):
        pass
    late, after = sim.save_state(), everything(sim)
    sim.advance(1.0)
    later = everything(sim)
    fresh = Simulator(scenario, seed=5, threads=1)
    sim.reset()
    for again in (fresh, sim):
        again.restore_state(late)
        assert differences(after, everything(again)) == []
        again.advance(1.0)
        assert differences(later, everything(again)) == []


def test_the_first_look_at_the_estimate_begins_it_after_a_reset_as_in_a_new_simulator(sim: Simulator) -> None:
    def looked() -> np.ndarray:
        sim.rov.undock()
        sim.rov.set_effort(surge=0.5)
        sim.advance(0.3)
        return np.concatenate([sim.rov.estimate.pose.position_world_m, [sim.time_s]])

    early, first = sim.save_state(), looked()
    sim.restore_state(early)
    np.testing.assert_array_equal(looked(), first)
    sim.reset()
    np.testing.assert_array_equal(looked(), first)


def test_after_a_reset_no_command_of_the_last_run_is_warned_of(sim: Simulator) -> None:
    early = sim.save_state()
    for undo in (sim.reset, lambda: sim.restore_state(early)):
        sim.rov.release()
        sim.rov.set_effort(surge=0.5)
        undo()
        with warnings.catch_warnings():
            warnings.simplefilter("error", DockedWarning)
            sim.step()  # docked and not yet commanded
