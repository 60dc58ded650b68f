"""The simulator's parameters from outside: through rosapi, rosbridge services and the command line."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

import pytest
from websockets.sync.client import ClientConnection

from client_socket import call
from client_socket import connect as websocket
from command_line import error_line, uwsim
from uwsim.bridges import RosbridgeServer
from uwsim.channels.ros.messages import Ros
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool", speed=5.0) as live:
        yield live


@pytest.fixture(scope="module")
def client(live: LiveSimulator) -> Iterator[ClientConnection]:
    with RosbridgeServer(live) as server, websocket(server.url) as client:
        yield client


def test_rosapi_reads_and_sets_them_and_keeps_a_store_beside(client: ClientConnection, live: LiveSimulator) -> None:
    name = "/rov/drag/linear/surge"
    assert call(client, "/rosapi/get_param", name=name) == (True, {"value": "29.4"})
    assert call(client, "/rosapi/set_param", name=name, value="44.5")[0] is True
    assert live.simulator.parameters["rov.drag.linear.surge"] == 44.5
    assert list(live.log)[-1].arguments == {"changes": {"rov.drag.linear.surge": 44.5}}
    drag = json.loads(call(client, "/rosapi/get_param", name="/rov/drag/linear")[1]["value"])
    assert drag[0] == 44.5
    refused = call(client, "/rosapi/set_param", name=name, value="-1")
    assert refused[0] is False and "rov.drag.linear.surge = -1 N s/m: must be in" in refused[1]
    assert live.simulator.parameters["rov.drag.linear.surge"] == 44.5
    assert call(client, "/rosapi/has_param", name=name)[1] == {"exists": True}
    assert call(client, "/rosapi/delete_param", name=name)[0] is False
    call(client, "/rosapi/set_param", name="/my/own", value='{"p": 1}')
    assert call(client, "/rosapi/get_param", name="my/own")[1] == {"value": '{"p": 1}'}
    names = call(client, "/rosapi/get_param_names")[1]["names"]
    assert {name, "/my/own", "/use_sim_time"} <= set(names)


@pytest.mark.parametrize("ros", [1, 2])
def test_rosapi_knows_the_names_that_ros_2_spells_as_node_and_parameter(live: LiveSimulator, ros: Ros) -> None:
    with RosbridgeServer(live, ros=ros) as server, websocket(server.url) as client:
        mass = json.dumps(live.simulator.parameters["rov.mass_kg"])
        assert call(client, "/rosapi/get_param", name="/uwsim:rov.mass_kg", default_value="")[1] == {"value": mass}
        assert call(client, "/rosapi/get_param", name="/auv_1/uwsim:rov.mass_kg")[1] == {"value": mass}
        assert call(client, "/rosapi/get_param", name="/other:rov.mass_kg", default_value="7")[1] == {"value": "7"}
        assert call(client, "/rosapi/get_param", name="/uwsim:use_sim_time")[1] == {"value": "true"}
        assert call(client, "/rosapi/has_param", name="/uwsim:rov.friction")[1] == {"exists": True}
        assert call(client, "/rosapi/set_param", name="/uwsim:rov.friction", value="0.6")[0] is True
        assert live.simulator.parameters["rov.friction"] == 0.6
        names = call(client, "/rosapi/get_param_names")[1]["names"]
        spelled = {"/rov/mass_kg", "/use_sim_time"} if ros == 1 else {"/uwsim:rov.mass_kg", "/uwsim:use_sim_time"}
        assert spelled <= set(names)
        assert all(call(client, "/rosapi/has_param", name=name)[1]["exists"] for name in names[:5])
    live.command("reset_parameters").result()


def test_services_list_get_describe_set_and_reset(client: ClientConnection, live: LiveSimulator) -> None:
    listed = call(client, "/simulation/list_parameters", prefix="rov.max_force_n")[1]["names"]
    assert listed == ["rov.max_force_n.x", "rov.max_force_n.y", "rov.max_force_n.z"]
    changes = {"rov.friction": 0.7, "optics.jerlov": "5C"}
    assert call(client, "/simulation/set_parameters", values_json=json.dumps(changes))[1]["success"] is True
    answer = call(client, "/simulation/get_parameters", names=["rov.friction", "optics.jerlov"])[1]
    assert json.loads(answer["values_json"]) == changes
    wrong = json.dumps({"rov.friction": 0.1, "rov.mass_kg": -1})
    answer = call(client, "/simulation/set_parameters", values_json=wrong)[1]
    assert answer["success"] is False and "rov.mass_kg = -1 kg: must be in" in answer["message"]
    assert live.simulator.parameters["rov.friction"] == 0.7, "all or none"
    described = call(client, "/simulation/describe_parameters", names=["rov.friction"])[1]["descriptions_json"]
    assert json.loads(described)[0] | {"value": 0.7, "default": 0.5, "low": 0, "high": 2} == json.loads(described)[0]
    assert call(client, "/simulation/reset_parameters", names=["rov.friction"])[1]["success"] is True
    assert live.simulator.parameters["rov.friction"] == 0.5
    assert live.simulator.parameters["optics.jerlov"] == "5C"
    assert call(client, "/simulation/reset_parameters")[1]["success"] is True
    assert live.simulator.parameters.changes == {}
    assert call(client, "/simulation/get_parameters", names=["rov.nothing"])[1]["success"] is False
    assert call(client, "/simulation/get_parameters", names="rov")[1]["success"] is False


def test_the_command_line_lists_them() -> None:
    table = uwsim("scenario", "parameters", "pool", "rov.drag.linear").stdout.splitlines()
    assert table[1].split()[:4] == ["rov.drag.linear.surge", "29.4", "N", "s/m"]
    assert len(table) == 7
    assert "did you mean 'rov.drag'?" in error_line(uwsim("scenario", "parameters", "pool", "rov.drg"))
    parameters = Simulator("pool").parameters
    reasons = {
        "rov.fins": "is empty: rov has none; it is",
        "rov.sonar.noise": "has no effect: it is for `mode: physics`",
    }
    for name, why in reasons.items():
        with pytest.raises(ValueError, match=f"{re.escape(name)}'\\]: {why}"):
            parameters.list(name)
    with pytest.raises(ValueError, match=r"must be in \[0\.01, 1000000\] kg"):
        parameters["rov.mass_kg"] = 1e9
