"""The slow horizontal force that a step lacks of the mean drift of a floating hull in waves.

The table has the mean drift D of a free hull in regular waves per squared metre of amplitude: by the momentum that it
sends away with its waves (Maruo 1960, J. Ship Research 4(3):1; Newman 1967, J. Ship Research 11:51), or by the pressure
on it (Pinkster 1980, "Low frequency second order wave exciting forces on floating structures"). A step has a mean force
of its own: it takes the undisturbed waves' pressure at the hull's actual place and surface, and turns the other forces
with the hull, but has no squares of the waves that the hull makes. That force is computed here as a step would: the
hull is led along its first-order motion in small waves, and the mean is taken over a period. Both have the same order,
so that their difference is exact to second order; larger waves and drag, which change the motion, are not in it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.hull import RigidBody
from uwsim.scenario.build.radiation_hull import DIVISIONS, SMALL, UprightHull
from uwsim.scenario.build.short_waves import wave_numbers_rad_m
from uwsim.scenario.read.radiation_table import RadiationTable

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HORIZONTAL = (0, 1, 5)
"""Surge, sway and yaw among the six axes."""
QUARTERS = 4
"""Instants of a period: enough for means of second order."""


def own_drift(
    table: RadiationTable,
    hull: UprightHull,
    body: RigidBody,
    model: _core.Radiation,
    density_kg_m3: float,
    omega_rad_s: Array,
) -> Array:
    """Return the mean force of a step without drift, (DIVISIONS, frequencies, the table's headings, 3).

    Along x and y [N/m2] and about z through the origin [N/m], per squared metre of amplitude.
    """
    found = np.empty((DIVISIONS, len(omega_rad_s), len(table.heading_rad), 3))
    numbers = wave_numbers_rad_m(omega_rad_s, table.water_depth_m, table.gravity_m_s2)
    for division in range(DIVISIONS):
        led = _LedHull(table, hull, body, model, density_kg_m3, division)
        for row, (omega, number) in enumerate(zip(omega_rad_s, numbers, strict=True)):
            found[division, row] = led.mean_forces(float(omega), float(number))
    return found


class _LedHull:
    """A hull without drag in one division into slices that is led along its first-order motion."""

    def __init__(
        self, table: RadiationTable, hull: UprightHull, body: RigidBody, model: _core.Radiation,
        density_kg_m3: float, division: int,
    ) -> None:  # fmt: skip
        own = _core.CraftParameters()
        own.mass_kg, own.inertia_kg_m2 = body.mass_kg, np.diag(body.inertia_kg_m2)
        own.centre_of_mass_body_m, own.radiation = body.centre_of_mass_m, model
        self._craft = _core.Craft(own, hull.vertices_m, hull.triangles, division)
        self._table, self._model, self._division = table, model, division
        self._surface_m, self._small_m = np.array([0.0, 0.0, hull.waterline_m]), SMALL * hull.half_length_m
        self._water = _core.Water()
        self._water.density_kg_m3, self._water.gravity_m_s2 = density_kg_m3, table.gravity_m_s2
        still = np.zeros(6)
        at_rest = self._rate(still, still, still, 0.0)
        self._mass = np.linalg.inv(
            np.column_stack([self._rate(still, still, push, 0.0) - at_rest for push in np.eye(6)])
        )
        steps = self._small_m / np.array([1.0, 1.0, 1.0, *[hull.half_length_m] * 3])
        moved = [
            self._force(-step, still, still, 0.0) - self._force(step, still, still, 0.0) for step in np.diag(steps)
        ]
        self._stiffness = np.column_stack(moved) / (2.0 * steps)

    def mean_forces(self, omega_rad_s: float, number_rad_m: float) -> Array:
        """Return the mean wrenches in regular waves, (the table's headings, 3), per squared metre of amplitude."""
        memory = np.conj(self._model.impedance(1j * omega_rad_s))
        dynamic = -(omega_rad_s**2) * self._mass - 1j * omega_rad_s * memory + self._stiffness
        each = [
            self._mean_force(omega_rad_s, number_rad_m, float(heading), memory, dynamic)
            for heading in self._table.heading_rad
        ]
        return np.array(each)

    def _mean_force(
        self, omega_rad_s: float, number_rad_m: float, heading_rad: float, memory: Complex, dynamic: Complex
    ) -> Array:
        """Return that of one heading. memory, dynamic: (6, 6), what the waves that it makes, and its motion, need."""
        self._water.waves = _core.Waves.airy(
            self._small_m, 2.0 * np.pi / omega_rad_s, heading_rad, depth_m=self._table.water_depth_m,
            gravity_m_s2=self._table.gravity_m_s2,
        )  # fmt: skip
        quarter_s, still = 2.0 * np.pi / omega_rad_s / QUARTERS, np.zeros(6)
        held = [self._force(still, still, still, k * quarter_s) for k in range(QUARTERS)]
        pressure = (held[0] - held[2] + 1j * (held[1] - held[3])) / (2.0 * self._small_m)
        exciting = pressure + self._model.diffraction(omega_rad_s, heading_rad, self._division)
        motion = self._small_m * np.linalg.solve(dynamic, exciting)
        ahead = number_rad_m * np.array([np.cos(heading_rad), np.sin(heading_rad)])
        total = np.zeros(6)
        for k in range(QUARTERS):
            turn = (-1j) ** k
            place, speed, radiated = (
                np.asarray((each * turn).real, np.float64)
                for each in (motion, -1j * omega_rad_s * motion, 1j * omega_rad_s * memory @ motion)
            )
            wave = self._small_m * turn * np.exp(1j * ahead @ place[:2])
            level = (wave * self._model.diffraction(omega_rad_s, heading_rad - place[5], self._division)).real
            total += self._force(place, speed, radiated + _seen_from(place, level), k * quarter_s)
        return np.asarray(total[list(HORIZONTAL)] / (QUARTERS * self._small_m**2), np.float64)

    def _rate(self, place: Array, speed: Array, push: Array, time_s: float) -> Array:
        """Return the acceleration at a small displacement."""
        half = 0.5 * place[3:]
        turned = (*half, np.sqrt(1.0 - half @ half))
        at = _core.BodyState(place[:3] - self._surface_m, turned, speed)
        return np.asarray(self._craft.acceleration_body(at, push, self._water, time_s), np.float64)

    def _force(self, place: Array, speed: Array, push: Array, time_s: float) -> Array:
        return np.asarray(self._mass @ self._rate(place, speed, push, time_s), np.float64)


def _seen_from(place: Array, level: Array) -> Array:
    """Return a wrench in level axes that the hull heads along in those of the hull, to first order of its tilt."""
    roll, pitch = place[3], place[4]
    turn = np.array([[1.0, 0.0, -pitch], [0.0, 1.0, roll], [pitch, -roll, 1.0]])
    return np.asarray(level.reshape(2, 3) @ turn.T, np.float64).ravel()
