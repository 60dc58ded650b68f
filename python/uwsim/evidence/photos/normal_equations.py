"""Least squares in which each point has an unknown of its own, coupled with no other: points are eliminated first.

By the Schur complement (Triggs et al. 2000, "Bundle adjustment - a modern synthesis", section 6.1), the equations are
solved for what all points share and for the pictures, and then for each point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from uwsim.evidence.photos.reconstruction import Floats, Indices


@dataclass(frozen=True)
class Jacobian:
    """Derivatives by log J of a point, by the k unknowns that all share, and by the log exposure of a picture.

    point, picture: (n,), which, of each residual. by_point, by_picture: (n,). by_shared: (n, k).
    """

    point: Indices
    picture: Indices
    by_point: Floats
    by_shared: Floats
    by_picture: Floats

    def applied(self, x: Floats) -> Floats:
        """Return the product with columns (unknowns, j)."""
        first, last = int(self.point.max()) + 1, -int(self.picture.max()) - 1
        return (
            self.by_point[:, None] * x[self.point]
            + self.by_shared @ x[first:last]
            + self.by_picture[:, None] * x[last:][self.picture]
        )

    def transposed(self, y: Floats) -> Floats:
        """Return the product of the transposed with a column (n,)."""
        of_points, of_pictures = (
            np.bincount(index, by * y) for index, by in ((self.point, self.by_point), (self.picture, self.by_picture))
        )
        return np.concatenate([of_points, y @ self.by_shared, of_pictures])

    def squared(self, weight: Floats) -> Normal:
        """Return the product of the transposed, weighted (n,), with it."""
        places, points, pictures = (self.point, self.picture), int(self.point.max()) + 1, int(self.picture.max()) + 1
        pairs = sparse.csr_matrix((weight * self.by_point * self.by_picture, places), (points, pictures))
        rows = np.arange(len(weight))
        of_point = sparse.csr_matrix((weight * self.by_point, (self.point, rows)), (points, len(weight)))
        of_picture = sparse.csr_matrix((weight * self.by_picture, (self.picture, rows)), (pictures, len(weight)))
        across = of_picture @ self.by_shared
        rest = np.block(
            [
                [self.by_shared.T @ (weight[:, None] * self.by_shared), across.T],
                [across, np.diag(np.bincount(self.picture, weight * self.by_picture**2))],
            ]
        )
        own = np.bincount(self.point, weight * self.by_point**2).astype(np.float64, copy=False)
        return Normal(own, of_point @ self.by_shared, pairs, rest)


@dataclass
class Normal:
    """A symmetric matrix in blocks, in which no point is coupled with another.

    points: (p,), their diagonal. shared: their couplings with what all share (p, k). pictures: with pictures (p, n).
    rest: (k + n, k + n).
    """

    points: Floats
    shared: Floats
    pictures: sparse.csr_matrix
    rest: Floats

    def solved(self, columns: Floats, damping: float) -> Floats:
        """Solve for columns (p + k + n, j), with the diagonal damped, without the points first.

        Raises LinAlgError.
        """
        points = self.points + damping * np.maximum(self.points, 1e-9)
        rest = self.rest + np.diag(damping * np.maximum(np.diagonal(self.rest), 1e-9))
        shared, pictures = self.shared / points[:, None], sparse.diags(1.0 / points) @ self.pictures
        across = self.pictures.T @ shared
        rest -= np.block([[self.shared.T @ shared, across.T], [across, (self.pictures.T @ pictures).toarray()]])
        count = len(points)
        own, others = columns[:count], columns[count:]
        others = others - np.concatenate([shared.T @ own, pictures.T @ own])
        found = np.linalg.solve(rest, others)
        coupled = self.shared @ found[: self.shared.shape[1]] + self.pictures @ found[self.shared.shape[1] :]
        return np.concatenate([(own - coupled) / points[:, None], found])
