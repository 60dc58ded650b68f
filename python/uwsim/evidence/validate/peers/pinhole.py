"""Compares the camera model with OpenCV, which must project the ray through each pixel back onto that pixel."""

from __future__ import annotations

import cv2
import numpy as np

from uwsim import _core
from uwsim.evidence.validate.check import Check, along
from uwsim.evidence.validate.peers import group

WIDTH, HEIGHT = 640, 480
LENSES = {
    "no distortion": (0.0, 0.0, 0.0, 0.0, 0.0),
    "barrel": (-0.22, 0.06, 0.0, 0.0, -0.008),
    "pincushion": (0.12, 0.02, 0.0, 0.0, 0.001),
    "decentred": (-0.15, 0.03, 0.002, -0.0015, 0.0),
}


def checks() -> list[Check]:
    """Return a check for each lens, over all pixels."""
    fx, fy, cx, cy = 520.0, 505.0, 322.5, 236.0
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    found = []
    for name, distortion in LENSES.items():
        camera = _core.Camera("peer", _core.Lens(WIDTH, HEIGHT, fx, fy, cx, cy, distortion))
        rays = camera.ray_table().astype(np.float64).reshape(-1, 2)
        points = np.column_stack([rays, np.ones(len(rays))])
        pixels = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(distortion))[0].reshape(-1, 2)
        off = np.hypot(pixels[:, 0] - u.ravel(), pixels[:, 1] - v.ravel())
        found.append(along(group("pinhole"), f"{name}: pixels", np.zeros(len(off)), off, 1.0, 1e-3, "pixels"))
    return found
