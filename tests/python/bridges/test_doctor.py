"""`uwsim ros doctor` names each reason why two participants cannot discover each other, and how to fix it."""

import http.server
import json
import socket
import threading

import pytest

from command_line import uwsim
from ros2_tools import free_domain
from servo_standin import NEUTRAL, Standin
from uwsim.bridges.doctor import network, servers, software
from uwsim.bridges.doctor.discovery import discovery
from uwsim.bridges.doctor.environment import environment
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.bridges.ros2.settings import unicast_port
from uwsim.bridges.rosbridge import RosbridgeServer
from uwsim.live import LiveSimulator

LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@pytest.fixture(scope="module")
def pool():
    with LiveSimulator("pool", paused=True) as live:
        yield live


def wrong(findings):
    return {finding.what: finding.advice for finding in findings if finding.verdict == "wrong"}


@pytest.mark.parametrize(
    ("variables", "settings", "what", "advice"),
    [
        ({"ROS_DOMAIN_ID": "5"}, Ros2Settings(), "ROS_DOMAIN_ID", "export ROS_DOMAIN_ID=0"),
        ({"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}, Ros2Settings(), "RMW_IMPLEMENTATION", "--rmw zenoh"),
        ({"ROS_DISCOVERY_SERVER": "1.2.3.4"}, Ros2Settings(), "ROS_DISCOVERY_SERVER", "unset"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, Ros2Settings(), "discovery range", "LOCALHOST"),
        (LOCAL, Ros2Settings(reach="subnet"), "discovery range", "--ros-reach localhost"),
    ],
)
def test_a_variable_of_ros_that_is_at_odds_is_named(variables, settings, what, advice):
    assert wrong(environment({}, settings)) == {}
    assert advice in wrong(environment(variables, settings))[what]


def test_nothing_is_wrong_with_a_node_of_the_same_kind(pool):
    settings = Ros2Settings(domain_id=free_domain())
    with Ros2Node(pool, [], (), settings):
        found = discovery(settings, 2.0)
    assert wrong(found) == {} and any("/uwsim (jazzy)" in finding.found for finding in found)


def test_a_node_of_another_distribution_is_named(pool):
    settings = Ros2Settings(domain_id=free_domain())
    with Ros2Node(pool, [], (), settings):
        found = discovery(Ros2Settings("humble", settings.domain_id), 2.0)
    assert wrong(found) == {"nodes": "uwsim serve --ros2 --ros-distro jazzy"}


def test_who_does_not_answer_and_who_is_in_another_domain_is_noticed():
    domain = free_domain()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as deaf:
        deaf.bind(("127.0.0.1", unicast_port(domain, 0)))
        found = wrong(discovery(Ros2Settings(domain_id=domain), 0.5))
        assert "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST" in found[f"domain {domain}"]
        (finding,) = discovery(Ros2Settings(domain_id=free_domain()), 0.5)
        assert finding.verdict == "wrong" and "participants in" in finding.found


def test_a_port_is_free_ours_or_taken(pool):
    class Silent(http.server.BaseHTTPRequestHandler):
        def log_message(self, *_):
            pass

    with RosbridgeServer(None) as server:
        taken = servers.rosbridge_port(server.port)
        assert taken.verdict == "wrong" and "another rosbridge" in taken.found
        port = server.port
    assert servers.rosbridge_port(port).found == "free"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ardusub:
        ardusub.bind(("127.0.0.1", 0))
        assert "taken" in servers.ardusub_port(ardusub.getsockname()[1], 0.1).found
    assert "nothing sends" in servers.ardusub_port(port, 0.1).found
    with Standin(port, lambda line: [NEUTRAL] * 8):
        assert servers.ardusub_port(port, 1.0).found == "free; an ArduSub waits: frame 0, 16 outputs, 400 Hz"
    with http.server.HTTPServer(("127.0.0.1", 0), Silent) as web:
        threading.Thread(target=web.serve_forever, daemon=True).start()
        assert servers.rosbridge_port(web.server_port).found == "taken, but not by a rosbridge"
        assert servers.foxglove_port(web.server_port).verdict == "note"
        web.shutdown()
    with RosbridgeServer(pool) as server:
        assert servers.rosbridge_port(server.port).found == "uwsim serves here"
    with RosbridgeServer(None, token="correct-horse") as server:
        for look in (servers.rosbridge_port, servers.foxglove_port):
            assert look(server.port) == servers.Finding(look(server.port).what, servers.LOCKED)


def test_interfaces_and_buffers_are_looked_at(monkeypatch):
    assert network.interfaces()["lo"][0] == "127.0.0.1"
    assert wrong(network.network(Ros2Settings())) == {}
    monkeypatch.setattr(network, "interfaces", dict)
    assert wrong(network.network(Ros2Settings())) == {"interface": "sudo ip link set lo up"}
    assert "--ros-reach localhost" in wrong(network.network(Ros2Settings(reach="subnet")))["interface"]
    assert "multicast on" in network.multicast("lo", "127.0.0.1", network.UP).advice


def test_a_missing_extra_is_a_note_that_names_the_command(monkeypatch):
    monkeypatch.setitem(software.EXTRAS, "ros2", ("no-such-package",))
    found = software.extra("ros2")
    assert (found.verdict, found.advice) == ("note", "pip install 'uwsim[ros2]'")


def test_the_command_prints_a_table_and_exits_with_1_when_something_is_wrong(pool, monkeypatch):
    settings = Ros2Settings(domain_id=free_domain())
    found = []
    same, other = (LOCAL | {"ROS_DOMAIN_ID": str(settings.domain_id + k)} for k in (0, 1))
    with Ros2Node(pool, [], (), settings), RosbridgeServer(pool) as server:
        command = [
            "ros",
            "doctor",
            "--ros-domain-id",
            str(settings.domain_id),
            "--listen",
            "2",
            "--port",
            str(server.port),
        ]
        for variables, code in ((same, 0), (other, 1)):
            for name, value in variables.items():
                monkeypatch.setenv(name, value)
            found.append(uwsim(*command))
            assert found[-1].returncode == code, found[-1].stdout + found[-1].stderr
    for done in found:
        assert "uwsim serves here" in done.stdout and "/uwsim (jazzy)" in done.stdout
        assert ("WRONG" in done.stdout) == bool(done.returncode)


def test_commands_to_copy_are_whole_on_a_narrow_terminal_and_json_has_the_same(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    missing = software.Finding("extras", "figures; not installed: rl", "note", "pip install 'uwsim[rl]' " + 60 * "x")
    monkeypatch.setattr("uwsim.bridges.doctor.examine", lambda *_: iter([missing]))
    shown = uwsim("ros", "doctor", "--listen", "0.1").stdout
    assert "…" not in shown and "'uwsim[rl]'" in shown and shown.count("x") == 61
    found = json.loads(uwsim("ros", "doctor", "--listen", "0.1", "--json").stdout)
    assert found[0] == {"what": "extras", "found": missing.found, "verdict": "note", "advice": missing.advice}


def test_extras_that_are_missing_are_named_as_pip_takes_them(monkeypatch):
    monkeypatch.setattr(software, "find_spec", lambda module: None if module in ("PIL", "cma") else True)
    found = software.other_extras()
    assert found.found.endswith("not installed: cameras,learning") and "'uwsim[cameras,learning]'" in found.advice
