"""Which metre of the position's uncertainty comes from which error.

The errors that a filter estimates beside the motion are correlated with it, and with each other. Their shares of the
position's variance are CAR scores (Zuber and Strimmer 2011, "High-dimensional regression and variable selection using
CAR scores", Stat. Appl. Genet. Mol. Biol. 10:34): with C, the correlation matrix of the errors, and r, their
correlations with a coordinate, the scores are the squares of C^(-1/2) r. They add up to r' C^-1 r, the part of the
variance that would vanish if all errors were known, and for independent errors each is what its own would vanish.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from uwsim.base.arrays import Floats

NOISE = "noise"
"""The rest: the start's error and white noise, including that by which errors have changed since they acted."""
SINGULAR = 1e-9  # smaller eigenvalues of a correlation matrix are rounding


def position_budget(covariance: Floats, terms: Mapping[str, slice]) -> dict[str, Floats]:
    """Return the standard deviations (3,) of the position [m] by term, and NOISE; their squares add up to the whole.

    covariance (n, n): of errors whose first three are the position's. terms: the errors of each, by name.
    """
    whole = np.diagonal(covariance)[:3]
    places = np.concatenate([np.arange(part.start, part.stop) for part in terms.values()])
    std = np.sqrt(np.diagonal(covariance)[places])
    known = places[std > 0]
    scale = std[std > 0]
    correlation = covariance[np.ix_(known, known)] / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(correlation)
    used = values > SINGULAR
    root = vectors[:, used] / np.sqrt(values[used]) @ vectors[:, used].T
    shares = np.zeros((len(covariance), 3))
    shares[known] = np.square(root @ (covariance[known, :3] / scale[:, None]))
    found = {name: np.sqrt(shares[part].sum(axis=0)) for name, part in terms.items()}
    return {**found, NOISE: np.sqrt(np.maximum(whole - shares.sum(axis=0), 0.0))}
