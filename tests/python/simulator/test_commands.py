"""One table defines all commands; vehicles, logs, links, services and pages derive everything from it."""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.base.axes import AXES
from uwsim.base.commands import COMMANDS, SET_BOOL, TRIGGER, Argument, Command, Commandable, Placeable, bound_command
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.remote import RemoteConnection, RemoteVehicle
from uwsim.channels.families.key import key_efforts, key_message
from uwsim.channels.ros.service_types import OUTCOME, SERVICE_TYPES, definition_of, field_names
from uwsim.channels.served import served_table
from uwsim.link import Carrier
from uwsim.live import LiveSimulator, replay
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.operator.station.wire_js import messages_js
from uwsim.operator.teleop.hands import SERVICES
from uwsim.recording import Recorder
from uwsim.recording.replay import replay as replay_recording
from uwsim.simulator.vehicle import Vehicle

SOURCES = Path(__file__).parents[3] / "python/uwsim"
METHODS = [name for name in COMMANDS if hasattr(Placeable, name)]
NUDGE = Command(
    "nudge",
    "set the effort ahead",
    (Argument("effort", low=0.0, high=0.5),),
    lambda vehicle, effort: vehicle.steer_silently([effort, 0.0, 0.0, 0.0, 0.0, 0.0]),
    crosses_link=True,
    service="uwsim_msgs/srv/Nudge",
)
"""A command that exists only in the table."""


@pytest.fixture
def nudge(monkeypatch: pytest.MonkeyPatch) -> Command:
    monkeypatch.setitem(COMMANDS, NUDGE.name, NUDGE)
    return NUDGE


@pytest.fixture
def live(nudge: Command) -> Iterator[LiveSimulator]:
    with LiveSimulator("pool", paused=True, speed="max") as live:
        live.rov.undock()
        yield live


def test_a_new_entry_is_a_command_of_live_vehicles_the_log_and_both_replays(
    live: LiveSimulator, tmp_path: Path
) -> None:
    with Recorder(live, tmp_path / "run.mcap", topics=["imu"]):
        live.rov.command("nudge", effort=0.25)
        live.step(50)
        live.command("nudge", vehicle="rov", effort=0.5).result()
        live.step(50)
    assert [(entry.tick, entry.name) for entry in live.log] == [(0, "undock"), (0, "nudge"), (50, "nudge")]
    state, tick = live.simulator.save_state(), live.tick
    assert replay(Simulator("pool"), live.log, tick).save_state() == state
    found = replay_recording(tmp_path / "run.mcap")
    assert found.difference is None and found.state_compared and found.commands == 2


def test_a_new_entry_is_a_service_and_a_command_of_remote_vehicles_and_missions(live: LiveSimulator) -> None:
    with RosbridgeServer(live) as server, RemoteConnection(server.url) as connection:
        assert "/nudge" in connection.call("rosapi/services")["services"]
        far = RemoteVehicle(connection)
        for vehicle, effort in (
            (far, 0.125),
            (OwnVehicle(far, live.clock), 0.25),
            (OwnVehicle(live.rov, live.clock), 0.5),
        ):
            vehicle.command("nudge", effort=effort)
            assert live.rov.effort[0] == effort
        for vehicle in (far, live.rov, live.simulator.rov):
            with pytest.raises(ValueError, match=r"command 'nudge': effort = 0.75: must be in \[0, 0.5\]"):
                vehicle.command("nudge", effort=0.75)
        with pytest.raises(ValueError, match=r"command 'nudge': effort: must be given"):
            connection.call("nudge")


def test_a_service_s_type_has_a_field_for_each_argument() -> None:
    assert definition_of(NUDGE) == f"float64 effort  # in [0, 0.5]\n---\n{OUTCOME}"
    lamps = (Argument("on", "flag", default=True), Argument("lamp", "text", default=None))
    assert definition_of(Command("blink", "", lamps)) == f"bool on true\nstring[<=1] lamp\n---\n{OUTCOME}"
    for command in COMMANDS.values():
        if command.service and command.service != TRIGGER:
            names = [each.name for each in command.arguments] if command.service != SET_BOOL else ["data"]
            assert field_names(SERVICE_TYPES[command.service]) == [*names, "success", "message"]
    light = Argument("light", "numbers", default=None, length=3)
    for argument in (light, Argument("file", "bytes"), Argument("value", "any")):
        with pytest.raises(ValueError, match=f"argument '{argument.name}': no field of a service can carry it"):
            definition_of(Command("show", "", (argument,)))


def test_a_new_entry_goes_over_a_link_and_the_pilot_may_give_it(nudge: Command) -> None:
    assert '"nudge": ["effort"]' in messages_js()
    with (
        LiveSimulator(Simulator("pool", link="tether"), paused=True, speed="max") as live,
        Carrier(live, table := served_table(live)) as carrier,
    ):
        carrier.remote().command("nudge", vehicle="rov", effort=0.25).result()
        assert live.rov.effort[0] == 0.0
        live.step(200)
        assert live.rov.effort[0] == 0.25
        (service,) = [one for one in carrier.over(table.services) if one.name == "nudge"]
        assert service.call(live, {"effort": 0.5}) == {"success": True, "message": "sent over tether"}


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("owner", [Placeable, Vehicle])
def test_methods_take_what_the_table_says(owner: type, name: str) -> None:
    taken = list(inspect.signature(getattr(owner, name)).parameters.values())[1:]
    expected = [
        (argument.name, inspect.Parameter.empty if argument.is_required else argument.default)
        for argument in COMMANDS[name].arguments
    ]
    assert [(parameter.name, parameter.default) for parameter in taken] == expected


def test_what_a_real_vehicle_could_take_is_a_method_of_every_vehicle() -> None:
    real = {name for name, one in COMMANDS.items() if (one.crosses_link or one.is_ashore) and one.apply is None}
    assert real == {name for name in COMMANDS if hasattr(Commandable, name)}
    assert {name for name, command in COMMANDS.items() if command.steers} == {
        "set_effort", "set_wrench", "set_thrusters", "set_fins", "hold", "hold_at",
    }  # fmt: skip


EDGES: dict[tuple[str, str], Callable[[Simulator, float], object]] = {
    **{("set_effort", axis): lambda sim, x, axis=axis: sim.rov.set_effort(**{axis: x}) for axis in AXES},
    ("set_thrusters", "commands"): lambda sim, x: sim.vehicles["scout"].set_thrusters({"front_left": x}),
    ("aim", "elevation_rad"): lambda sim, x: sim.rov.sonar.aim(x),
}
"""Calls that enforce each bound independently of the table."""


@pytest.fixture(scope="module")
def pair() -> Simulator:
    return Simulator("pair")


@pytest.mark.parametrize(("name", "argument"), EDGES)
def test_bounds_of_the_table_are_those_of_the_simulation(pair: Simulator, name: str, argument: str) -> None:
    bounded = COMMANDS[name].argument(argument)
    for edge in (bounded.low, bounded.high):
        beyond = math.nextafter(edge, math.copysign(math.inf, edge))
        EDGES[name, argument](pair, edge)
        bounded.check_number(edge, "x")
        for refuse in (lambda x: EDGES[name, argument](pair, x), lambda x: bounded.check_number(x, "x")):
            with pytest.raises(ValueError, match="must be in"):
                refuse(beyond)


@pytest.mark.parametrize(
    ("name", "arguments", "rule"),
    [
        ("fly", {}, "command = 'fly': must be one of release, undock"),
        ("release", {}, "command 'release': vehicle: must be given"),
        ("release", {"vehicle": "rob"}, "vehicle = 'rob': must be one of rov"),
        ("release", {"vehicle": 5}, "vehicle = 5: must be text"),
        ("set_effort", {"vehicle": "rov", "warp": 1.0}, "'warp': must be one of vehicle, surge"),
        ("set_effort", {"vehicle": "rov", "surge": 1.5}, r"surge = 1.5: must be in \[-1, 1\]"),
        ("set_effort", {"vehicle": "rov", "surge": "1"}, "surge = '1': must be a number"),
        ("set_wrench", {"vehicle": "rov", "force_body_n": [1.0]}, r"force_body_n = \[1.0\]: must be 3 numbers \[N\]"),
        (
            "set_wrench",
            {"vehicle": "rov", "force_body_n": [0, 0, math.nan]},
            r"force_body_n\[2\] = nan N: must be finite",
        ),
        ("set_thrusters", {"vehicle": "rov", "commands": 1.0}, "commands = 1.0: must be numbers by name"),
        (
            "aim",
            {"vehicle": "rov", "elevation_rad": 2.0},
            r"elevation_rad = 2.0 rad: must be in \[-1.5708, 1.5708\] rad",
        ),
        ("set_lamp", {"vehicle": "rov", "lamp": "front", "on": 1}, "on = 1: must be True or False"),
    ],
)
def test_wrong_commands_are_refused_with_path_value_unit_and_rule(
    pair: Simulator, name: str, arguments: dict[str, Any], rule: str
) -> None:
    with pytest.raises(ValueError, match=rule):
        bound_command(name, arguments)(pair)


def test_what_the_terminal_s_keys_ask_for_are_services_without_arguments() -> None:
    assert all(COMMANDS[name].service == TRIGGER for name in SERVICES.values())


def test_the_published_key_carries_efforts_there_and_back() -> None:
    efforts = dict(zip(AXES, (0.1, -0.2, 0.3, -0.4, 0.5, -0.6), strict=True))
    assert key_efforts(key_message(efforts)) == efforts
    starboard = key_message(dict.fromkeys(AXES, 0.0) | {"sway": -1.0, "yaw": -1.0})
    assert (starboard.position.y, starboard.orientation.z) == (1.0, 1.0)


def test_the_axes_and_the_methods_of_vehicles_have_one_home() -> None:
    axes, methods = [], []
    for path in sorted(SOURCES.rglob("*.py")):
        text = path.read_text()
        if "def set_effort(" not in text and not all(f'"{axis}"' in text for axis in AXES):
            continue  # ast.parse takes a hundred times as long
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Tuple) and [getattr(part, "value", None) for part in node.elts] == list(AXES):
                axes.append(path.name)
            if isinstance(node, ast.FunctionDef) and node.name == "set_effort":
                methods.append(path.name)
    assert axes == ["axes.py"]
    assert sorted(methods) == ["commandable.py", "commands.py", "vehicle_commands.py"], "commands.py: for a batch"


def test_numpy_values_are_numbers(pair: Simulator) -> None:
    bound_command("place", {"vehicle": "rov", "position_world_m": np.array([0.0, 0.0, -3.0])})(pair)
    bound_command("set_effort", {"vehicle": "rov", "surge": np.float32(0.5)})(pair)
    assert pair.rov.effort[0] == 0.5
