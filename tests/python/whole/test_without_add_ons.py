"""The heart works without its add-ons, and what is left without one: `--help`, a survey and tests, in a copy.

Each case copies the package without the rooms of an add-on and of those that need it. UWSIM_WITHOUT_ADD_ONS=all runs
all tests of the heart in each copy, instead of QUICK in the one without any add-on.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tools.module_graph import HEART, PYTHON, ROOT, imported_by, is_in, ring_of, rings

from command_line import error_line, uwsim_in_another_process
from uwsim import _core
from uwsim.base.sockets import Entry, is_offered, registered
from uwsim.flight.survey import run_survey

TESTS = ROOT / "tests/python"
EVERY_TEST = os.environ.get("UWSIM_WITHOUT_ADD_ONS") == "all"
ALL = "all add-ons"
QUICK = (
    "base/test_own_files.py", "scenario/test_trim.py", "mapping/test_outlier_filter.py",
    "navigation/test_navigator.py::test_a_docked_vehicle_stays_where_the_dock_holds_it",
    "instruments/test_sensors.py", "simulator/test_simulator.py", "base/test_polygon.py",
    "missions/test_missions.py", "batch/test_batch.py", "live/test_live_pace.py", "cli/test_flags.py",
)  # fmt: skip
"""Quick tests of each floor."""
ISOLATED = """import sys
sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in type(finder).__module__]
"""
"""sitecustomize.py: the finder of an editable installation would find what the copy lacks."""

SKIPPING = """import pytest
@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.failed and "No module named 'uwsim." in str(report.longrepr):
        report.outcome, report.longrepr = "skipped", (str(item.path), 0, "needs an add-on")
    return report
"""
"""A plugin of pytest: a test that runs an add-on, which its imports do not show, is none of the heart's."""

DESELECTED = (
    "base/test_own_files.py::test_a_second_run_into_one_folder_is_refused",
    "cli/test_cli.py::test_each_command_is_listed_once_under_a_heading",
    "cli/test_cli.py::test_scenarios_are_listed_and_described",
    "cli/test_completion.py::test_commands_options_and_values_are_offered",
    "flight/test_survey_needs.py::test_all_that_is_missing_is_reported_and_nothing_written",
    "mapping/test_map_engines.py::test_the_bench_measures_every_case",
    "scenario/test_scenario_loading.py::test_the_shell_gets_a_line_for_each_mistake",
)
"""Tests of all commands at once, of `scenario check`, and of peers in the build folder."""


def is_gone(module: str, add_on: str) -> bool:
    """Return whether a module is in the rooms of an add-on, or of one that needs it."""
    gone = [ring for name, ring in rings().items() if name != HEART and add_on in {ALL, name} | ring.needs]
    return any(is_in(module, room) for ring in gone for room in ring.rooms)


@pytest.fixture
def environment(tmp_path: Path, add_on: str) -> dict[str, str]:
    """The environment with a copy of the package that lacks an add-on."""

    def lacking(folder: str, names: list[str]) -> list[str]:
        at = Path(folder).relative_to(PYTHON).parts
        return [name for name in names if is_gone(".".join((*at, name.removesuffix(".py"))), add_on)]

    python = tmp_path / "python"
    shutil.copytree(PYTHON / "uwsim", python / "uwsim", ignore=lacking)
    shutil.copy(_core.__file__, python / "uwsim")
    (python / "uwsim/assets").symlink_to(ROOT / "assets")
    (python / "uwsim/bench").symlink_to(ROOT / "tools/bench")
    (python / "sitecustomize.py").write_text(ISOLATED)
    (python / "needs_add_on.py").write_text(SKIPPING)
    return os.environ | {"PYTHONPATH": str(python)}


@pytest.fixture(scope="module")
def map_bytes(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The map of a survey that is flown with all add-ons."""
    out = tmp_path_factory.mktemp("whole")
    run_survey("pool", out, report="none")
    return (out / "map.bt").read_bytes()


def missing_commands(add_on: str) -> dict[str, Entry]:
    """Return the entries that are missing, by their words."""
    groups = ("", *(f"{name} " for name in registered("uwsim.cli") if is_offered(f"uwsim.cli.{name}")))
    found = {
        group + name: entry for group in groups for name, entry in registered(f"uwsim.cli.{group}".rstrip(". ")).items()
    }
    return {words: entry for words, entry in found.items() if is_gone(entry.value.partition(":")[0], add_on)}


def heart_tests() -> list[str]:
    """Return the tests in the heart's rooms that import no add-on, nor a helper module that does."""
    files = [path for room in rings()[HEART].rooms for path in (TESTS / room.partition(".")[2]).glob("test_*.py")]
    return [str(path) for path in sorted(files) if {ring_of(name) for name in imported_from(path)} <= {HEART, None}]


def imported_from(path: Path) -> set[str]:
    """Return the modules of uwsim that a test or its helper modules import."""
    text = path.read_text()
    helpers = [found for found in TESTS.rglob("*.py") if f"from {found.stem} import" in text and found != path]
    return {name for name, _ in imported_by(text)}.union(*map(imported_from, helpers))


@pytest.mark.parametrize("add_on", [*(ring for ring in rings() if ring != HEART), ALL])
def test_the_heart_works_without(add_on: str, environment: dict[str, str], map_bytes: bytes, tmp_path: Path) -> None:
    missing = missing_commands(add_on)
    whole = add_on == ALL or EVERY_TEST  # the rest of the heart finds no more missing than without all of them
    top = [words for words in missing if " " not in words]
    below = [words for words in missing if " " in words and words.split()[0] not in top]
    tried = [*top[:1], *below[:1]]
    commands = [["--help"], *(words.split() for words in tried)]
    commands += [["survey", "pool", "--out", str(tmp_path / "out"), "--report", "none"]] if whole else []
    listed, *others = uwsim_in_another_process(*commands, env=environment)
    assert listed.returncode == 0 and "survey" in listed.stdout
    assert listed.stderr.count("cannot be used: ModuleNotFoundError") == len(listed.stderr.splitlines()) == len(top)
    for words, failed in zip(tried, others, strict=False):
        assert missing[words].value in error_line(failed)

    if not whole:
        return
    assert others[-1].returncode == 0, others[-1].stderr
    assert (tmp_path / "out/map.bt").read_bytes() == map_bytes
    left_out = [f"--deselect=tests/python/{name}" for name in DESELECTED]
    tests = ["-p", "needs_add_on", *heart_tests()] if EVERY_TEST else [str(TESTS / name) for name in QUICK]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *left_out, *tests]
    tested = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment)
    assert tested.returncode == 0, tested.stdout
