"""Surveys that the tests of raw files share."""

import pytest

from flown_survey import Flown


@pytest.fixture(scope="session")
def bent(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """A survey by rays that bend, with errors of ranges, and its .kmall."""
    return Flown(tmp_path_factory.mktemp("bent"), "survey.kmall", ", mode: physics, bending: true")


@pytest.fixture(scope="session")
def straight(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """A survey by exact straight rays, and its .xtf."""
    return Flown(tmp_path_factory.mktemp("straight"), "survey.xtf")
