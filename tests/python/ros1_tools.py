"""Test helpers: a ROS master on loopback, and programs run by Debian's Python that connect to it."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PYTHON = "/usr/bin/python3"


def ros_is_installed() -> bool:
    modules = "import rospy, rosmaster, tf2_ros, laser_geometry, sensor_msgs.point_cloud2"
    done = subprocess.run([PYTHON, "-c", modules], capture_output=True, check=False)
    return done.returncode == 0


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


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
        wait_for_port(port)
        yield environment
    finally:
        process.terminate()
        process.wait(20)


def wait_for_port(port: int) -> None:
    deadline_s = time.monotonic() + 60.0
    while True:
        with socket.socket() as tried:
            if tried.connect_ex(("127.0.0.1", port)) == 0:
                return
        assert time.monotonic() < deadline_s, f"nobody listens on {port}"
        time.sleep(0.05)


@contextmanager
def serving(environment: dict[str, str], *options: str) -> Iterator[str]:
    """Run `uwsim serve --ros1`; yield its first output line."""
    with running(environment, "serve", *options) as greeting:
        yield greeting


@contextmanager
def running(environment: dict[str, str], *arguments: str) -> Iterator[str]:
    """Run a uwsim command with --ros1; yield its first output line."""
    command = [sys.executable, "-c", "from uwsim.cli import main; main()", *arguments, "--ros1", "--port", "0"]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    greeting = process.stdout.readline()
    assert greeting, process.communicate()[1]
    try:
        yield greeting
    finally:
        process.terminate()
        process.wait(30)


def run_node(script: str, environment: dict[str, str], *arguments: str) -> str:
    """Run a script with Debian's Python to completion; return its output."""
    done = subprocess.run(
        [PYTHON, "-c", script, *arguments], env=environment, capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout
