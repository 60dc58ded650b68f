"""Every figure of a packaged vehicle, thruster, sensor and sonar says where it is from, or that it is assumed."""

import re
from pathlib import Path

import pytest

from uwsim.scenario.paths import assets_folder

KINDS = ("vehicles", "thrusters", "sensors", "sonars")
FILES = sorted(p for kind in KINDS for p in (assets_folder() / kind).glob("*.yaml"))
TAG = re.compile(r"\[([A-Za-z]+)\]")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(\.\d+)?(e[-+]?\d+)?(?![\w.])")
LISTS = ("thrusters:", "fins:", "sensors:")  # whose members are figures' owners, each by itself


def defined_tags(text: str) -> set[str]:
    """Sources that the file's comments list, one a line: `#   [Wu] Wu 2018, ...`."""
    return set(re.findall(r"^#   \[([A-Za-z]+)\] \S", text, re.MULTILINE))


def entries(text: str) -> list[tuple[str, str, str]]:
    """Name, values and comments of each top-level key, and of each member of a list of thrusters, fins or sensors.

    Comments are those on the entry's lines and those straight above it; above a list or its first member, they count
    for all members, and above a member for those that follow it in one block, without a comment of their own.
    """
    found: list[tuple[str, str, str]] = []
    above, shared, depth = "", "", 0
    for line in text.splitlines():
        value, _, comment = line.partition("#")
        if not line.strip():
            above = ""
        elif not value.strip():
            above += comment + "\n"
        elif not value.startswith(" "):
            depth = 2 if value.rstrip() in LISTS else 0
            shared = above if depth else ""
            if not depth:
                found.append((value.split(":")[0], value, above + comment))
            above = ""
        elif depth and re.match(r"  \S", value):
            shared = above or shared
            name, _, rest = value.partition(":")
            found.append((name.strip(), rest, shared + comment))
            above = ""
        else:
            name, values, comments = found[-1]
            found[-1] = (name, values + value.partition(":")[2], comments + above + comment)
            above = ""
    return found


def unsourced(text: str) -> list[str]:
    tags = defined_tags(text)
    return [
        name
        for name, values, comments in entries(text)
        if name not in ("name", "description")
        and NUMBER.search(re.sub(r"[\w.]+\.(obj|yaml)", "", values))
        and "assumed" not in comments.lower()
        and not tags & set(TAG.findall(comments))
    ]


@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_each_figure_names_its_source_or_is_assumed(path: Path) -> None:
    assert unsourced(path.read_text()) == []


@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_each_source_that_is_named_is_listed_and_used(path: Path) -> None:
    text = path.read_text()
    used = set(TAG.findall(re.sub(r"^#   \[\w+\]", "", text, flags=re.MULTILINE)))
    units = {"m", "kg", "s", "N"}
    assert used - units == defined_tags(text)


@pytest.mark.parametrize("name", ["mass_kg", "added_mass", "friction", "port", "propeller"])
def test_a_figure_without_its_source_is_found(name: str) -> None:
    """Once its comments are gone, the entry is named."""
    vehicle = "remus100" if name in ("port", "propeller") else "bluerov2_wu"
    lines = (assets_folder() / "vehicles" / f"{vehicle}.yaml").read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.strip().startswith(name + ":"))
    lines[at] = lines[at].partition("#")[0]
    while lines[at - 1].lstrip().startswith("#"):
        at -= 1
        lines[at] = ""
    assert name in unsourced("\n".join(lines))
