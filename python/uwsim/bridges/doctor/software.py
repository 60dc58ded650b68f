"""Checks of versions and optional packages."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec

from uwsim.bridges.doctor.finding import Finding
from uwsim.bridges.ros1.rospy_module import DEBIAN, INSTALL

EXTRAS = {
    "ros2": ("cyclonedds",),
    "zenoh": ("eclipse-zenoh",),
    "foxglove": ("foxglove-sdk",),
    "tables": ("pandas", "pyarrow", "xarray"),
}


def software() -> list[Finding]:
    """Return findings about the installed software."""
    python = f"Python {platform.python_version()}, {platform.machine()}, {platform.system()} {platform.release()}"
    return [Finding("uwsim", f"{version('uwsim')} on {python}"), *map(extra, EXTRAS), ros1()]


def extra(name: str) -> Finding:
    """Return a finding about the packages of an optional dependency group ("extra")."""
    what, found, missing = f"extra {name}", [], []
    for package in EXTRAS[name]:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            missing.append(package)
    if missing:
        return Finding(what, f"not installed: {', '.join(missing)}", "note", f"pip install 'uwsim[{name}]'")
    wanted = {text.split(";")[0].strip() for text in requires("uwsim") or () if f'extra == "{name}"' in text}
    for package in found:
        pin = next((text for text in wanted if text.startswith(package.split()[0] + "==")), None)
        if pin and pin != package.replace(" ", "=="):
            return Finding(what, package, "wrong", f"this version is not known to work: pip install '{pin}'")
    return Finding(what, ", ".join(found))


def ros1() -> Finding:
    """Return a finding about the ROS 1 package rospy, from Debian or elsewhere."""
    if find_spec("rospy") is not None or (DEBIAN / "rospy").is_dir():
        return Finding("ROS 1", "rospy is there")
    return Finding("ROS 1", "no rospy", "note", f"for --ros1: {INSTALL}")
