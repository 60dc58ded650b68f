"""Compares the ROS 2 environment variables with uwsim's settings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

from uwsim.bridges.doctor.finding import Finding
from uwsim.bridges.ros2.settings import SAFE_DOMAIN_MAX, Ros2Settings
from uwsim.channels.ros.cdr import Distro

LOCALHOST_ADVICE = "export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST (Humble: ROS_LOCALHOST_ONLY=1) on the side of ROS"


def environment(variables: Mapping[str, str], settings: Ros2Settings) -> list[Finding]:
    """Return findings about the ROS variables. ROS nodes started elsewhere may have different values."""
    found = [_domain(variables, settings), _distro(variables, settings), _range(variables, settings)]
    rmw = variables.get("RMW_IMPLEMENTATION", "")
    if rmw and ("zenoh" in rmw) != (settings.rmw == "zenoh"):
        advice = f"--rmw {'zenoh' if 'zenoh' in rmw else 'fastrtps'} here"
        found.append(Finding("RMW_IMPLEMENTATION", f"{rmw}, ours is rmw_{settings.rmw}", "wrong", advice))
    elif rmw:
        found.append(Finding("RMW_IMPLEMENTATION", rmw))
    if server := variables.get("ROS_DISCOVERY_SERVER"):
        advice = "unset ROS_DISCOVERY_SERVER: we do not ask Fast DDS's discovery server"
        found.append(Finding("ROS_DISCOVERY_SERVER", server, "wrong", advice))
    for name in ("CYCLONEDDS_URI", "FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE"):
        if text := variables.get(name):
            found.append(Finding(name, text[:80], "note", "it may restrict interfaces or peers: try without it"))
    return found


def _domain(variables: Mapping[str, str], settings: Ros2Settings) -> Finding:
    what, ours = "ROS_DOMAIN_ID", settings.domain_id
    theirs = variables.get(what, "") or "0"
    if theirs != str(ours):
        advice = f"export ROS_DOMAIN_ID={ours} on the side of ROS"
        return Finding(what, f"{theirs} here, {ours} requested", "wrong", advice)
    if ours > SAFE_DOMAIN_MAX:
        advice = f"choose one up to {SAFE_DOMAIN_MAX}: Linux may have given the ports of higher ones away"
        return Finding(what, str(ours), "note", advice)
    return Finding(what, str(ours))


def _distro(variables: Mapping[str, str], settings: Ros2Settings) -> Finding:
    theirs = variables.get("ROS_DISTRO", "")
    if theirs in ("", settings.distro):
        return Finding("ROS_DISTRO", settings.distro + ("" if theirs else ", by default"))
    advice = f"--ros-distro {theirs}" if theirs in get_args(Distro) else f"we know {' and '.join(get_args(Distro))}"
    return Finding("ROS_DISTRO", f"{theirs} here, we speak {settings.distro}", "note", advice)


def _range(variables: Mapping[str, str], settings: Ros2Settings) -> Finding:
    what = "discovery range"
    theirs = variables.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper()
    is_local = theirs == "LOCALHOST" or variables.get("ROS_LOCALHOST_ONLY") == "1"
    if theirs == "OFF":
        return Finding(what, "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF", "wrong", LOCALHOST_ADVICE)
    if settings.reach == "localhost" and not is_local:
        advice = f"if nodes are not seen: {LOCALHOST_ADVICE}; or --ros-reach subnet here"
        return Finding(what, "ours is localhost, ROS's the subnet", "note", advice)
    if settings.reach == "subnet" and is_local:
        return Finding(what, "ours is the subnet, ROS's localhost", "wrong", "--ros-reach localhost here")
    return Finding(what, settings.reach)
