"""The cost of each part of a dataset frame relative to the image itself, and frames per second on several workers.

Parts are measured in this process, by processor time; frames per second use wall time. The peer is the bare image,
`Camera.capture` with all effects, which is a lower bound for any writer.
"""

from __future__ import annotations

import itertools
import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from _harness import Rounds, beside, console, show, spent_s

from uwsim.campaigns.datasets import make_dataset
from uwsim.campaigns.datasets.frame import FrameJob, file_name, folders, make_frame
from uwsim.campaigns.datasets.spec import DatasetSpec, Product
from uwsim.campaigns.datasets.studio import digest_of, studio_of

USUAL: tuple[Product, ...] = ("rgb", "depth", "normals", "instances", "classes", "boxes")
CASES: dict[str, tuple[Product, ...]] = {
    "rgb": ("rgb",),
    "depth, normals, masks, boxes": USUAL[1:],
    "usual: all of these": USUAL,
    "usual and sonar": (*USUAL, "sonar"),
}


def main(
    scenario: Annotated[str, typer.Option(help="The scenario in which pictures are taken.")] = "lake",
    size: Annotated[str, typer.Option(help="Width and height of a picture [pixels], WxH.")] = "640x360",
    rounds: Rounds = 15,
    frames: Annotated[int, typer.Option(min=0, help="Frames that the workers make; 0: no dataset.")] = 200,
    workers: Annotated[int, typer.Option(min=1, help="Number of worker processes.")] = 2,
) -> dict[str, Any]:
    """Measure the parts alternately, then a whole dataset."""
    width, _, height = size.partition("x")
    pixels = int(width), int(height)
    results: dict[str, Any] = {"parts": parts(scenario, pixels, rounds)}
    if frames:
        with tempfile.TemporaryDirectory() as folder, console.status(f"{frames} frames on {workers} workers"):
            made = make_dataset(scenario, folder, frames, workers=workers, size=pixels)
            bytes_each = sum(path.stat().st_size for path in Path(folder).rglob("*.*") if path.is_file()) / frames
        results["dataset"] = {"frames/s, wall": made.frames_per_s, "kB a frame": bytes_each / 1e3}
        show(f"usual, on {workers} workers", results["dataset"])
    return results


def parts(scenario: str, size: tuple[int, int], rounds: int) -> dict[str, Any]:
    """Return the processor time of the bare image, of drawing a pose and of frames."""
    specs = {
        name: DatasetSpec(scenario=scenario, n=rounds + 1, size=size, write=write) for name, write in CASES.items()
    }
    digest = digest_of(specs["rgb"])
    bare = studio_of(specs["rgb"], 1, digest)
    with tempfile.TemporaryDirectory() as folder:
        for spec in specs.values():
            for kind in folders(spec):
                (Path(folder) / file_name(spec, kind, 0)).parent.mkdir(exist_ok=True)

        viewpoints = [bare.viewpoint(number) for number in range(rounds + 1)]

        def picture(number: int) -> None:
            bare.place(viewpoints[number])
            bare.picture(bare.time_ns(number))

        def frame(spec: DatasetSpec, number: int) -> None:
            make_frame(FrameJob(spec, digest, number, folder, threads=1))

        calls: dict[str, Any] = {"bare picture": picture, "drawing a pose": bare.viewpoint}
        calls |= {name: partial(frame, spec) for name, spec in specs.items()}
        cases = {name: partial(spent_s, partial(next, map(call, itertools.count()))) for name, call in calls.items()}
        return beside(f"parts of a frame, {size[0]} x {size[1]} pixels", cases, rounds, "bare picture")
