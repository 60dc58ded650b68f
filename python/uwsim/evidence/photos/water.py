"""The attenuation of water from the colours of points that are seen from many distances.

The light of a point at the distance r is, in each band, J exp(-c r) + B (1 - exp(-k r)): its own light J, which the
water attenuates by c, and the daylight B that the water scatters into the ray (Akkaynak and Treibitz 2018, "A revised
underwater image formation model", CVPR). Since daylight falls with depth by exp(-K depth), the latter saturates at
k = c - K u, where u is the upward part of the ray's direction, and B falls with the depth of the camera. B depends on
the ray's direction, too, here as spherical harmonics up to the degree 2; and so does J, by a factor that is the same
for all points and bands, since a rough bed is darker where it is seen from low than from above. Each picture has its
own exposure, common to all bands, and each camera its vignetting.

All of them are fitted at once to the logarithms of the pixels, by Levenberg and Marquardt's method with Cauchy's
weights against fish, shadows and mismatches. J is one unknown per point and band, so neither the colour of the bed nor
that of the daylight is assumed; a point must be seen from different distances. Valid in daylight, with lamps off, and
where pictures have one white balance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwsim import _core
from uwsim.evidence.photos.normal_equations import Jacobian, Normal
from uwsim.evidence.photos.reconstruction import Floats, Indices

ROUNDS, GAIN_MIN, DAMPING_FREE, DAMPING_MAX = (12, 12, 40), 1e-7, 1e-6, 1e8
"""Steps at most, in each of the turns that find Kd; a share of the cost by which a step must lessen it,
if it is not damped."""
RELATIVE, DARK = 0.05, 0.5 / 255.0
"""Assumed errors of a pixel: relative, and of half a grey level. Cauchy's scale is a multiple of the residuals'."""
CAUCHY, MAD = 2.385, 1.4826
INTERVAL, CHI_2 = 1.96, 7.81
"""For 95 %: standard deviations of one value, and the square of those of three."""
MODEL = 0.08
"""Assumed standard error of c, as a share, since the model is not exact: on our own pictures it was up to 14 % off."""
SHAPES, SPREAD = 9, 8.0
"""Spherical harmonics. Assumed: the standard deviation of log J from where it starts; it holds points in the dark."""
LOG_MAX = 20.0


@dataclass(frozen=True)
class Sightings:
    """Pixels at which points are seen. light: (m, 3), linear. ways_m: (m, 3), from the camera to the point, world.

    heights_m: (m,) of the cameras. cosines: (m,) of the angle off the optical axis. picture, point: (m,) indices.
    """

    light: Floats
    ways_m: Floats
    heights_m: Floats
    cosines: Floats
    picture: Indices
    point: Indices


@dataclass(frozen=True)
class Attenuation:
    """The fit. c: (3,) per band [1/m]. half: (3,), half of its 95 % interval.

    jerlov: the nearest type, by the fit's own covariance. type_c: its c. alike: the types within the fit's 95 %.
    scatter: the median residual of a pixel's logarithm. count: of pixels.
    """

    c: Floats
    half: Floats
    jerlov: str
    type_c: Floats
    alike: tuple[str, ...]
    scatter: float
    count: int


def type_attenuation(jerlov: str) -> Floats:
    """Return c = a + b of a Jerlov type, (3,) [1/m]."""
    water = _core.WaterOptics.jerlov(jerlov)
    return np.asarray(water.absorption) + np.asarray(water.scattering)


def fit_attenuation(seen: Sightings) -> Attenuation:
    """Return the attenuation. Kd, on which the veil depends weakly, is that of the nearest type, found in three turns.

    An interval is infinite where the pixels do not determine c.
    """
    x, kd, c, scatter = None, np.zeros(3), np.full(3, 1.0), np.inf
    covariance, far = np.full((3, 3), np.inf), dict.fromkeys(_core.jerlov_types(), np.inf)
    for rounds in ROUNDS:
        problem = _Problem(seen, kd)
        try:
            x, covariance, scatter = problem.solved(problem.start() if x is None else x, rounds)
            c = x[problem.c]
            covariance = covariance + np.diag((MODEL * c) ** 2 + 1e-12)
            away = {name: c - type_attenuation(name) for name in far}
            far = {name: float(off @ np.linalg.solve(covariance, off)) for name, off in away.items()}
        except np.linalg.LinAlgError:  # a singular matrix
            covariance = np.full((3, 3), np.inf)
            break
        name = min(far, key=far.__getitem__)
        kd = np.asarray(_core.WaterOptics.jerlov(name).diffuse_attenuation) * np.maximum(
            c / type_attenuation(name), 0.1
        )
    name = min(far, key=far.__getitem__)
    alike = tuple(each for each in far if far[each] <= CHI_2)
    half = INTERVAL * np.sqrt(np.diagonal(covariance))
    return Attenuation(c, half, name, type_attenuation(name), alike, scatter, len(seen.point))


def _harmonics(d: Floats) -> Floats:
    """Return the real spherical harmonics up to degree 2 of unit vectors (m, 3), without their factors."""
    x, y, z = d.T
    return np.column_stack([np.ones_like(x), x, y, z, x * y, y * z, z * x, x * x - y * y, 3.0 * z * z - 1.0])


class _Problem:
    """The unknowns, in order.

    log J of each point, by band; c; B's harmonics, by band; vignetting; those of log J; log exposures.
    """

    def __init__(self, seen: Sightings, kd: Floats) -> None:
        self._seen, self._r = seen, np.linalg.norm(seen.ways_m, axis=1)
        direction = seen.ways_m / self._r[:, None]
        self._shape, self._slower = _harmonics(direction), -kd * direction[:, 2:]
        self._day = np.exp(kd * (seen.heights_m - seen.heights_m.mean())[:, None])
        self._fall = 1.0 - seen.cosines**4
        self._log, self._sigma = np.log(seen.light), np.hypot(RELATIVE, DARK / seen.light)
        self._points = int(seen.point.max()) + 1
        self._point = np.concatenate([band * self._points + seen.point for band in range(3)])
        self._picture = np.tile(seen.picture, 3)
        self.c = slice(3 * self._points, 3 * self._points + 3)
        self._veil = self.c.stop
        self._vignetting = self._veil + 3 * SHAPES
        self._bed = self._vignetting + 1
        self._gain = self._bed + SHAPES - 1
        self._size = self._gain + int(seen.picture.max()) + 1
        self._mean = np.zeros(self._size)
        self._mean[self._gain :] = 10.0  # exposures are relative: their mean is held at 0
        self._usual = self.start()
        self._loose = np.zeros(self._size)
        self._loose[: self.c.start] = 1.0 / SPREAD**2

    def start(self) -> Floats:
        """Return unknowns to begin with, for clear coastal water."""
        x = np.zeros(self._size)
        x[self.c] = 0.2
        count = np.bincount(self._seen.point)
        for band in range(3):
            own = self._log[:, band] + 0.2 * self._r
            x[band * self._points : (band + 1) * self._points] = np.bincount(self._seen.point, own) / count
            x[self._veil + SHAPES * band] = 0.1 * np.exp(np.median(self._log[:, band]))
        x[self._vignetting] = 0.3
        return x

    def solved(self, x: Floats, rounds: int) -> tuple[Floats, Floats, float]:
        """Return the unknowns, c's covariance, and the median residual. Raises LinAlgError."""
        damping, damped = 1e-3, True
        residual, jacobian = self._residuals(x), self._jacobian(x)
        for _ in range(rounds):
            scale = CAUCHY * max(1.0, MAD * float(np.median(np.abs(residual))))
            weight, cost = 1.0 / (1.0 + (residual / scale) ** 2), self._cost(x, residual, scale)
            normal = self._normal(jacobian, weight)
            slope = -jacobian.transposed(weight * residual) - self._mean * (self._mean @ x)
            slope -= self._loose * (x - self._usual)
            while True:
                trial = x + normal.solved(slope[:, None], damping)[:, 0]
                rest = self._residuals(trial)
                gain = cost - self._cost(trial, rest, scale)
                damped = damping > DAMPING_MAX
                if gain >= 0.0 or damped:
                    break
                damping *= 10.0
            if damped:
                break
            x, residual, jacobian, damping = trial, rest, self._jacobian(trial), max(0.1 * damping, 1e-9)
            if gain <= GAIN_MIN * cost and damping <= DAMPING_FREE:
                break
        pull = residual / (1.0 + (residual / scale) ** 2)
        scatter = float(np.median(np.abs(residual * self._sigma.T.ravel())))
        return x, self._covariance(self._normal(jacobian, weight), jacobian, pull), scatter

    def _parts(self, x: Floats, band: int) -> tuple[Floats, Floats, Floats]:
        """Return J exp(-c r), B and exp(-k r) of each pixel of a band."""
        c = x[self.c][band]
        first = self._veil + SHAPES * band
        bright = x[band * self._points + self._seen.point] + self._shape[:, 1:] @ x[self._bed : self._gain]
        own = np.exp(np.clip(bright - c * self._r, -LOG_MAX, LOG_MAX))
        rest = np.exp(np.clip(-(c + self._slower[:, band]) * self._r, -LOG_MAX, LOG_MAX))
        return own, self._day[:, band] * np.maximum(self._shape @ x[first : first + SHAPES], 0.0), rest

    def _lens(self, x: Floats) -> Floats:
        return np.asarray(np.maximum(1.0 - x[self._vignetting] * self._fall, 0.05))

    def _residuals(self, x: Floats) -> Floats:
        gain = x[self._gain + self._seen.picture] + np.log(self._lens(x))
        found = []
        for band in range(3):
            own, veil, rest = self._parts(x, band)
            light = np.log(np.maximum(own + veil * (1.0 - rest), 1e-9))
            found.append((light + gain - self._log[:, band]) / self._sigma[:, band])
        return np.concatenate(found)

    def _jacobian(self, x: Floats) -> Jacobian:
        m = len(self._r)
        by_point, others = np.empty((3, m)), np.zeros((3, m, self._gain - self.c.start))
        for band in range(3):
            own, veil, rest = self._parts(x, band)
            total = np.maximum(own + veil * (1.0 - rest), 1e-9)
            by_point[band] = own / total
            by_veil = self._day[:, band] * (1.0 - rest) / total * (veil > 0.0)
            first, of_band = self._veil + SHAPES * band - self.c.start, others[band]
            of_band[:, band] = self._r * (veil * rest - own) / total
            of_band[:, first : first + SHAPES] = self._shape * by_veil[:, None]
            of_band[:, self._vignetting - self.c.start] = -self._fall / self._lens(x)
            of_band[:, self._bed - self.c.start :] = self._shape[:, 1:] * by_point[band][:, None]
        sigma = self._sigma.T
        return Jacobian(
            self._point, self._picture, (by_point / sigma).ravel(), (others / sigma[..., None]).reshape(3 * m, -1),
            (1.0 / sigma).ravel(),
        )  # fmt: skip

    def _cost(self, x: Floats, residual: Floats, scale: float) -> float:
        assumed = (self._mean @ x) ** 2 + self._loose @ (x - self._usual) ** 2
        return float(0.5 * scale**2 * np.log1p((residual / scale) ** 2).sum() + 0.5 * assumed)

    def _normal(self, jacobian: Jacobian, weight: Floats) -> Normal:
        normal = jacobian.squared(weight)
        mean = self._mean[self.c.start :]
        normal.points += self._loose[: self.c.start]
        normal.rest += np.multiply.outer(mean, mean)
        return normal

    def _covariance(self, normal: Normal, jacobian: Jacobian, pull: Floats) -> Floats:
        """Return c's covariance (3, 3): White's (1980, Econometrica 48:817) over points, whose errors are common."""
        units = np.zeros((self._size, 3))
        units[self.c] = np.eye(3)
        each = jacobian.applied(normal.solved(units, 1e-9)) * pull[:, None]
        point = np.tile(self._seen.point, 3)
        sums = np.column_stack([np.bincount(point, column) for column in each.T])
        return np.asarray(sums.T @ sums)
