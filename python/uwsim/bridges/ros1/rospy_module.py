"""Imports Debian's rospy in a virtual environment, with its sockets restricted to this machine."""

from __future__ import annotations

import importlib
import os
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from uwsim.bridges.ros1.guard import guard_sockets

DEBIAN = Path("/usr/lib/python3/dist-packages")
LOOPBACK = "127.0.0.1"
INSTALL = "apt install python3-rospy"


def load_rospy() -> Any:
    """Return the rospy module. Raises ValueError if it is missing or was built for a different Python.

    Its folder is appended to the module path, so that the environment's own packages come first. Unless ROS_IP or
    ROS_HOSTNAME is set, rospy's sockets are open to this machine only.
    """
    if find_spec("rospy") is None:
        if not (DEBIAN / "rospy").is_dir():
            raise ValueError(f"ROS 1 needs rospy, which is not installed: {INSTALL}")
        sys.path.append(str(DEBIAN))
    if not {"ROS_IP", "ROS_HOSTNAME"} & os.environ.keys():
        os.environ["ROS_IP"] = LOOPBACK
    try:
        rospy = importlib.import_module("rospy")
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:2]))
        raise ValueError(f"ROS 1: rospy cannot be imported by Python {version}: {error}; {INSTALL}") from None
    guard_sockets()
    return rospy


def require_master() -> str:
    """Return the ROS master's address. Raises ValueError if the master does not respond."""
    rosgraph = importlib.import_module("rosgraph")
    address = os.environ.get("ROS_MASTER_URI", "http://127.0.0.1:11311")
    os.environ["ROS_MASTER_URI"] = address
    if not rosgraph.is_master_online(address):
        raise ValueError(f"ROS 1: no master answers at {address}: start roscore, or set ROS_MASTER_URI")
    return address
