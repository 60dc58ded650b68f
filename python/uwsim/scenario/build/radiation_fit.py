"""Fits a rational function to a table of added mass and radiation damping: the water's memory in Cummins' equation.

The transform of the memory is K(i omega) = B + i omega (A - A_infinite) (Ogilvie 1964, 5th Symposium on Naval
Hydrodynamics). Perez and Fossen (2009, Modeling, Identification and Control 30:1) list what a fit in the frequency
domain must have: no memory of a steady velocity, relative degree one, stability and passivity. The sum over k of (R_k s
+ Q_k) / (s^2 + 2 zeta_k omega_k s + omega_k^2) with the sum of Q_k / omega_k^2 zero has the first three. Its matrices
are found by linear least squares, the frequencies and damping ratios, common to all motions, by nonlinear ones around
them. The real part is constrained to be positive semi-definite; what is left of negative values, R of one wide section,
whose real part is positive everywhere, makes up for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

COUNTS = (3, 4, 5, 6, 8)
"""Numbers of sections tried."""
GOOD = 0.012
"""Error with which no more are tried."""
FLAT = 0.01
"""Values below this share of the largest, with lengths in units of the hull's, are not resolved."""
WIDE = 1.0
"""Damping ratio of the section that makes the sum passive."""
BEYOND = 40.0
"""Passivity is required from the lowest frequency over this to the highest times this."""
FADING = 0.03
"""Weight of frequencies beyond the table in the search of poles."""
ITERATIONS, CLOSE = 600, 1e-4
"""Steps of the search for matrices, and the violation of the constraint at which it ends."""
SINGULAR = 1e14
"""Condition number of the normal equations from which on they have no solution in float64."""


class Fit(NamedTuple):
    """Sections by_speed (n, 6, 6), by_place (n, 6, 6), omega_rad_s (n,), damping_ratio (n,).

    error: the largest difference from K at any frequency of the table, relative to the largest K of the two motions or,
    where that is more, to the impedance of the infinite-frequency added mass.
    """

    by_speed: Array
    by_place: Array
    omega_rad_s: Array
    damping_ratio: Array
    error: float


def fitted(omega_rad_s: Array, memory: Complex, added_mass_infinite: Array, length_m: float) -> Fit:
    """Return the sections that fit K, `memory` (n, 6, 6), symmetric. length_m: half the hull's length.

    At high frequencies K is a small difference of large masses, in which a panel code's errors show: there it counts
    relative to the infinite-frequency added mass.
    """
    scale = np.multiply.outer(scales := _scales(memory, length_m), scales)
    target = memory / scale
    inertia = np.maximum(np.diagonal(added_mass_infinite), 0.0) / scales**2
    moving = np.abs(np.diagonal(target, axis1=1, axis2=2)).max(axis=0) > FLAT**0.5
    weight = 1.0 / np.maximum(1.0, omega_rad_s * float(inertia[moving].min(initial=inertia.max())))
    counts = 1.0 / np.maximum(1.0, np.multiply.outer(omega_rad_s, np.sqrt(np.multiply.outer(inertia, inertia))))
    best = Fit(np.zeros((0, 6, 6)), np.zeros((0, 6, 6)), np.zeros(0), np.zeros(0), math.inf)
    for count in COUNTS:
        sections = _matrices(target, omega_rad_s, weight, _poles(omega_rad_s, target, weight, count))
        if sections is None:
            continue
        found = _passive(omega_rad_s, sections)
        error = float((counts * np.abs(impedance(found, omega_rad_s) - target)).max())
        if error < best.error:
            best = found._replace(error=error)
        if error <= GOOD:
            break
    return best._replace(by_speed=best.by_speed * scale, by_place=best.by_place * scale)


def impedance(fit: Fit, omega_rad_s: Array) -> Complex:
    """Return K of the sections at frequencies, (n, 6, 6)."""
    s = 1j * omega_rad_s[:, None]
    below = s**2 + 2.0 * fit.damping_ratio * fit.omega_rad_s * s + fit.omega_rad_s**2
    return np.asarray(
        np.einsum("nk,kij->nij", s / below, fit.by_speed) + np.einsum("nk,kij->nij", 1.0 / below, fit.by_place),
        np.complex128,
    )


def _scales(memory: Complex, length_m: float) -> Array:
    """Return the square roots of the largest values of K, (6,), at least those that matter for a hull of this size."""
    natural = np.array([1.0, 1.0, 1.0, length_m, length_m, length_m])
    own = np.abs(np.diagonal(memory, axis1=1, axis2=2)).max(axis=0)
    return np.asarray(np.sqrt(np.maximum(own, FLAT * (own / natural**2).max() * natural**2)), np.float64)


def _basis(omega_rad_s: Array, poles: Array) -> Complex:
    """Return the functions (n, 2 count - 1) that vanish at 0. poles: (count, 2), logarithms of frequency and ratio."""
    at, ratio = np.exp(poles).T
    s = 1j * omega_rad_s[:, None]
    below = s**2 + 2.0 * ratio * at * s + at**2
    steady = at**2 / below
    return np.asarray(np.concatenate([at * s / below, steady[:, 1:] - steady[:, :1]], axis=1), np.complex128)


def _stacked(values: Complex) -> Array:
    return np.concatenate([values.real, values.imag])


def _poles(omega_rad_s: Array, target: Complex, weight: Array, count: int) -> Array:
    """Return frequencies and ratios (count, 2) with which least squares fit K best, as logarithms.

    Beyond the table, where the real part must fade, it is fitted to 0.
    """
    from scipy.optimize import least_squares

    upper = np.triu_indices(6)
    wanted = _stacked(weight[:, None] * target[:, upper[0], upper[1]])
    wanted = wanted[:, np.abs(wanted).max(axis=0) > FLAT]
    outside, by_wide = _outside(omega_rad_s)
    wanted = np.concatenate([wanted, np.zeros((len(outside), wanted.shape[1]))])

    def misfit(flat: Array) -> Array:
        poles = flat.reshape(count, 2)
        fading = FADING * by_wide[:, None] * _basis(outside, poles).real
        basis = np.concatenate([_stacked(weight[:, None] * _basis(omega_rad_s, poles)), fading])
        orthonormal, _ = np.linalg.qr(basis)
        return np.asarray(wanted - orthonormal @ (orthonormal.T @ wanted), np.float64).ravel()

    size = np.abs(np.diagonal(target, axis1=1, axis2=2)).sum(axis=1)
    share = np.cumsum(size) / size.sum()
    first = np.interp((np.arange(count) + 0.5) / count, share, np.log(omega_rad_s))
    low, high = np.log(omega_rad_s[0]), np.log(1.3 * omega_rad_s[-1])
    bounds = np.tile([low, np.log(0.15)], count), np.tile([high, np.log(1.5)], count)
    start = np.clip(np.column_stack([first, np.full(count, np.log(0.5))]).ravel(), bounds[0] + 1e-6, bounds[1] - 1e-6)
    found = least_squares(misfit, start, bounds=bounds, max_nfev=80, x_scale=0.3)
    return np.asarray(found.x.reshape(count, 2), np.float64)


def _wide(omega_rad_s: Array, middle_rad_s: float) -> Array:
    """Return the real part of the wide section, s / (s^2 + 2 WIDE omega s + omega^2)."""
    s = 1j * omega_rad_s
    return np.asarray((s / (s**2 + 2.0 * WIDE * middle_rad_s * s + middle_rad_s**2)).real, np.float64)


def _middle(omega_rad_s: Array) -> float:
    return float(np.sqrt(omega_rad_s[0] * omega_rad_s[-1]))


def _outside(omega_rad_s: Array) -> tuple[Array, Array]:
    """Return frequencies beyond the table, and weights with which the real part fades as that of the wide section."""
    low, high = omega_rad_s[0], omega_rad_s[-1]
    outside = np.concatenate([np.geomspace(low / BEYOND, 0.9 * low, 12), np.geomspace(1.1 * high, high * BEYOND, 12)])
    return outside, 1.0 / (_wide(outside, _middle(omega_rad_s)) * _middle(omega_rad_s))


def _matrices(target: Complex, omega_rad_s: Array, weight: Array, poles: Array) -> Fit | None:
    """Return the sections of least squares whose real part is nowhere negative, as nearly as ITERATIONS find them.

    None where poles coincide, so that sections coincide too: what follows would be rounding errors.

    By alternating directions (Boyd et al. 2011, Foundations and Trends in Machine Learning 3:1, sec. 3.1): the real
    part over that of the wide section, at frequencies far beyond the table as well, must be positive semi-definite.
    """
    count = len(poles)
    at, ratio = np.exp(poles).T
    basis = _stacked(weight[:, None] * _basis(omega_rad_s, poles))
    grid = np.geomspace(omega_rad_s[0] / BEYOND, omega_rad_s[-1] * BEYOND, 120)
    real = _basis(grid, poles).real / (_wide(grid, _middle(omega_rad_s)) * _middle(omega_rad_s))[:, None]
    rho = np.trace(basis.T @ basis) / np.trace(real.T @ real)
    normal = basis.T @ basis + rho * real.T @ real
    if not np.linalg.cond(normal) < SINGULAR:
        return None
    inverse = np.linalg.inv(normal)
    wanted = basis.T @ _stacked(weight[:, None, None] * target).reshape(len(basis), 36)
    positive = dual = np.zeros((len(grid), 36))
    found = np.zeros((2 * count - 1, 36))
    for _ in range(ITERATIONS):
        found = inverse @ (wanted + rho * real.T @ (positive - dual))
        reached = real @ found
        values, vectors = np.linalg.eigh((reached + dual).reshape(-1, 6, 6))
        positive = ((vectors * np.maximum(values, 0.0)[:, None, :]) @ vectors.transpose(0, 2, 1)).reshape(-1, 36)
        dual = dual + reached - positive
        if np.abs(reached - positive).max() < CLOSE:
            break
    terms = found.reshape(-1, 6, 6)
    terms = 0.5 * (terms + terms.transpose(0, 2, 1))
    by_steady = np.concatenate([-terms[count:].sum(axis=0)[None], terms[count:]])
    return Fit(terms[:count] * at[:, None, None], by_steady * (at**2)[:, None, None], at, ratio, 0.0)


def _passive(omega_rad_s: Array, fit: Fit) -> Fit:
    """Return the sections and a wide one that makes up for negative real parts, as little as that takes."""
    grid = np.geomspace(omega_rad_s[0] / BEYOND, omega_rad_s[-1] * BEYOND, 2000)
    middle = _middle(omega_rad_s)
    wide = _wide(grid, middle)
    lacking = np.linalg.eigvalsh(impedance(fit, grid).real)[:, 0] / wide
    amount = 1.02 * max(0.0, float(-lacking.min()))
    return Fit(
        np.concatenate([fit.by_speed, amount * np.eye(6)[None]]),
        np.concatenate([fit.by_place, np.zeros((1, 6, 6))]),
        np.append(fit.omega_rad_s, middle),
        np.append(fit.damping_ratio, WIDE),
        0.0,
    )
