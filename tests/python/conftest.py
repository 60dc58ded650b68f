"""Settings for all tests: Hypothesis uses the same examples in every run; figures are small and open no window."""

import ctypes
import gc
import os
import sys
from collections.abc import Generator, Iterator

import pytest
from hypothesis import settings
from matplotlib.figure import Figure

from processor_seconds import ProcessorSeconds
from uwsim import _core
from uwsim.figures import style, truth_and_map
from uwsim.scenario import build_world, load

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ["UWSIM_LOGBOOK"] = ""  # attempts in tests are not the user's
settings.register_profile("uwsim", derandomize=True, deadline=None, database=None)
settings.load_profile("uwsim")


def pytest_configure(config: pytest.Config) -> None:
    """Measure the processor time of the tests."""
    config.pluginmanager.register(ProcessorSeconds())


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Exclude the modules and the tests themselves from garbage collections, which would take 8 % of a run's time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(autouse=True, scope="session")
def shared_trees() -> Iterator[None]:
    """Keep the lake's ray trees, which take a second to build and are shared by all simulators of it, in a full run."""
    kept = _core.RayScene(build_world(load("lake"))) if "PYTEST_XDIST_WORKER" in os.environ else None
    yield
    del kept


@pytest.fixture(autouse=True, scope="module")
def small_memory() -> Iterator[None]:
    """Return what a file's tests have freed to the system, which otherwise stays with the process."""
    yield
    gc.collect()
    if sys.platform == "linux" and hasattr(libc := ctypes.CDLL(None), "malloc_trim"):
        libc.malloc_trim(0)


@pytest.fixture(autouse=True)
def small_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shrink the truth and map views in reports, which take most of a report's time; subprocesses use the full size."""
    monkeypatch.setattr(truth_and_map, "PANEL_PIXELS", 160)


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clear figures before they are saved, for tests of the other outputs."""

    def clear(figure: Figure, canvas: object) -> None:
        figure.clear()

    monkeypatch.setattr(style, "_fit", clear)
