"""`uwsim serve --ros2 --foxglove` from the shell: both sinks start and stop with the command."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from foxglove_client import FoxgloveClient
from ros2_tools import free_domain, peer
from uwsim.bridges.ros2 import Ros2Settings

UWSIM = Path(sys.executable).parent / "uwsim"


def test_serve_is_a_node_of_ros_2_and_serves_foxglove_until_it_is_ended():
    settings = Ros2Settings(domain_id=free_domain())
    command = [UWSIM, "serve", "pool", "--port", "0", "--ros2", "--ros-domain-id", str(settings.domain_id)]
    with subprocess.Popen(
        [*command, "--foxglove", "--foxglove-port", "0"], stdout=subprocess.PIPE, text=True, env=os.environ
    ) as process:
        try:
            assert process.stdout is not None
            greeting = process.stdout.readline()
            assert f"ROS 2 jazzy, domain {settings.domain_id}, on this machine alone" in greeting
            url = re.search(r"Foxglove at (ws://\S+:\d+)", greeting)
            assert url is not None, greeting
            with peer(settings) as other, FoxgloveClient(url[1]) as client:
                other.listen("clock", "rosgraph_msgs/msg/Clock")
                client.subscribe("/clock")
                assert other.next("clock").clock.sec >= 0
                assert client.next("/clock")[0] >= 0
        finally:
            process.send_signal(signal.SIGTERM)
        assert process.wait(60.0) == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--ros-domain-id", "3"], "--ros-domain-id: needs --ros2"),
        (["--foxglove-port", "3"], "--foxglove-port: needs --foxglove"),
        (["--ros2", "--ros-domain-id", "300"], "--ros-domain-id = 300: must be in [0, 232]"),
        (["--ros2", "--ros-distro", "kinetic"], "must be one of humble, jazzy"),
    ],
)
def test_an_option_without_effect_or_out_of_range_is_refused(options, message):
    done = subprocess.run(
        [UWSIM, "serve", "pool", "--port", "0", *options], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 2
    assert message in done.stderr and done.stderr.count("\n") == 1
