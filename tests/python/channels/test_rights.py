"""The rights to command a vehicle, on every bridge, while a pilot has the controls; see uwsim.channels.rights."""

import pytest

from uwsim.bridges.bridge import Bridge
from uwsim.channels import Table
from uwsim.live import LiveSimulator


def test_every_command_of_a_vehicle_is_the_pilots_and_every_client_may_stop_it() -> None:
    with LiveSimulator("pool", paused=True) as live:
        table = Table(live.simulator)
        with Bridge("test", live, table.channels, table.services) as bridge:
            vehicles = [channel for channel in bridge.inputs.values() if channel.over_link]
            assert {"key", "cmd_vel", "cmd_tilt"} <= {channel.name for channel in vehicles}
            table.rights.pilot = lambda: "Ada"
            for channel in vehicles:
                with pytest.raises(ValueError, match=f"/{channel.name}: refused: Ada has the controls"):
                    bridge.apply(channel, channel.idle)
            commands = {name for name, service in bridge.services.items() if service.rights is not None}
            assert {"release", "dock", "lights/front", "set_wrench", "override_failsafe", "all_stop"} <= commands
            assert not {name for name in commands if name.startswith(("simulation/", "camera/"))}
            for name in commands:
                answer = bridge.respond(bridge.services[name], {"data": False})
                assert not answer["success"] and "Ada has the controls" in answer["message"]
            assert not live.log
            assert bridge.respond(bridge.services["all_stop"], {"data": True})["success"] and live.rov.all_stopped
            table.rights.pilot = lambda: ""
            assert bridge.respond(bridge.services["all_stop"], {"data": False})["success"] and not live.rov.all_stopped
