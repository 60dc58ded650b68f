"""Water by its visibility: the distance at which a diver sees a dark object, and water scaled to one."""

from __future__ import annotations

from uwsim import _core


def visibility_m(water: _core.WaterOptics) -> float:
    """Return the distance at which a diver can see a dark object horizontally: 4.8 / c, with c [1/m] at 550 nm.

    Zaneveld and Pegau 2003, "Robust underwater visibility parameter", Optics Express 11, which gives the factor for 532
    nm.
    """
    return 4.8 / float(water.beam_attenuation[1])


def scaled_to(visibility: float | None, water: _core.WaterOptics) -> _core.WaterOptics:
    """Return the water with all coefficients scaled alike to a visibility [m], or itself for None.

    Raises ValueError if a coefficient would leave the core's range.
    """
    if visibility is None:
        return water
    share = visibility_m(water) / visibility
    return _core.WaterOptics(share * water.diffuse_attenuation, share * water.absorption, share * water.scattering)
