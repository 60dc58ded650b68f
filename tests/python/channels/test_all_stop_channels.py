"""All stop overrides every command topic and the pilot's controls; its service, its messages, and a full queue."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from all_stop_world import DRIVES, at_rest, scenario
from channel_tools import floats, table, twist
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.families.diagnostics import diagnostics_channel
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.live.step_loop import REQUESTS_MAX
from uwsim.operator.station.controls.pilot import Pilot

AHEAD = build.pose((1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
X, ZERO = build.vector((0.5, 0.0, 0.0)), build.vector((0.0, 0.0, 0.0))
TWIST = twist(0.5)
HEARD: dict[str, Any] = {
    "thrusters/key": AHEAD, "fins/key": AHEAD, "forces/key": AHEAD,
    **{f"{name}/cmd_vel": TWIST for name in DRIVES},
    **{f"{name}/cmd_vel_stamped": build.message("geometry_msgs/msg/TwistStamped", twist=TWIST) for name in DRIVES},
    **{f"{name}/cmd_wrench": build.message("geometry_msgs/msg/Wrench", force=X, torque=ZERO) for name in DRIVES},
    "thrusters/cmd_thrusters": floats(*[0.5] * 8), "fins/cmd_thrusters": floats(1.0),
    "fins/cmd_fins": floats(0.1, 0.1, 0.2, 0.2),
}  # fmt: skip
"""For each channel that can move the vehicle, a message that does."""
LOOKING = {f"{name}/cmd_tilt" for name in DRIVES} | {"forces/camera/front/cmd_pan", "forces/camera/front/cmd_tilt"}


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveSimulator]:
    with LiveSimulator(Simulator(scenario(tmp_path)), paused=True) as live:
        yield live


def is_driven(live: LiveSimulator) -> bool:
    """Return True if something drives a vehicle; a force not produced by thrusters is detected by its effect."""
    before = live.vehicles["forces"].velocity.linear_body_m_s[0]
    live.step(20)
    return not at_rest(live.simulator) or live.vehicles["forces"].velocity.linear_body_m_s[0] > before + 1e-6


def test_every_topic_that_is_heard_has_been_thought_of(live: LiveSimulator) -> None:
    heard = {name for name, channel in table(live.simulator).items() if channel.direction == "in"}
    assert heard == set(HEARD) | LOOKING


@pytest.mark.parametrize("topic", HEARD)
def test_no_topic_moves_a_stopped_vehicle_and_who_publishes_is_told(live: LiveSimulator, topic: str) -> None:
    hear, name = table(live.simulator)[topic].apply, topic.split("/")[0]
    hear(live, HEARD[topic])
    assert is_driven(live)
    live.vehicles[name].all_stop()
    live.step(200)
    assert not is_driven(live), "a velocity is held no longer"
    with pytest.raises(ValueError, match=f"vehicle '{name}': .*: all stop is set"):
        hear(live, HEARD[topic])
    assert not is_driven(live)
    live.vehicles[name].all_stop(False)
    live.step(200)
    assert not is_driven(live), "what was commanded before does not come back"
    hear(live, HEARD[topic])
    assert is_driven(live)


def test_the_service_stops_and_releases_and_every_vehicle_has_one(live: LiveSimulator) -> None:
    found = {service.name: service for service in Table(live.simulator).services}
    for name in DRIVES:
        stop = found[f"{name}/all_stop"]
        assert stop.type == "std_srvs/srv/SetBool"
        live.vehicles[name].set_effort(surge=0.5)
        assert stop.call(live, {"data": True}).result() == {"success": True, "message": ""}
        assert live.vehicles[name].all_stopped and at_rest(live.simulator)
        assert stop.call(live, {"data": False}).result()["success"] and not live.vehicles[name].all_stopped
        assert "data = None: must be given" in stop.call(live, {}).result()["message"]


def test_telemetry_and_diagnostics_say_so_but_not_of_lamps(live: LiveSimulator) -> None:
    panel, diagnosed = table(live.simulator)["fins/telemetry"], diagnostics_channel(live)
    assert list(panel.read(live.simulator).alarms) == []
    live.vehicles["fins"].all_stop()
    assert list(panel.read(live.simulator).alarms) == ["all stop"]
    levels = {status.name: status.level for status in diagnosed.read(live.simulator).status}
    assert (levels["uwsim: fins"], levels["uwsim: forces"]) == (1, 0)
    forces = live.vehicles["forces"]
    table(live.simulator)["forces/cmd_vel"].apply(live, HEARD["forces/cmd_vel"])
    live.step(20)
    forces.all_stop()
    forces.all_stop(False)
    live.step(200)
    assert at_rest(live.simulator), "a velocity is no longer held, although all stop is released at once"
    forces.all_stop()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table(live.simulator)["forces/key"].apply(live, build.pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 3.0)))
        live.step()
    assert forces.lamps["front"].on


def test_the_pilot_s_hands_move_nothing_and_release_does_not_move_it_either(live: LiveSimulator) -> None:
    helm, ahead = Pilot(live, Table(live.simulator).steering), {"vehicle": "forces", "surge": 0.5}
    assert helm.drive(ahead).result()["success"]
    assert helm.all_stop({"vehicle": "forces"}).result()["success"] and at_rest(live.simulator)
    with pytest.raises(ValueError, match="all stop is set"):
        helm.drive(ahead)
    helm.beat()
    assert helm.all_stop({"vehicle": "forces", "on": False}).result()["success"] and at_rest(live.simulator)
    for wrong in ({"vehicle": "boat"}, {"vehicle": "forces", "on": 1}):
        with pytest.raises(ValueError, match="must be"):
            helm.all_stop(wrong)


def test_all_stop_is_taken_however_many_commands_wait(live: LiveSimulator) -> None:
    waiting: Future[None] = Future()
    held = live.call(lambda sim: waiting.result())
    with pytest.raises(RuntimeError, match=f"{REQUESTS_MAX} commands are already waiting"):
        for _ in range(2 * REQUESTS_MAX):
            live.command("set_effort", vehicle="forces", surge=1.0)
    stopped = live.command("all_stop", vehicle="forces")
    waiting.set_result(None)
    held.result(), stopped.result()
    assert live.read(at_rest).result()  # after all commands that waited, and between two of them
