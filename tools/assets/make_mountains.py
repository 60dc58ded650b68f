"""Generate assets/terrains/mountains.png, the bed of the scenario `paper`; needs numpy, pillow and pyfastnoiselite.

A plain between mountains, 400 x 400 m, one pixel per metre. Grey levels are heights: 0 for the plain, 65535 for
HIGHEST_M above it. Each mountain is a cone with a rounded top and noise ridges; its sides slope at 60 to 75 degrees. A
ridge along the edges rises above the water, which is WATER_M above the plain.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from pyfastnoiselite.pyfastnoiselite import FastNoiseLite, FractalType, NoiseType

TERRAINS = Path(__file__).resolve().parents[2] / "assets" / "terrains"
HALF_M = 200
HIGHEST_M = 180.0
WATER_M = 41.5
EDGE_M = 24.0
"""Width of the ridge along the edges."""
RELIEF_M = 0.6
"""Height of the sand waves above the plain."""
PEAKS = [  # x, y, height, base radius [m]
    (-60, -150, 158, 50), (-64, -104, 128, 46), (-42, -198, 98, 30), (-16, -228, 140, 42), (40, -234, 172, 48),
    (66, -186, 132, 38), (106, -204, 150, 50), (130, -148, 168, 50), (122, -100, 124, 40),
    (134, -58, 142, 50), (98, -40, 158, 50), (44, -20, 168, 52), (-14, -30, 148, 48),
    (-66, -56, 122, 44), (-120, -64, 150, 60), (-62, 44, 140, 56),
    (104, 70, 172, 74), (16, 92, 150, 60), (-150, 52, 160, 70), (-110, 140, 150, 70), (10, 176, 166, 66),
    (150, 150, 160, 74), (-156, -150, 140, 58), (170, -170, 146, 60), (180, 0, 140, 56),
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
    spread = 1 + 0.2 * noise(x, y, 60, FractalType.FractalType_FBm, 9)
    height = RELIEF_M * 0.5 * (1 + noise(x, y, 45, FractalType.FractalType_FBm, 8))
    for peak_x, peak_y, peak_m, foot_m in PEAKS:
        share = spread * np.hypot(x - peak_x, y - peak_y) / foot_m
        cone = np.sqrt(1.04 - 0.04 * np.clip(share, 0, 1)) - np.sqrt(share**2 + 0.004)
        height = np.maximum(height, peak_m * np.clip(cone + 0.16 * ridges * (1 - share), 0, None))
    inside_m = HALF_M - np.maximum(np.abs(x), np.abs(y))
    height = np.maximum(height, (WATER_M + 14 + 10 * ridges) * np.clip(1.3 - 1.3 * inside_m / EDGE_M, 0, 1))
    return np.clip(height - height.min(), 0, HIGHEST_M)


def main() -> None:
    """Write the image."""
    levels = np.round(heights() / HIGHEST_M * 65535).astype(np.uint16)
    Image.fromarray(levels).save(TERRAINS / "mountains.png", optimize=True)


if __name__ == "__main__":
    main()
