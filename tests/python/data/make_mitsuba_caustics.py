"""Computes mitsuba_caustics.json of `uwsim validate camera` with Mitsuba 3 (pip install mitsuba): the sun on a bed.

Light enters by Mitsuba's rays, rough dielectric and phase functions through the very surface that uwsim has, and is
counted where it comes down on the bed. Needs LLVM 15 or newer (DRJIT_LIBLLVM_PATH), and takes some minutes.
Call: python make_mitsuba_caustics.py OUT.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.peers.focused_light import (
    CASES,
    CELL_M,
    SUN_RADIUS_RAD,
    Case,
    Spread,
    height_map,
    slopes_rms,
    spread_of,
)

mi.set_variant("llvm_ad_rgb")

BATCHES, RAYS = 8, 1 << 21
FINE = 4  # vertices of the surface per cell of the ripples, along each axis
ABOVE_M = 3.0  # where rays start, above the mean surface
PARTICLE_INDEX, PARTICLE_SLOPE = 1.1, 3.5835  # Fournier and Forand's, which send back 1.8 % (Mobley 2002)
NODES = 1 << 19
MOST_SCATTERINGS, LEAST = 400, 1e-4  # light below LEAST is given up


def surface(case: Case) -> mi.Mesh:
    """Return uwsim's surface over the patch and its margin, as triangles that shorter waves roughen."""
    places_m, heights_m = height_map(case, CELL_M / FINE)
    n = len(heights_m)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([corner, corner + n, corner + n + 1], 1),
                            np.stack([corner, corner + n + 1, corner + 1], 1)])  # fmt: skip
    water = {"type": "roughdielectric", "distribution": "beckmann", "alpha": case.roughness, "int_ior": case.index,
             "ext_ior": 1.0}  # fmt: skip
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(water)
    mesh = mi.Mesh("surface", heights_m.size, len(faces), has_vertex_normals=False, props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = mi.Float(
        np.column_stack([places_m.reshape(-1, 2), heights_m.ravel()]).astype(np.float32).ravel()
    )
    parameters["faces"] = mi.UInt(faces.astype(np.uint32).ravel())
    parameters.update()
    return mesh


def particles() -> mi.PhaseFunction:
    """Return the phase function of particles by Fournier and Forand 1994, in Fournier and Jonasz's form of 1999."""
    cosine = np.linspace(-1.0, 1.0, NODES)
    half = np.maximum(0.5 * (1.0 - cosine), 0.25 / NODES)  # sin^2 of half the angle
    scale, power = 4.0 / (3.0 * (PARTICLE_INDEX - 1.0) ** 2), 0.5 * (3.0 - PARTICLE_SLOPE)
    d, back = scale * half, scale
    raised = d**power
    forward = (power * (1 - d) - (1 - raised) + (d * (1 - raised) - power * (1 - d)) / half) / ((1 - d) ** 2 * raised)
    around = (1 - back**power) / (4 * (back - 1) * back**power) * (3 * cosine**2 - 1)
    values = ", ".join(f"{value:.7g}" for value in forward + around)
    return mi.load_dict({"type": "tabphase", "values": values})


def scattered(phase: mi.PhaseFunction, way: mi.Vector3f, one: mi.Float, pair: mi.Point2f) -> mi.Vector3f:
    """Return the direction in which light goes on that came along `way`."""
    met = dr.zeros(mi.MediumInteraction3f)
    met.wi = -way
    met.sh_frame = mi.Frame3f(-way)
    return dr.normalize(phase.sample(mi.PhaseFunctionContext(None), met, one, pair)[0])


def landed(scene: mi.Scene, phases: tuple[mi.PhaseFunction, mi.PhaseFunction], case: Case, seed: int) -> mi.Float:
    """Return the light in each cell of the bed [x][y], of rays that start over the patch and its margin."""
    random = mi.PCG32(size=RAYS, initstate=seed)
    at, way, light = entered(scene, case, random)
    cells = dr.zeros(mi.Float, case.side**2)

    def flown(cells, at, way, light, count, random):  # type: ignore[no-untyped-def]
        free = -dr.log(1 - random.next_float32()) / case.attenuation_per_m
        fall = dr.select(way.z < 0, (-case.depth_m - at.z) / dr.minimum(way.z, -1e-9), dr.inf)
        lands = fall <= free
        there = at + way * dr.minimum(fall, free)
        column, row = (dr.floor((place + case.half_m) / CELL_M) for place in (there.x, there.y))
        if case.repeats:
            column, row = (index - case.side * dr.floor(index / case.side) for index in (column, row))
        inside = lands & (column >= 0) & (row >= 0) & (column < case.side) & (row < case.side)
        cell = mi.UInt(dr.select(inside, column * case.side + row, 0.0))
        dr.scatter_reduce(dr.ReduceOp.Add, cells, light, cell, inside)
        one, pair = random.next_float32(), mi.Point2f(random.next_float32(), random.next_float32())
        molecular = random.next_float32() < case.molecular
        onward = dr.select(molecular, scattered(phases[1], way, one, pair), scattered(phases[0], way, one, pair))
        stays = ~lands & (there.z < 0) & (count < MOST_SCATTERINGS)
        return cells, there, onward, dr.select(stays, light * case.albedo, 0.0), count + 1, random

    state = (cells, at, way, light, mi.UInt(0), random)
    return dr.while_loop(state, lambda cells, at, way, light, count, random: light > LEAST, flown)[0]


def entered(scene: mi.Scene, case: Case, random: mi.PCG32) -> tuple[mi.Vector3f, mi.Vector3f, mi.Float]:
    """Return where the sun's rays enter the water, their ways there, and their light; 0 for those that do not."""
    reach, to_sun = case.half_m + case.margin_m, case.to_sun
    radius, turn = SUN_RADIUS_RAD * dr.sqrt(random.next_float32()), 2 * dr.pi * random.next_float32()
    aside = mi.Vector3f(radius * dr.cos(turn), radius * dr.sin(turn), 1.0)
    direction = -dr.normalize(mi.Frame3f(mi.Vector3f(*to_sun)).to_world(aside))
    back = ABOVE_M / to_sun[2]
    x, y = ((random.next_float32() * 2 - 1) * reach + case.shift_m[k] + back * to_sun[k] for k in range(2))
    hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(x, y, ABOVE_M), direction))
    pair = mi.Point2f(random.next_float32(), random.next_float32())
    context = mi.BSDFContext(mi.TransportMode.Importance)
    sample, weight = hit.bsdf().sample(context, hit, random.next_float32(), pair)
    way = hit.to_world(sample.wo)
    return mi.Vector3f(hit.p), way, dr.select(hit.is_valid() & (way.z < 0), weight.x, 0.0)


def computed(case: Case, phases: tuple[mi.PhaseFunction, mi.PhaseFunction]) -> tuple[Spread, Spread, list[Floats]]:
    """Return the spread of the light on the bed, its standard error (jackknife), and the batches' patterns."""
    scene = mi.load_dict({"type": "scene", "surface": surface(case)})
    patterns = []
    for seed in range(BATCHES):
        cells = np.array(landed(scene, phases, case, seed + 1), np.float64).reshape(case.side, case.side)
        patterns.append(cells / cells.mean())
    whole = spread_of(patterns)
    left_out = np.array([spread_of([p for k, p in enumerate(patterns) if k != out]) for out in range(BATCHES)])
    error = np.sqrt((BATCHES - 1) / BATCHES * ((left_out - left_out.mean(axis=0)) ** 2).sum(axis=0))
    return whole, Spread(*error), patterns


if __name__ == "__main__":
    both = particles(), mi.load_dict({"type": "rayleigh"})
    made = {"mitsuba": mi.__version__, "rays": BATCHES * RAYS, "cases": {}}
    for name, each in CASES.items():
        found, error, _ = computed(each, both)
        made["cases"][name] = {
            "slopes_rms": round(slopes_rms(each), 6),
            **{key: float(f"{value:.4g}") for key, value in found._asdict().items()},
            "error": {key: float(f"{value:.2g}") for key, value in error._asdict().items()},
        }
    Path(sys.argv[1]).write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
