"""Surveys that the tests of raw files share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from flown_survey import Flown  # imported below, where it is used: other tests here go without its add-ons


@pytest.fixture(scope="session")
def bent(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """A survey by rays that bend, with errors of ranges, and its .gsf."""
    from flown_survey import Flown

    return Flown(tmp_path_factory.mktemp("bent"), "survey.gsf", ", mode: physics, bending: true")


@pytest.fixture(scope="session")
def straight(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """A survey by exact straight rays, and its .xtf."""
    from flown_survey import Flown

    return Flown(tmp_path_factory.mktemp("straight"), "survey.xtf")
