"""Generate assets/terrains/mountains.png, the bed of the scenario `paper`; needs numpy, pillow and pyfastnoiselite.

A plain with mountains, 400 x 400 m, one pixel per metre. Grey levels are heights: 0 for the plain, 65535 for HIGHEST_M
above it. Each mountain is a cone with a rounded top and noise ridges; its sides slope at 40 to 60 degrees.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from pyfastnoiselite.pyfastnoiselite import FastNoiseLite, FractalType, NoiseType

TERRAINS = Path(__file__).resolve().parents[2] / "assets" / "terrains"
HALF_M = 200
HIGHEST_M = 60.0
RELIEF_M = 0.6
"""Height of the sand waves above the plain."""
PEAKS = [  # x, y, height, base radius [m]
    (-118, -28, 37, 66), (-58, 58, 33, 58), (26, 4, 34, 52), (96, 70, 52, 78), (128, -52, 38, 60),
    (-150, 132, 56, 84), (20, 150, 46, 76), (-168, -150, 34, 56), (160, -160, 36, 58), (76, -74, 22, 40),
]  # fmt: skip


def noise(x: np.ndarray, y: np.ndarray, wavelength_m: float, kind: FractalType, seed: int) -> np.ndarray:
    """Return fractal noise in [-1, 1]."""
    made = FastNoiseLite(seed=seed)
    made.noise_type = NoiseType.NoiseType_OpenSimplex2
    made.frequency = 1 / wavelength_m
    made.fractal_type = kind
    made.fractal_octaves = 5
    points = np.stack([x.ravel(), y.ravel()]).astype(np.float32)
    return np.clip(np.asarray(made.gen_from_coords(points)).reshape(x.shape), -1, 1)


def heights() -> np.ndarray:
    """Return heights above the plain, (401, 401); the first row is the northern edge."""
    x, y = np.meshgrid(np.arange(-HALF_M, HALF_M + 1.0), np.arange(HALF_M, -HALF_M - 1.0, -1.0))
    ridges = noise(x, y, 70, FractalType.FractalType_Ridged, 7)
    height = RELIEF_M * 0.5 * (1 + noise(x, y, 45, FractalType.FractalType_FBm, 8))
    for peak_x, peak_y, peak_m, foot_m in PEAKS:
        share = np.hypot(x - peak_x, y - peak_y) / foot_m
        cone = np.sqrt(1.04 - 0.04 * np.clip(share, 0, 1)) - np.sqrt(share**2 + 0.004)
        height = np.maximum(height, peak_m * np.clip(cone + 0.16 * ridges * (1 - share), 0, None))
    return np.clip(height, 0, HIGHEST_M)


def main() -> None:
    """Write the image."""
    levels = np.round(heights() / HIGHEST_M * 65535).astype(np.uint16)
    Image.fromarray(levels).save(TERRAINS / "mountains.png", optimize=True)


if __name__ == "__main__":
    main()
