"""The cost of each part of a dataset frame relative to the image itself, and frames per second on several workers.

Parts are measured alternately in this process, by processor time, so that other load does not count; frames per second
use wall time. The peer is the bare image, `Camera.capture` with all effects, which is a lower bound for any writer.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import typer
from _harness import console, medians, ratio
from rich.table import Table

from uwsim.campaigns.datasets import make_dataset
from uwsim.campaigns.datasets.frame import FrameJob, file_name, folders, make_frame
from uwsim.campaigns.datasets.spec import DatasetSpec, Product
from uwsim.campaigns.datasets.studio import digest_of, studio_of

CASES: dict[str, tuple[Product, ...]] = {
    "rgb": ("rgb",),
    "depth, normals, masks, boxes": ("depth", "normals", "instances", "classes", "boxes"),
    "usual: all of these": ("rgb", "depth", "normals", "instances", "classes", "boxes"),
    "usual and sonar": ("rgb", "depth", "normals", "instances", "classes", "boxes", "sonar"),
}


def main(
    scenario: Annotated[str, typer.Option(help="The scenario in which pictures are taken.")] = "lake",
    size: Annotated[str, typer.Option(help="Width and height of a picture [pixels], WxH.")] = "640x360",
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured; medians are reported.")] = 15,
    frames: Annotated[int, typer.Option(min=0, help="Frames that the workers make; 0: no dataset.")] = 200,
    workers: Annotated[int, typer.Option(min=1, help="Number of worker processes.")] = 2,
) -> dict[str, Any]:
    """Measure the parts alternately, then a whole dataset."""
    width, _, height = size.partition("x")
    pixels = int(width), int(height)
    results = parts(scenario, pixels, rounds)
    if frames:
        with tempfile.TemporaryDirectory() as folder, console.status(f"{frames} frames on {workers} workers"):
            made = make_dataset(scenario, folder, frames, workers=workers, size=pixels)
            bytes_each = sum(path.stat().st_size for path in Path(folder).rglob("*.*") if path.is_file()) / frames
        results |= {
            f"usual, frames/s on {workers} workers, wall": made.frames_per_s,
            "usual, kB a frame": bytes_each / 1e3,
        }
    table = Table("result", "value", title=f"datasets of {scenario}, {size} pixels")
    for name, value in results.items():
        table.add_row(name, f"{value:,.2f}")
    console.print(table)
    return results


def parts(scenario: str, size: tuple[int, int], rounds: int) -> dict[str, float]:
    """Return the processor milliseconds of the bare image and of frames, and the ratios of each round."""
    specs = {
        name: DatasetSpec(scenario=scenario, n=rounds + 1, size=size, write=write) for name, write in CASES.items()
    }
    digest = digest_of(specs["rgb"])
    bare = studio_of(specs["rgb"], 1, digest)
    cost_ms: dict[str, list[float]] = {name: [] for name in ("bare picture", "drawing a pose", *CASES)}
    with tempfile.TemporaryDirectory() as folder:
        for spec in specs.values():
            for kind in folders(spec):
                (Path(folder) / file_name(spec, kind, 0)).parent.mkdir(exist_ok=True)
        for number in range(rounds + 1):
            with console.status(f"round {number} of {rounds}"):
                begun = time.process_time()
                viewpoint = bare.viewpoint(number)
                drawn = time.process_time()
                bare.place(viewpoint)
                bare.picture(bare.time_ns(number))
                row = {"drawing a pose": drawn - begun, "bare picture": time.process_time() - drawn}
                for name, spec in specs.items():
                    begun = time.process_time()
                    make_frame(FrameJob(spec, digest, number, folder, threads=1))
                    row[name] = time.process_time() - begun
            if number:  # the first warms up
                for name, seconds in row.items():
                    cost_ms[name].append(1e3 * seconds)
    results = {f"{name}, ms": value for name, value in medians(cost_ms).items()}
    return results | {
        f"{name}, against the bare picture": ratio(cost_ms[name], cost_ms["bare picture"]) for name in CASES
    }
