"""Fixtures of the tests of the station's page in a real browser."""

from contextlib import ExitStack
from functools import cache

import numpy as np
import pytest

OPEN = ExitStack()


@cache
def only_browser():
    """Start Chromium, or return the one that runs."""
    from browser import chromium  # here, since not all tests of the folder need playwright

    return OPEN.enter_context(chromium())


@pytest.fixture(scope="module")
def browser():
    """One Chromium for the whole folder."""
    return only_browser()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """End Chromium with the last test of this folder: its loop would be in the way of others, and so is its memory."""
    if nextitem is None or nextitem.path.parent != item.path.parent:
        OPEN.close()
        only_browser.cache_clear()


@pytest.fixture
def running(browser, tmp_path):
    """A desk with a running simulator."""
    from browser import desk

    with desk(browser, tmp_path, "pool") as found:
        yield found


@pytest.fixture(scope="module")
def here(browser, request, tmp_path_factory):
    """A desk for a whole module, with an undocked vehicle, at the module's START_M if it has one."""
    from browser import desk

    with desk(browser, tmp_path_factory.mktemp("desk"), "pool") as found:
        live = found.station.present().live
        live.rov.undock()
        if hasattr(request.module, "START_M"):
            live.command("place", vehicle="rov", position_world_m=request.module.START_M).result()
        yield found
    assert not found.complaints


@pytest.fixture(scope="module")
def page(here):
    """The pilot's page at that desk."""
    from browser import when

    page = here.fly(viewport={"width": 1440, "height": 1000})
    when(page, "station.station.isPilot && station.views.largeView.picture.drawn > 0")
    return page


@pytest.fixture(scope="session")
def slope():
    """A map of 40 x 20 voxels on a slope that rises to the east."""
    from uwsim.mapping import OccupancyMap

    at = np.indices((40, 20)).reshape(2, -1).T - (19.5, -0.5)
    occupancy = OccupancyMap(1.0)
    occupancy.insert_scan(np.column_stack([at, 0.25 * np.floor(at[:, 0]) - 9.9]), (0.0, 10.0, 30.0))
    assert occupancy.count().occupied == 800
    return occupancy
