"""Checks of versions and optional packages."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec

from uwsim import _core
from uwsim.base.extras import EXTRA_OF
from uwsim.bridges.doctor import Finding
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
    core = f"{_core.instruction_set()}, {os.cpu_count()} processors"
    return [
        Finding("uwsim", f"{version('uwsim')} on {python}"),
        Finding("processor", core),
        other_extras(),
        *map(extra, EXTRAS),
        ros1(),
    ]


def other_extras() -> Finding:
    """Return a finding about all other extras: those whose packages are installed, and those that are not."""
    names = {name: [module for module, of in EXTRA_OF.items() if of == name] for name in EXTRA_OF.values()}
    there = {
        name: all(find_spec(module) for module in modules) for name, modules in names.items() if name not in EXTRAS
    }
    found = ", ".join(name for name in there if there[name]) or "none"
    missing = ",".join(name for name in there if not there[name])
    if not missing:
        return Finding("extras", found)
    return Finding(
        "extras", f"{found}; not installed: {missing}", "note", f"for what needs them: pip install 'uwsim[{missing}]'"
    )


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
