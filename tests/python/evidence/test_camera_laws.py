"""The optical laws, which tools/docs checks, are missed by a coefficient that is five percent off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from uwsim import _core
from uwsim.evidence.validate import camera
from uwsim.evidence.validate.check import Check
from uwsim.scenario.spec.optics import Optics


def failed(checks: list[Check]) -> list[str]:
    return [f"{c.group}, {c.name}: expected {c.expected}, got {c.got}, error {c.error}" for c in checks if not c.passed]


@pytest.mark.mutation
@pytest.mark.parametrize(
    ("law", "coefficient"),
    [
        (camera.wall_against_range, "absorption"),
        (camera.wall_against_range, "scattering"),
        (camera.sunlight_against_depth, "diffuse_attenuation"),
        (camera.lamp_against_distance, "absorption"),
        (camera.lamp_against_distance, "scattering"),
        (camera.refraction_at_the_surface, "refractive_index"),
    ],
)
def test_a_coefficient_five_percent_off_fails_the_check(
    law: Callable[[], list[Check]], coefficient: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def off(light: camera.Light) -> _core.Optics:
        water = light.water
        names = ("diffuse_attenuation", "absorption", "scattering")
        factor = 0.95 if coefficient == "absorption" else 1.05  # absorption above Kd would be refused
        values = [np.asarray(getattr(water, name)) * (factor if name == coefficient else 1) for name in names]
        index = water.refractive_index * (1.05 if coefficient == "refractive_index" else 1)
        changed = _core.WaterOptics(*values, index)
        return _core.Optics(changed, float(np.radians(light.sun_deg)), 0.7, 0.0, 0.0, 0.0, 0.0)

    monkeypatch.setattr(camera.Light, "optics", property(off))
    assert failed(law())


@pytest.mark.mutation
def test_a_distortion_five_percent_off_fails_the_check(monkeypatch: pytest.MonkeyPatch) -> None:
    lens = _core.Lens

    def off(*arguments: object) -> _core.Lens:
        *rest, distortion = arguments
        return lens(*rest, [1.05 * k for k in distortion])  # type: ignore[attr-defined, arg-type]

    monkeypatch.setattr(_core, "Lens", off)
    assert failed(camera.checkerboard_corners())


@pytest.mark.parametrize("jerlov", ["I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C"])
def test_daylight_is_attenuated_by_at_least_the_absorption(jerlov: str) -> None:
    water = _core.WaterOptics.jerlov(jerlov)
    assert np.all(np.asarray(water.diffuse_attenuation) >= np.asarray(water.absorption))


def test_water_that_absorbs_more_than_it_attenuates_is_refused() -> None:
    rule = r"must be at most diffuse_attenuation\[2\] = 0\.2 1/m"
    with pytest.raises(ValueError, match=rf"coefficients\.absorption\[2\] = 0\.3 1/m: {rule}"):
        Optics().with_changes(
            {
                "coefficients": {
                    "diffuse_attenuation": [0.5, 0.2, 0.2],
                    "absorption": [0.5, 0.1, 0.3],
                    "scattering": [0.1, 0.1, 0.1],
                }
            }
        )
