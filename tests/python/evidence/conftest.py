"""Shared by the tests of evidence: drafts and reports of vehicles without panels."""

import numpy as np
import pytest
from numpy.typing import NDArray

from uwsim.scenario.build.potential_flow import added_mass_of_ellipsoid


@pytest.fixture
def panels_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Use the added mass of an ellipsoid, since panels take seconds."""

    def of_ellipsoid(hull_m: NDArray[np.float64], _: object, density_kg_m3: float) -> tuple[NDArray[np.float64], str]:
        return np.diag(added_mass_of_ellipsoid(np.ptp(hull_m, axis=0) / 2, density_kg_m3)), ""

    for module in ("draft", "estimates"):
        monkeypatch.setattr(f"uwsim.evidence.vehicle.{module}.added_mass_by_steps", of_ellipsoid)
