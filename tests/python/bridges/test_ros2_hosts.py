"""Calls between hosts: two network namespaces joined by a cable, with `uwsim serve` in one, a client in the other."""

import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from ros2_tools import free_domain

HERE = Path(__file__).parents[1]
OURS, THEIRS = "10.77.0.1", "10.77.0.2"
UWSIM = Path(sys.executable).with_name("uwsim")


def run(*words):
    subprocess.run(words, check=True, capture_output=True)


@pytest.fixture(scope="module")
def hosts():
    """The names of two hosts. Multicast needs a route, as every host in a network has one."""
    if not shutil.which("ip") or os.geteuid() != 0:
        pytest.skip("network namespaces need iproute2 and root")
    names = [f"uwsim{os.getpid()}{end}" for end in "ab"]
    try:
        try:
            for name in names:
                run("ip", "netns", "add", name)
            run(*f"ip link add cable netns {names[0]} type veth peer name cable netns {names[1]}".split())
        except subprocess.CalledProcessError as error:
            pytest.skip(f"no network namespaces here: {error.stderr.decode().strip()}")
        for name, address in zip(names, (OURS, THEIRS), strict=True):
            run("ip", "-n", name, "address", "add", f"{address}/24", "dev", "cable")
            for device in ("lo", "cable"):
                run("ip", "-n", name, "link", "set", device, "up")
            run("ip", "-n", name, "route", "add", "default", "dev", "cable")
        yield names
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "delete", name], check=False, capture_output=True)


def netns(host):
    return ["ip", "netns", "exec", host]


@contextmanager
def serving(host, domain, *options):
    """Serve the pool on a host until the end of the test."""
    words = f"serve pool --port 0 --ros2 --ros-domain-id {domain} --ros-reach subnet".split() + list(options)
    with subprocess.Popen([*netns(host), UWSIM, *words], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as process:
        try:
            yield
        finally:
            process.terminate()


def client(host, kind, domain):
    words = [sys.executable, HERE / "ros2_host_client.py", kind, str(domain)]
    return subprocess.Popen([*netns(host), *words], stdout=subprocess.PIPE, text=True)


def test_a_client_of_dds_calls_services_of_another_host(hosts):
    """Also finds the hosts by multicast. Takes 6 s: two processes load a simulator and a DDS library."""
    domain, (ours, theirs) = free_domain(), hosts
    with serving(ours, domain), client(theirs, "dds", domain) as said:
        assert said.communicate(timeout=240)[0] == "True\n"


def test_a_client_of_zenoh_calls_services_of_another_host_through_its_router(hosts):
    """The router is on the client's host. Takes 5 s: two processes load a simulator and Zenoh."""
    domain, (ours, theirs) = free_domain(), hosts
    with client(theirs, "zenoh", domain) as said, serving(ours, domain, "--rmw", "zenoh", "--ros-peer", THEIRS):
        assert said.communicate(timeout=240)[0] == "True\n"
