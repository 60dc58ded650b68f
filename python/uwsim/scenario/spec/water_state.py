"""Derives missing values of density, temperature and salinity (EOS-80), and checks that specified values agree."""

from __future__ import annotations

from typing import NamedTuple

from uwsim import _core

TOLERANCE_KG_M3 = 5.0
"""Largest accepted difference between a specified density and that derived from temperature and salinity. Fresh water
rounded to 1000 kg/m3 is off by up to 4.4 from 0 to 30 deg C, sea water of 35 psu rounded to 1025 by up to 3.3, and a
density measured in place 1 km down by 4.6. Sea water mistaken for fresh water is off by 26."""
SALTIEST_PSU = 45.0
DEEPEST_M = 12_000.0
_PA_PER_M = 1e4


class WaterState(NamedTuple):
    """The properties of a body of water as specified in a scenario. density_kg_m3, salinity_psu: None if derived.

    temperatures_deg_c: temperatures at its upper and lower end. depth_m: depth at which the density may have been
    measured; 0 for densities at atmospheric pressure.
    """

    density_kg_m3: float | None
    salinity_psu: float | None
    temperatures_deg_c: tuple[float, ...]
    depth_m: float = 0.0

    @property
    def salinity(self) -> float:
        """The salinity [psu] as specified, else 0 if the density matches fresh water, else derived from the density."""
        if self.salinity_psu is not None:
            return self.salinity_psu
        if self.density_kg_m3 is None or self.density_kg_m3 <= self._at_top(0.0) + TOLERANCE_KG_M3:
            return 0.0
        low, high = 0.0, SALTIEST_PSU
        while high - low > 1e-9:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._at_top(middle) < self.density_kg_m3 else (low, middle)
        return high

    @property
    def density(self) -> float:
        """The specified density, else the density at the first temperature and the salinity [kg/m3]."""
        return self._at_top(self.salinity) if self.density_kg_m3 is None else self.density_kg_m3

    @property
    def broken_rule(self) -> str:
        """The rule broken by the density at the specified salinity, or an empty string."""
        if self.density_kg_m3 is None or self.salinity_psu is None:
            return ""
        low, high = self._density_of(self.salinity_psu)
        if low - TOLERANCE_KG_M3 <= self.density_kg_m3 <= high + TOLERANCE_KG_M3:
            return ""
        return (
            f"must be within {TOLERANCE_KG_M3:g} kg/m3 of {_span(low, high)} kg/m3, which salinity_psu = "
            f"{self.salinity_psu:g} psu gives at {_span(*sorted(self.temperatures_deg_c))} deg C; leave one of them out"
        )

    def _at_top(self, salinity_psu: float) -> float:
        return _core.sea_water_density_kg_m3(self.temperatures_deg_c[0], salinity_psu)

    def _density_of(self, salinity_psu: float) -> tuple[float, float]:
        """Return the smallest density of water of this salinity, and the largest, which occurs under pressure."""
        pressure_pa = _PA_PER_M * self.depth_m
        return (
            min(_core.sea_water_density_kg_m3(t, salinity_psu) for t in self.temperatures_deg_c),
            max(_core.sea_water_density_kg_m3(t, salinity_psu, pressure_pa) for t in self.temperatures_deg_c),
        )


def _span(*ends: float) -> str:
    low, high = f"{ends[0]:.5g}", f"{ends[-1]:.5g}"
    return low if low == high else f"{low} to {high}"
