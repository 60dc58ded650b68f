"""Test helpers: a ROS master on loopback, and programs run by Debian's Python that connect to it."""

import functools
import os
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from listening_sockets import free_port
from waiting import until

PYTHON = "/usr/bin/python3"


@functools.cache
def ros_is_installed() -> bool:
    modules = "import rospy, rosmaster, tf2_ros, laser_geometry, sensor_msgs.point_cloud2"
    done = subprocess.run([PYTHON, "-c", modules], capture_output=True, check=False)
    return done.returncode == 0


@contextmanager
def master(folder: Path) -> Iterator[dict[str, str]]:
    """Run a master; yield the environment variables for its nodes."""
    port = free_port()
    environment = {
        **os.environ, "ROS_IP": "127.0.0.1", "ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_LOG_DIR": str(folder),
        "ROS_HOME": str(folder),
    }  # fmt: skip
    process = subprocess.Popen(
        ["/usr/bin/rosmaster", "--core", "-p", str(port)], env=environment,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        until(lambda: listens(port), "the master")
        yield environment
    finally:
        process.terminate()
        process.wait(20)


def listens(port: int) -> bool:
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


def run_node(script: str, environment: dict[str, str], *arguments: str) -> str:
    """Run a script with Debian's Python to completion; return its output."""
    done = subprocess.run(
        [PYTHON, "-c", script, *arguments], env=environment, capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout
