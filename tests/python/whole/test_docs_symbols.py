"""Paths, symbols and options in back-ticks in the pages exist."""

import re
import subprocess
import tomllib
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

import pytest
import typer

from docs_pages import PAGES, ROOT
from uwsim.cli.program import app

TEXTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "SECURITY.md", *PAGES, *sorted(ROOT.glob("cpp/**/*.md"))]
SOURCES = {".py", ".pyi", ".h", ".cpp", ".cmake", ".js", ".css", ".j2", ".toml", ".yml", ".md", ".svg"}
FOLDERS = {"python", "cpp", "tests", "tools", "docs", "assets", ".ci", ".github"}

OTHERS: dict[str, set[str]] = {
    "coming-from": {  # names from the other simulators
        "AcousticBeaconSensor",
        "DepthSensor",
        "OpticalModemSensor",
        "ProfilingSonar",
        "SidescanSonar",
        'holoocean.make("...")',
        "stonefish_simulator",
        "uuv_sensor_ros_plugins",
        "uuv_thruster_manager",
    },
    "ardupilot": {"pause_mission", "return_to_launch"},  # of pymavlink, MAVSDK
    "conventions": {"rate_body_rad_s"},  # a name constructed from the rule
    "datasets": {  # output of the command
        "_val",
        "arrays/",
        "classes/",
        "depth/",
        "instances/",
        "labels/",
        "multibeam/",
        "normals/",
        "sonar_arrays/",
        "sonar_classes/",
        "sonar_instances/",
    },
    "install": {"manylinux_2_35", "manylinux_2_39", "manylinux_2_NN"},  # wheel tags
    "maps": {"octomap_rviz_plugins", "read_point_cloud"},  # from ROS and Open3D
    "missions": {"out/"},
    "moos": {"speed_factor", "start_pos", "terse_reports"},  # of pMarinePID, uSimMarine, pNodeReporter
    "props": {"blue_drum_floor"},  # of the page's example
    "recording": {"uwsim.end"},  # name of a record
    "ros1": {"octomap_rviz_plugins"},
    "ros2": {"rqt_console"},  # from ROS 2
    "sweeps": {"runs/"},
    "troubleshooting": {"octomap_rviz_plugins"},
}
"""By page: names from other programs, and files created by the page's reader or by a command."""


@cache
def files() -> list[PurePosixPath]:
    """Return the project's files: those tracked by git, plus untracked ones that are not ignored."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    return [PurePosixPath(name) for name in names if (ROOT / name).is_file()]


@cache
def tails() -> set[str]:
    """Return every partial path by which a file or folder may be written, starting at any folder above it."""
    paths = {path for file in files() for path in (file, *file.parents[:-1])}
    return {"/".join(path.parts[start:]) for path in paths for start in range(len(path.parts))}


def words_of(file: PurePosixPath) -> set[str]:
    return set(re.findall(r"[A-Za-z_]\w*", f"{file} {(ROOT / file).read_text(errors='ignore')}"))


@cache
def words() -> set[str]:
    """Return every word in the sources, the assets and their names."""
    ours = [file for file in files() if file.suffix in SOURCES - {".md"} or file.parts[0] in {"tools", ".ci"}]
    ours += [file for file in files() if file.match("assets/props/*.yaml")]
    ours = [file for file in ours if not file.match("test_docs_symbols.py")]
    return set().union(*map(words_of, ours))


def options_of(command: Any) -> set[str]:
    """Return the options of a command and its subcommands."""
    own = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    return own.union(*map(options_of, getattr(command, "commands", {}).values()))


@cache
def options() -> set[str]:
    """Return the options of `uwsim`, and every option that another source names."""
    ours = [
        file for file in files() if file.parts[0] in FOLDERS - {"docs", "assets"} and not file.match("test_docs_*.py")
    ]
    texts = [(ROOT / file).read_text(errors="ignore") for file in ours]
    named = {name for text in texts for name in re.findall(r"--[a-z][\w-]*", text)}
    return named | options_of(typer.main.get_command(app))


def exists(path: str) -> bool:
    """Return True if the project has this path, which may contain wildcards. Files that git ignores do not count."""
    path = path.rstrip("/").removeprefix("../").removeprefix("./")
    if "*" in path:
        return any(file.match(path) for file in files())
    return path in tails()


def is_path(text: str) -> bool:
    path = PurePosixPath(text)
    in_folder = any(path.is_relative_to(folder) for folder in FOLDERS)
    return in_folder or path.suffix in SOURCES or bool(re.fullmatch(r"[a-z_]+(/[a-z_]+)*/", text))


def missing_names(symbol: str) -> set[str]:
    """Return the parts of a dotted name found in no source; after one of our modules, those the module lacks."""
    parts = symbol.split(".")
    if parts[0] != "uwsim":
        return set(parts) - words()
    folder, known = ROOT / "python/uwsim", words()
    for index, part in enumerate(parts[1:], start=1):
        if (folder / part).is_dir():
            folder = folder / part
        else:
            modules = [folder / f"{part}{suffix}" for suffix in (".py", ".pyi")]
            home = next(filter(Path.is_file, modules), folder / "__init__.py")
            rest = parts[index + 1 :] if home.stem == part else parts[index:]
            return (set(rest[:1]) - words_of(PurePosixPath(home.relative_to(ROOT)))) | (set(rest[1:]) - known)
    return set()


@cache
def groups() -> set[str]:
    """Return the groups of entry points."""
    return set(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"])


def dead(text: str) -> bool:
    """Return True if a text in back-ticks refers to something that does not exist."""
    if text in groups():
        return False
    if re.fullmatch(r"--[a-z][\w-]*", text):
        return text not in options()
    if re.fullmatch(r"[\w.*-]+(/[\w.*-]+)*/?", text) and is_path(text):
        return not exists(text)
    symbol = re.sub(r"\(.*\)$", "", text.replace("::", "."))
    named = re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", symbol) and not symbol.endswith("_")  # a prefix
    return bool(named and re.search(r"[._]|[a-z][A-Z]|\)$", text) and missing_names(symbol))


def back_ticked(page: Path) -> set[str]:
    prose = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    return set(re.findall(r"(?<!`)`([^`\n]+)`(?!`)", prose))


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_what_is_in_back_ticks_exists(page: Path) -> None:
    others = OTHERS.get(page.stem if page.is_relative_to(ROOT / "docs") else "", set())
    found = {text for text in back_ticked(page) if dead(text)}
    assert sorted(found - others) == []
    assert sorted(others - found) == [], "allowed without need"


@pytest.mark.parametrize(
    "text", ["gone.h", "vehicle/gone.h", "uwsim.gone", "uwsim.mapping.Gone", "GoneClass", "gone_one()", "--gone"]
)
def test_a_dead_reference_is_found(text: str) -> None:
    assert dead(text)


def test_no_page_has_cpp_that_is_not_compiled() -> None:
    assert [page.name for page in TEXTS if "```cpp" in page.read_text()] == []


def test_the_table_of_changes_names_a_path_in_each_row() -> None:
    table = (ROOT / "CONTRIBUTING.md").read_text().partition("| I want to change | look here |\n|---|---|\n")[2]
    rows = table.partition("\n\n")[0].splitlines()
    assert len(rows) >= 30
    assert [row for row in rows if not any(map(is_path, re.findall(r"`([^`]+)`", row)))] == []


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page: of its headings down to the third level, and its explicit ones."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#{1,3} (.*)$", text, flags=re.MULTILINE)
    slugs = {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}
    return slugs | set(re.findall(r"^\((.*)\)=$", text, flags=re.MULTILINE))


@pytest.mark.parametrize("page", [*TEXTS, ROOT / "CHANGELOG.md"], ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_resolve(page: Path) -> None:
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if link.startswith("http") or path.endswith(("validation/index.md", "reference/benchmarks.md")):  # made later
            continue
        if not target.exists() or (anchor and anchor not in anchors(target)):
            broken.append(link)
    assert broken == []


def test_files_that_commands_leave_in_the_clone_do_not_count() -> None:
    assert (ROOT / "build/js").is_dir()  # made by tools/setup, ignored by git, as is the `out/` of tools/demo
    assert dead("build/js/")
