"""Settings for all tests: Hypothesis tries the same examples on every run; figures are small and open no window."""

import os

import pytest
from hypothesis import settings
from matplotlib.figure import Figure

from uwsim.figures import style, truth_and_map

os.environ.setdefault("MPLBACKEND", "Agg")
settings.register_profile("uwsim", derandomize=True, deadline=None, database=None)
settings.load_profile("uwsim")


@pytest.fixture(autouse=True)
def small_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let reports show small views of truth and map, which take most of a report's time; processes draw them whole."""
    monkeypatch.setattr(truth_and_map, "PANEL_PIXELS", 160)


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clear figures before they are saved, for tests of what lies beside them."""

    def clear(figure: Figure, canvas: object) -> None:
        figure.clear()

    monkeypatch.setattr(style, "_fit", clear)
