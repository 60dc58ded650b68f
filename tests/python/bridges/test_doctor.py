"""`uwsim ros doctor` names each reason why two participants cannot discover each other, and how to fix it."""

import json
import socket

import pytest

from command_line import uwsim
from ros2_tools import free_domain
from uwsim.bridges.doctor import software
from uwsim.bridges.doctor.discovery import discovery
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.bridges.ros2.settings import unicast_port
from uwsim.live import LiveSimulator


@pytest.fixture(scope="module")
def pool():
    with LiveSimulator("pool", paused=True) as live:
        yield live


def wrong(findings):
    return {finding.what: finding.advice for finding in findings if finding.verdict == "wrong"}


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


def test_a_missing_extra_is_a_note_that_names_the_command(monkeypatch):
    monkeypatch.setitem(software.EXTRAS, "ros2", ("no-such-package",))
    found = software.extra("ros2")
    assert (found.verdict, found.advice) == ("note", "pip install 'uwsim[ros2]'")


def test_the_command_prints_a_table_and_exits_with_1_when_something_is_wrong(pool):
    settings = Ros2Settings(domain_id=free_domain())
    command = ["ros", "doctor", "--ros-domain-id", str(settings.domain_id), "--listen", "2", "--ros-distro"]
    with Ros2Node(pool, [], (), settings):
        found = [uwsim(*command, distro) for distro in ("jazzy", "humble")]
    assert [done.returncode for done in found] == [0, 1]
    for done in found:
        assert "/uwsim (jazzy)" in done.stdout and ("WRONG" in done.stdout) == bool(done.returncode)


def test_commands_to_copy_are_whole_on_a_narrow_terminal_and_json_has_the_same(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    missing = software.Finding("extras", "figures; not installed: rl", "note", "pip install 'uwsim[rl]' " + 60 * "x")
    monkeypatch.setattr("uwsim.bridges.doctor.software.software", lambda: [missing])
    shown = uwsim("ros", "doctor", "--listen", "0.1").stdout
    assert "…" not in shown and "'uwsim[rl]'" in shown and shown.count("x") == 61
    found = json.loads(uwsim("ros", "doctor", "--listen", "0.1", "--json").stdout)
    assert found[0] == {"what": "extras", "found": missing.found, "verdict": "note", "advice": missing.advice}


def test_extras_that_are_missing_are_named_as_pip_takes_them(monkeypatch):
    monkeypatch.setattr(software, "find_spec", lambda module: None if module in ("PIL", "cma") else True)
    found = software.other_extras()
    assert found.found.endswith("not installed: cameras,learning") and "'uwsim[cameras,learning]'" in found.advice
