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
    "rational": (0.93, 0.166, -2e-4, 1e-4, 0.003, 1.33, 0.436, 0.028),
    "fisheye": (-0.0292, 0.0208, -0.0319, 0.0166),
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
        project = cv2.fisheye.projectPoints if len(distortion) == 4 else cv2.projectPoints
        none, d = np.zeros(3), np.array(distortion)
        pixels = project(points[:, None], none, none, matrix, d)[0].reshape(-1, 2)
        off = np.hypot(pixels[:, 0] - u.ravel(), pixels[:, 1] - v.ravel())
        found.append(along(group("pinhole"), f"{name}: pixels", np.zeros(len(off)), off, 1.0, 1e-3, "pixels"))
    return found
