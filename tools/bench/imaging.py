"""The packaged forward-looking imaging sonar on the lake, compared with bare Embree casting the same rays.

Each picture is taken from a new position along a line. The native peer casts the rays of the first picture, in packets
of eight columns by two rays, as the sonar does. Processor time of one thread.
"""

from __future__ import annotations

import statistics
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from _harness import Case, Rounds, alternated, embree_alone, medians, ratio, show, spent_s

from uwsim import Simulator

PLACE_M = (-67.0, -52.0, -26.0)  # two metres above the bed, in front of a gate
STEP_M, PLACES = 0.3, 20
COLUMNS, RAYS = 8, 2  # of a packet
GOALS = {"picture/wide": "<= 2", "picture_ms": "<= 10"}
PACKET = np.dtype([("kind", "<i4"), ("active", "<i4", 16), ("rows", "<f4", (8, 16))])  # see native/embree_bare_rays.cpp
COHERENT = 2


def main(rounds: Rounds = 15) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    sim = Simulator("lake", threads=1)
    sim.rov.release()
    sim.rov.place(PLACE_M)
    sonar = sim.rov.imaging_sonars["forward_looking"]
    eye_m, packets = sonar.world_from_sonar[:3, 3], ray_packets(sonar)
    cases: dict[str, Case] = {"picture": partial(picture_s, sim)}
    with tempfile.TemporaryDirectory() as folder:
        if peer := embree_alone(Path(folder) / "rays", sim.world, eye_m, packets, 1, "quads"):
            cases["wide"] = lambda: peer.times_s()[1]
        seconds = alternated(cases, rounds, warm_up=True)
    results = {f"{name}_ms": 1e3 * value for name, value in medians(seconds).items()}
    if "wide" in seconds:
        results["picture/wide"] = ratio(seconds["picture"], seconds["wide"])
    show("pictures of 125,000 rays, and Embree alone (wide)", results, GOALS)
    return results


def picture_s(sim: Simulator) -> float:
    """Return the median time of a picture at each position."""
    elapsed_s = []
    for k in range(PLACES):
        sim.rov.place((PLACE_M[0] + STEP_M * k, *PLACE_M[1:]))
        elapsed_s.append(spent_s(sim.rov.imaging_sonars["forward_looking"].look))
    return statistics.median(elapsed_s)


def ray_packets(sonar: Any) -> bytes:
    """Return the packets of one picture, see forward_looking.cpp."""
    model = sonar.model
    spacing = model.field_of_view_rad / (model.beams - 1) / model.columns_per_beam
    reach = int(np.ceil(6 * model.beam_width_rad / spacing))
    columns = (model.beams - 1) * model.columns_per_beam + 1 + 2 * reach
    bearing = (-model.field_of_view_rad / 2 + (np.arange(columns) - reach) * spacing)[:, None]
    shift = np.array([-0.375, 0.125, -0.125, 0.375])[np.arange(columns) % 4, None]
    u = -1 + (np.arange(model.rays_per_column) + 0.5 + shift) * 2 / model.rays_per_column
    elevation = 1.25 * model.vertical_width_rad * u * (0.6 + 0.4 * u**2) + 0 * bearing
    level = np.cos(elevation)
    xyz = np.stack([level * np.cos(bearing), level * np.sin(bearing), np.sin(elevation)], axis=-1)
    rays = xyz @ sonar.world_from_sonar[:3, :3].T
    idle = -len(rays) % COLUMNS
    active = np.concatenate([np.full(len(rays), -1), np.zeros(idle)]).astype(np.int32)
    rays = np.concatenate([rays, np.repeat(rays[-1:], idle, axis=0)])
    blocks = rays.reshape(-1, COLUMNS, rays.shape[1] // RAYS, RAYS, 3).transpose(0, 2, 4, 1, 3)
    packets = np.zeros(blocks.shape[:2], PACKET)
    packets["kind"] = COHERENT
    packets["active"] = np.repeat(active.reshape(-1, COLUMNS), RAYS, axis=1)[:, None]
    packets["rows"][..., 3:6, :] = blocks.reshape(*blocks.shape[:3], 16)
    packets["rows"][..., 7, :] = 1.5 * model.range_max_m
    return packets.tobytes()
