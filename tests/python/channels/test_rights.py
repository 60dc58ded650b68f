"""The rights to command a vehicle, on every bridge, while a pilot has the controls; see channels.authority.rights."""

import pytest

from channel_tools import twist
from uwsim.bridges.bridge import Bridge
from uwsim.channels import Table
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.simulator.helm import Source


def test_every_command_of_a_vehicle_is_the_pilots_and_every_client_may_stop_it() -> None:
    with LiveSimulator("pool", paused=True) as live:
        table = Table(live.simulator)
        with Bridge("test", live, table.channels, table.services) as bridge:
            vehicles = [channel for channel in bridge.inputs.values() if channel.over_link]
            assert {"key", "cmd_vel", "cmd_tilt"} <= {channel.name for channel in vehicles}
            lease = live.simulator.rov.helm.take(Source.PILOT, "Ada")
            for channel in vehicles:
                with pytest.raises(ValueError, match=f"/{channel.name}: refused: Ada has the controls"):
                    bridge.apply(channel, channel.authority.idle)
            commands = {name for name, service in bridge.services.items() if service.permit is not None}
            assert {"release", "dock", "lights/front", "set_wrench", "override_failsafe", "all_stop"} <= commands
            assert not {name for name in commands if name.startswith(("simulation/", "camera/"))}
            for name in commands:
                answer = bridge.respond(bridge.services[name], {"data": False})
                assert not answer["success"] and "Ada has the controls" in answer["message"]
            assert not live.log
            assert bridge.respond(bridge.services["all_stop"], {"data": True})["success"] and live.rov.all_stopped
            lease.end()
            assert bridge.respond(bridge.services["all_stop"], {"data": False})["success"] and not live.rov.all_stopped


def test_clients_learn_at_once_that_an_autopilot_steers_but_may_stop_the_vehicle() -> None:
    with LiveSimulator("pool", paused=True) as live:
        live.rov.release()
        table, wrench = Table(live.simulator), "geometry_msgs/msg/Wrench"
        with Bridge("test", live, table.channels, table.services) as bridge:
            bridge.apply(bridge.inputs["cmd_vel"], twist(0.5))
            assert table.steering["rov"].is_flown
            live.simulator.rov.helm.take(Source.AUTOPILOT, "ArduSub")
            assert not table.steering["rov"].is_flown, "the velocity is no longer held"
            live.read(lambda sim: None).result()
            before = len(live.log)  # the hold may have set efforts once
            with pytest.raises(ValueError, match="vehicle 'rov': cmd_vel: has no effect while ArduSub steers"):
                bridge.apply(bridge.inputs["cmd_vel"], twist(0.5))
            with pytest.raises(ValueError, match="vehicle 'rov': set_wrench: has no effect while ArduSub steers"):
                bridge.apply(bridge.inputs["cmd_wrench"], build.message(wrench, force=build.vector((9.0, 0.0, 0.0))))
            bridge.apply(bridge.inputs["cmd_wrench"], build.message(wrench))
            live.step(20)
        assert [entry.name for entry in list(live.log)[before:]] == ["set_wrench"]
