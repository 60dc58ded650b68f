"""Computes mitsuba_radiance.json of `uwsim validate peers` with Mitsuba 3 (pip install mitsuba): lamps in water.

Each scene is rendered per band in a grey homogeneous medium, for light that is scattered or reflected once ("single")
and for all light ("all"; at most DEEPEST scatterings), in half an hour.
Call: python make_mitsuba_radiance.py OUT.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from uwsim import _core
from uwsim.evidence.validate.peers.lamp_light import ASYMMETRY, HALF_ANGLE_DEG, SCENES, SOFT_SHARE, WATERS, Scene

mi.set_variant("scalar_rgb")
from mitsuba import ScalarTransform4f as Transform  # noqa: E402 - exists once the variant is set

BATCHES, SINGLE, ALL = 8, 1 << 16, 1 << 14  # renderings, whose scatter gives the error, and samples of each
DEEPEST = 40


def medium(jerlov: str, band: int) -> dict[str, Any]:
    """Return water as a medium of particles (Henyey and Greenstein) and molecules (Rayleigh: those of type I)."""
    water = _core.WaterOptics.jerlov(jerlov)
    b = float(water.scattering[band])
    molecules = min(b, float(_core.WaterOptics.jerlov("I").scattering[band]))
    c = b + float(water.absorption[band])
    phases = {"particles": {"type": "hg", "g": ASYMMETRY}, "molecules": {"type": "rayleigh"}}
    return {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": c},
        "albedo": {"type": "rgb", "value": b / c},
        "phase": {"type": "blendphase", "weight": molecules / b, **phases},
    }


def radiance(scene: Scene, azimuth_deg: float, water: dict[str, Any], depth: int, samples: int) -> tuple[float, float]:
    """Return the radiance in one direction, and its standard error."""
    azimuth = np.radians(azimuth_deg)
    lamp = np.array(scene.lamp_m)
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": depth, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": 0.2,
            "near_clip": 1e-3,
            "to_world": Transform().look_at([0, 0, 0], [float(np.cos(azimuth)), float(np.sin(azimuth)), 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"},
                     "pixel_format": "luminance", "component_format": "float32"},
            "sampler": {"type": "independent"},
            "medium": water,
        },
        "lamp": {
            "type": "spot",
            "to_world": Transform().look_at(lamp.tolist(), (lamp + scene.lamp_axis).tolist(), [0, 0, 1]),
            "intensity": {"type": "rgb", "value": 1.0},
            "cutoff_angle": HALF_ANGLE_DEG,
            "beam_width": HALF_ANGLE_DEG * (1 - SOFT_SHARE),
        },
    }  # fmt: skip
    for k, (centre, size, albedo) in enumerate(scene.boxes):
        parts[f"box {k}"] = {
            "type": "cube",
            "to_world": Transform().translate(centre).scale([0.5 * length for length in size]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo}},
        }
    loaded = mi.load_dict(parts)
    found = [float(np.array(mi.render(loaded, spp=samples, seed=k)).ravel()[0]) for k in range(BATCHES)]
    return float(np.mean(found)), float(np.std(found, ddof=1) / np.sqrt(BATCHES))


def computed(depth: int, samples: int) -> tuple[dict[str, Any], float]:
    """Return the radiance by scene and water, (directions, 3), and the largest relative standard error."""
    found: dict[str, Any] = {}
    worst = 0.0
    for name, scene in SCENES.items():
        for jerlov in WATERS:
            waters = [medium(jerlov, band) for band in range(3)]
            cells = [[radiance(scene, at, water, depth, samples) for water in waters] for at in scene.azimuths_deg]
            found.setdefault(name, {})[jerlov] = [[float(f"{mean:.5g}") for mean, _ in row] for row in cells]
            worst = max(worst, *(error / mean for row in cells for mean, error in row))
    return found, round(worst, 4)


if __name__ == "__main__":
    single, single_error = computed(2, SINGLE)
    all_light, all_error = computed(DEEPEST, ALL)
    made = {
        "mitsuba": mi.__version__,
        "relative_standard_error": {"single": single_error, "all": all_error},
        "single": single,
        "all": all_light,
    }
    Path(sys.argv[1]).write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
