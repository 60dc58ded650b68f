"""Settings for all tests: Hypothesis uses the same examples in every run; figures are small and open no window."""

import ctypes
import gc
import os
import signal
import sys
from collections.abc import Generator, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from matplotlib.figure import Figure
from numpy.typing import NDArray

from processor_seconds import ProcessorSeconds
from uwsim import _core
from uwsim.figures import style, truth_and_map
from uwsim.scenario import build_world, load
from uwsim.scenario.build.hydrodynamics import added_mass_of_ellipsoid

os.environ.setdefault("MPLBACKEND", "Agg")
MAY_GROW_BYTES, KEPT_BYTES = 100 << 20, [0]
settings.register_profile("uwsim", derandomize=True, deadline=None, database=None)
settings.load_profile("uwsim")


def pytest_configure(config: pytest.Config) -> None:
    """Measure the processor time of the tests; Ctrl-C ends what they start, also in a run in the background."""
    config.pluginmanager.register(ProcessorSeconds())
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


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


@pytest.fixture
def panels_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Use the added mass of an ellipsoid, since panels take seconds."""

    def of_ellipsoid(hull_m: NDArray[np.float64], _: object, density_kg_m3: float) -> tuple[NDArray[np.float64], str]:
        return np.diag(added_mass_of_ellipsoid(np.ptp(hull_m, axis=0) / 2, density_kg_m3)), ""

    for module in ("exchange.hulls.draft", "evidence.vehicle.estimates"):
        monkeypatch.setattr(f"uwsim.{module}.added_mass_by_steps", of_ellipsoid)


@pytest.fixture(autouse=True)
def small_memory() -> Iterator[None]:
    """Return what tests have freed to the system once a process has grown; worlds wait for it in circles of objects."""
    yield
    if sys.platform == "linux" and resident_bytes() > KEPT_BYTES[0] + MAY_GROW_BYTES:
        gc.collect()
        if hasattr(libc := ctypes.CDLL(None), "malloc_trim"):
            libc.malloc_trim(0)
        KEPT_BYTES[0] = resident_bytes()


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


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
