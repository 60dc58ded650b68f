"""One frame of a dataset, rendered by a worker: its pose, pictures and files, and its record for the tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.npz import npz_bytes
from uwsim.campaigns.datasets.files import annotations_of, depth_pixels, level_pixels, normal_pixels, yolo_lines
from uwsim.campaigns.datasets.poses import Viewpoint
from uwsim.campaigns.datasets.spec import OF_CAMERA, DatasetSpec
from uwsim.campaigns.datasets.studio import Studio, studio_of
from uwsim.campaigns.workers.tidy import tidy_now_and_then
from uwsim.instruments.cameras import Frame
from uwsim.instruments.cameras.image_file import encode_jpeg, encode_png
from uwsim.instruments.sonars.imaging import SonarImage
from uwsim.instruments.sonars.imaging.pixels import shown_range

JPEG_QUALITY = 95


@dataclass(frozen=True)
class FrameJob:
    """A frame to render.

    pose: time [s], position [m] and orientation x, y, z, w on a track; None for a random pose. digest: the scenario's
    fingerprint (studio.digest_of).
    """

    spec: DatasetSpec
    digest: str
    number: int
    out: str
    pose: tuple[float, ...] | None = None
    threads: int | None = None


def _classes(studio: Studio, labels: NDArray[np.uint16]) -> bytes:
    return encode_png(np.asarray(studio.class_of_label, np.uint8)[labels])


def _yolo(studio: Studio, frame: Frame, _: NDArray[np.uint16]) -> bytes:
    things = studio.annotations(frame, studio.spec.min_pixels)
    return yolo_lines(things, frame.info.width, frame.info.height).encode()


PICTURES: dict[str, tuple[str, Callable[[Studio, Frame, NDArray[np.uint16]], bytes]]] = {
    "rgb": ("images/.png", lambda _, frame, __: encode_png(frame.rgb)),
    "rgb as jpg": ("images/.jpg", lambda _, frame, __: encode_jpeg(frame.rgb, JPEG_QUALITY)),
    "depth": ("depth/.png", lambda _, frame, __: encode_png(depth_pixels(frame.depth_m))),
    "normals": (
        "normals/.png",
        lambda studio, frame, _: encode_png(normal_pixels(frame.normals_world, frame.world_from_optical, studio.rays)),
    ),
    "instances": ("instances/.png", lambda _, __, labels: encode_png(labels)),
    "classes": ("classes/.png", lambda studio, _, labels: _classes(studio, labels)),
    "arrays": (
        "arrays/.npz",
        lambda _, frame, __: npz_bytes(
            rgb=frame.rgb, depth_m=frame.depth_m, normals_world=frame.normals_world, labels=frame.labels
        ),
    ),
    "yolo": ("labels/.txt", _yolo),  # its loaders replace "images" in a picture's path with "labels"
}
"""The files of a picture by product: folder and suffix, and the content of a frame with its labels."""


def _of_picture(spec: DatasetSpec, name: str) -> str:
    return "rgb as jpg" if name == "rgb" and spec.pictures == "jpg" else name


def folders(spec: DatasetSpec) -> dict[str, str]:
    """Return the folder and suffix, such as depth/.png, of each kind of file written for a frame."""
    where = {name: folder for name, (folder, _) in PICTURES.items()} | {"multibeam": "multibeam/.npz"}
    found = {str(name): where[_of_picture(spec, name)] for name in spec.write if name not in ("boxes", "sonar")}
    if spec.writes("sonar"):
        found |= {name: f"{name}/.png" for name in ("sonar", "sonar_instances", "sonar_classes")}
        if spec.writes("arrays"):
            found["sonar_arrays"] = "sonar_arrays/.npz"
    return found


def file_name(spec: DatasetSpec, kind: str, number: int) -> str:
    """Return the path of a frame's file within the dataset, such as depth/000007.png."""
    folder, suffix = folders(spec)[kind].split("/")
    return f"{folder}/{number:06d}{suffix}"


def make_frame(job: FrameJob) -> dict[str, Any]:
    """Render a frame, write its files and return its record. Raises ValueError if no pose can be found, or OSError."""
    studio, spec, number = studio_of(job.spec, job.threads, job.digest), job.spec, job.number
    values = studio.vary(number)
    if job.pose is None:
        viewpoint, time_ns = studio.viewpoint(number), studio.time_ns(number)
    else:
        viewpoint = Viewpoint(np.array(job.pose[1:4]), np.array(job.pose[4:]))
        time_ns = round(1e9 * job.pose[0])
    try:
        studio.place(viewpoint)
    except ValueError as error:
        raise ValueError(f"frame {number}: {error}") from None
    record: dict[str, Any] = {
        "frame": number,
        "seed": studio.sim.seed,
        "time_ns": time_ns,
        "world_from_body": studio.vehicle.pose.world_from_body.tolist(),
        "target": viewpoint.target,
        "distance_m": viewpoint.distance_m,
        "values": values,
    }
    files: dict[str, bytes] = {}
    if spec.writes(*OF_CAMERA):
        _add_picture(studio, studio.picture(time_ns), record, files)
    if spec.writes("sonar"):
        _add_sonar(studio, studio.ping(time_ns), record, files)
    if spec.writes("multibeam"):
        _add_multibeam(studio, record, files)
    for kind, content in files.items():
        write_atomically(Path(job.out) / file_name(spec, kind, number), content)
    tidy_now_and_then()
    return record


def _add_picture(studio: Studio, frame: Frame, record: dict[str, Any], files: dict[str, bytes]) -> None:
    spec, labels = studio.spec, studio.labels(frame)
    for name in spec.write:
        if name in PICTURES:
            files[name] = PICTURES[_of_picture(spec, name)][1](studio, frame, labels)
    record["world_from_optical"] = frame.world_from_optical.tolist()
    label_range = studio.label_range_m
    record["label_range_m"] = float(label_range) if np.isfinite(label_range) else None
    record["empty"] = not studio.looked_at(studio.annotations(frame, 1))
    if spec.writes("boxes"):
        record["annotations"] = studio.annotations(frame, spec.min_pixels)


def _add_sonar(studio: Studio, image: SonarImage, record: dict[str, Any], files: dict[str, bytes]) -> None:
    """Add the sonar image as operators view it: the farthest range in the first row, port in the first column."""
    assert image.labels is not None
    limits_db = shown_range(image.level_db, image.noise_db[:, None])
    labels = np.ascontiguousarray(image.labels[::-1, ::-1])
    ranges = np.broadcast_to(image.ranges_m[::-1, None], labels.shape).astype(np.float32)
    files |= {
        "sonar": encode_png(level_pixels(image.level_db[::-1, ::-1], limits_db)),
        "sonar_instances": encode_png(labels),
        "sonar_classes": _classes(studio, labels),
    }
    if studio.spec.writes("arrays"):
        files["sonar_arrays"] = npz_bytes(
            level_db=image.level_db, noise_db=image.noise_db, labels=image.labels, ranges_m=image.ranges_m,
            bearings_rad=image.bearings_rad,
        )  # fmt: skip
    record["world_from_sonar"] = image.world_from_sonar.tolist()
    record["sonar_limits_db"] = list(limits_db)
    record["sonar_annotations"] = annotations_of(
        labels, studio.class_of_label, studio.label_names, ranges, studio.spec.min_pixels
    )


def _add_multibeam(studio: Studio, record: dict[str, Any], files: dict[str, bytes]) -> None:
    ping = studio.vehicle.sonar.ping()
    files["multibeam"] = npz_bytes(
        ranges_m=ping.ranges_m, angles_rad=ping.angles_rad, labels=ping.labels, intensity_db=ping.intensity_db,
        valid=ping.valid, points_sonar_m=ping.points_sonar_m,
    )  # fmt: skip
    record["world_from_multibeam"] = np.asarray(ping.world_from_sonar).tolist()
