"""Every value of a packaged vehicle, thruster, battery, sensor and sonar names its source or is marked as assumed."""

import re
from pathlib import Path

import pytest

from uwsim.scenario.read.assets import assets_folder

KINDS = ("vehicles", "thrusters", "batteries", "sensors", "sonars")
FILES = sorted(p for kind in KINDS for p in (assets_folder() / kind).glob("*.yaml"))
TAG = re.compile(r"\[([A-Za-z]+)\]")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(\.\d+)?(e[-+]?\d+)?(?![\w.])")
LISTS = ("thrusters:", "fins:", "sensors:")  # each entry of these lists needs its own source


def defined_tags(text: str) -> set[str]:
    """Return the tags of the sources listed in the file's comments, one per line: `#   [Wu] Wu 2018, ...`."""
    return set(re.findall(r"^#   \[([A-Za-z]+)\] \S", text, re.MULTILINE))


def entries(text: str) -> list[tuple[str, str, str]]:
    """Return the name, values and comments of each top-level key and of each thruster, fin or sensor entry.

    Comments are those on the entry's lines and directly above it. A comment above a list or its first entry applies
    to all entries; one above another entry also applies to the entries that follow without comments of their own.
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
def test_each_value_names_its_source_or_is_assumed(path: Path) -> None:
    assert unsourced(path.read_text()) == []


@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_the_listed_sources_are_those_that_are_used(path: Path) -> None:
    text = path.read_text()
    used = set(TAG.findall(re.sub(r"^#   \[\w+\]", "", text, flags=re.MULTILINE)))
    units = {"m", "kg", "s", "N", "Ah", "V", "ohm"}
    assert used - units == defined_tags(text)


@pytest.mark.parametrize("name", ["mass_kg", "added_mass", "friction", "port", "propeller"])
def test_a_value_without_a_source_is_found(name: str) -> None:
    """Each entry is reported if its comments are removed."""
    vehicle = "remus100" if name in ("port", "propeller") else "bluerov2_wu"
    lines = (assets_folder() / "vehicles" / f"{vehicle}.yaml").read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.strip().startswith(name + ":"))
    lines[at] = lines[at].partition("#")[0]
    while lines[at - 1].lstrip().startswith("#"):
        at -= 1
        lines[at] = ""
    assert name in unsourced("\n".join(lines))
