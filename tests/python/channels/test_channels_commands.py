"""The table's standard commands and services take effect, or report why they cannot."""

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from channel_tools import floats, table, twist
from uwsim.channels import Table, start_updates
from uwsim.channels.calls.command_services import named_arguments
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pair", speed="max", paused=True) as live:
        for k, vehicle in enumerate(live.vehicles.values()):
            vehicle.release()
            vehicle.place([10.0 * k, 0.0, -6.0])
        yield live


def test_a_velocity_is_held_until_another_command_and_the_vehicle_stays_level(live: LiveSimulator) -> None:
    found, rov = table(live.simulator), live.vehicles["rov"]
    for name in live.vehicles:
        found[f"{name}/cmd_vel"].apply(live, twist(0.4, 0.0, 0.1, 0.0, 0.0, 0.2))
    live.step(2000)
    for vehicle in live.vehicles.values():
        velocity = vehicle.velocity
        np.testing.assert_allclose(velocity.linear_body_m_s, [0.4, 0.0, 0.1], atol=0.06)
        assert velocity.angular_body_rad_s[2] == pytest.approx(0.2, abs=0.03)
        assert vehicle.pose.world_from_body[2, 2] > math.cos(math.radians(10.0))
    found["scout/cmd_vel"].apply(live, twist(*[0.0] * 6))
    found["rov/key"].apply(live, build.pose((0.0, 0.0, -0.25), (0.0, 0.0, 0.0, 0.0)))
    live.step(100)
    np.testing.assert_array_equal(rov.effort, [0, 0, -0.25, 0, 0, 0])
    live.step(1900)
    assert np.linalg.norm(live.vehicles["scout"].velocity.linear_body_m_s) < 0.05


def test_wrench_and_thruster_commands_arrive(live: LiveSimulator) -> None:
    found, efforts = table(live.simulator), np.linspace(-0.5, 0.5, len(live.vehicles["scout"].thrusters))
    found["scout/cmd_thrusters"].apply(live, floats(*efforts))
    live.step(1)
    np.testing.assert_allclose([one.command for one in live.vehicles["scout"].thrusters.values()], efforts)
    wrench = build.message("geometry_msgs/msg/Wrench", force=build.vector((100, 0, 0)), torque=build.vector((0, 0, 5)))
    found["rov/cmd_wrench"].apply(live, wrench)
    found["rov/cmd_tilt"].apply(live, build.message("std_msgs/msg/Float64", data=0.05))
    live.step(100)
    assert live.vehicles["rov"].velocity.linear_body_m_s[0] > 0.02
    live.step(1900)
    assert live.vehicles["rov"].sonar.elevation_rad == pytest.approx(-0.05)


def test_what_cannot_be_done_is_refused(live: LiveSimulator) -> None:
    before, found = len(live.log), table(live.simulator)
    for topic, message, rule in (
        ("rov/cmd_vel", twist(math.nan, 0, 0, 0, 0, 0), "cmd_vel = .*: must be finite"),
        ("rov/cmd_vel", twist(1e9, 0, 0, 0, 0, 0), "cmd_vel = .*: must be finite and within 100"),
        ("scout/cmd_thrusters", floats(0.1), "cmd_thrusters: 1 values: must be"),
        ("scout/cmd_thrusters", floats(*[1.5] * 8), r"cmd_thrusters: \w+ = 1.5: must be in \[-1, 1\]"),
        ("rov/cmd_tilt", build.message("std_msgs/msg/Float64", data=9.0), "cmd_tilt = 9.0 rad: must be in"),
    ):
        with pytest.raises(ValueError, match=rule):
            found[topic].apply(live, message)
    live.step(20)
    assert len(live.log) == before


def ask(live: LiveSimulator, name: str, /, own: Table | None = None, **request: Any) -> dict[str, Any]:
    found = {service.name: service for service in (own or Table(live.simulator)).services}
    return found[name].call(live, request)


def test_services_of_the_simulator_and_of_a_vehicle(live: LiveSimulator) -> None:
    done = {"success": True, "message": ""}
    assert ask(live, "simulation/step", steps=7.0) == done
    assert live.simulator.tick == 7
    assert ask(live, "simulation/step", steps=-1)["message"].startswith("steps = -1: must be")
    assert ask(live, "simulation/step", steps=True)["success"] is False
    assert ask(live, "simulation/set_speed", speed=2) == done
    assert ask(live, "simulation/resume") == done
    assert ask(live, "simulation/step")["message"] == "step: the simulator is running; pause it first"
    pace = ask(live, "simulation/pace")
    assert (pace["speed"], pace["paused"]) == (2.0, False)
    assert ask(live, "simulation/pause") == done
    assert ask(live, "simulation/reset") == done
    assert live.simulator.tick == 0 and not live.vehicles["rov"].released
    assert "speed = -1" in ask(live, "simulation/set_speed", speed=-1)["message"]
    assert ask(live, "rov/release")["success"] and live.vehicles["rov"].released
    assert ask(live, "rov/lights/front", data=True)["success"] and live.vehicles["rov"].lamps["front"].on
    assert ask(live, "rov/lights/front")["message"] == "data = None: must be given, as bool"


def test_a_field_that_a_command_has_not_is_refused_whatever_its_name(live: LiveSimulator) -> None:
    """Also the names of parameters of the functions that pass it on."""
    for field in ("name", "vehicle", "live", "self", "by", "sim", "target", "tick"):
        for service in ("rov/release", "rov/set_wrench"):
            answer = ask(live, service, **{field: "other"})
            assert not answer["success"] and f"'{field}': " in answer["message"]


def test_the_map_is_saved_where_the_simulator_runs_and_nowhere_else(
    live: LiveSimulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    own = Table(live.simulator)
    ask_own = partial(ask, live, own=own)
    assert "there is no map yet" in ask_own("rov/save_map")["message"]
    next(one for one in own.channels if one.name == "rov/octomap_binary").read(live.simulator)
    assert ask_own("rov/save_map", name="here.bt") == {"success": True, "message": "here.bt"}
    assert len(OccupancyMap.read("here.bt").occupied_voxels()) > 0
    (tmp_path / "maps").mkdir()
    (tmp_path / "out").symlink_to(tmp_path.parent)
    for name in ("maps/there.bt", str(tmp_path / "maps" / "again.bt")):
        assert ask_own("rov/save_map", name=name)["success"]
    for name in ("../there.bt", "/tmp/there.bt", "here.ot", ".bt", "", 5, "none/here.bt", "out/here.bt", "a\0.bt"):
        assert "name = " in ask_own("rov/save_map", name=name)["message"]
    written = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.bt") if "out" not in path.parts)
    assert written == ["here.bt", "maps/again.bt", "maps/there.bt"]


def test_the_published_wire_offers_no_save_map_since_it_grows_none(live: LiveSimulator) -> None:
    published, both = (
        {each.name for each in Table(live.simulator, wire=wire).services} for wire in ("published", "both")
    )
    assert "rov/release" in published
    assert {name.split("/")[-1] for name in both - published} == {"save_map"}


def test_the_map_holds_every_ping_since_the_start_though_nobody_reads(
    live: LiveSimulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    own = Table(live.simulator)
    started = start_updates(live, own.channels)
    assert len(started) == 2, "a map for each vehicle"
    live.step(10)
    first = _saved(live, own, "first.bt")
    live.vehicles["rov"].sonar.aim(-1.0)
    live.step(1000)
    turned = _saved(live, own, "turned.bt")
    assert len(turned) > 1.2 * len(first) > 0
    for subscription in started:
        subscription.cancel()
    live.step(1000)
    assert len(_saved(live, own, "still.bt")) == len(turned)


def _saved(live: LiveSimulator, own: Table, name: str) -> NDArray[np.float64]:
    assert ask(live, "rov/save_map", own, name=name)["success"]
    return OccupancyMap.read(name).occupied_voxels()


def test_arguments_by_position_are_the_fields_of_the_request(live: LiveSimulator) -> None:
    services = {service.name: service for service in Table(live.simulator).services}
    assert named_arguments(services["rov/all_stop"], [True]) == {"data": True}
    wrench = named_arguments(services["rov/set_wrench"], [[1.0, 0.0, 0.0]])
    assert wrench == {"force_body_n": [1.0, 0.0, 0.0]} and services["rov/set_wrench"].call(live, wrench)["success"]
    assert named_arguments(services["rov/release"], []) == {}
    with pytest.raises(ValueError, match="service 'rov/all_stop': 2 args: must be 1 at most: data"):
        named_arguments(services["rov/all_stop"], [True, False])
