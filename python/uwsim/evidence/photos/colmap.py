"""Reads COLMAP's sparse models: cameras, images and points3D, as binary or as text.

Format: https://colmap.github.io/format.html. Intrinsics are not needed: pixels are observed, and distances follow from
the poses.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.evidence.photos.reconstruction import Floats, Indices, Reconstruction

PARTS = ("cameras", "images", "points3D")
SUFFIXES = (".bin", ".txt")
PARAMETERS = (3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12, 16)
"""The numbers of each camera model, from SIMPLE_PINHOLE to RAD_TAN_THIN_PRISM_FISHEYE."""
BYTES_MAX = 4_000_000_000
NAME_MAX = 1024
FARTHEST = 1e9
"""The greatest coordinate, in the model's unit or in pixels."""
OBSERVED = np.dtype([("at", "<f8", 2), ("point", "<i8")])
TRACK = np.dtype([("image", "<u4"), ("index", "<u4")])
SHOWN = 40


class _Images(NamedTuple):
    names: list[str]
    cameras: list[int]
    poses: Floats  # (k, 7): the quaternion w x y z and the translation, camera from world
    counts: list[int]
    at: Floats
    points: Indices


class _Points(NamedTuple):
    ids: Indices
    places: Floats
    errors: Floats


def suffix_of(folder: Path) -> str | None:
    """Return the suffix of a model's files in a folder, or None if it has no model."""
    return next((each for each in SUFFIXES if all((folder / (part + each)).is_file() for part in PARTS)), None)


def models_in(folder: Path) -> list[Path]:
    """Return the folders of models: this one, or those in it and in its folder sparse."""
    if suffix_of(folder) is not None:
        return [folder]
    found = []
    for parent in (folder, folder / "sparse"):
        if parent.is_dir():
            found += [each for each in sorted(parent.iterdir()) if each.is_dir() and suffix_of(each) is not None]
    return found + ([folder / "sparse"] if suffix_of(folder / "sparse") is not None else [])


def read_model(folder: Path) -> Reconstruction:
    """Return the model in a folder. Raises ValueError, which names the file and the byte or line that is wrong."""
    suffix = suffix_of(folder)
    if suffix is None:
        raise ValueError(f"'{folder}': must have {', '.join(PARTS)} as .bin or .txt")
    files = [folder / (part + suffix) for part in PARTS]
    cameras, images, points = _read_binary(*files) if suffix == ".bin" else _read_text(*files)
    order = np.argsort(points.ids, kind="stable")
    ids = points.ids[order]
    if len(ids) == 0 or not images.names:
        raise ValueError(f"'{folder}': has {len(images.names)} pictures and {len(ids)} points: must have some of both")
    if (np.diff(ids) == 0).any():
        raise ValueError(f"'{files[2]}': a point's identifier is used twice")
    for values, file in ((images.poses, files[1]), (images.at, files[1]), (points.places, files[2])):
        wrong = ~(np.abs(values) <= FARTHEST)
        if wrong.any():
            rule = f"must be finite, and at most {FARTHEST:g}"
            raise ValueError(f"'{file}': {wrong.sum()} numbers, such as {values[wrong][0]:g}: {rule}")
    for name, camera in zip(images.names, images.cameras, strict=True):
        if camera not in cameras:
            raise ValueError(f"'{files[1]}': picture '{name}': camera {camera} is not in '{files[0].name}'")
    quaternions = images.poses[:, :4]
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    if (lengths < 1e-6).any():
        raise ValueError(f"'{files[1]}': picture '{images.names[int(lengths.argmin())]}': its rotation is zero")
    turns = _rotations(quaternions / lengths)
    seen = images.points >= 0
    place = np.minimum(np.searchsorted(ids, images.points[seen]), len(ids) - 1)
    if (ids[place] != images.points[seen]).any():
        lost = images.points[seen][ids[place] != images.points[seen]][0]
        raise ValueError(f"'{files[1]}': a picture sees point {lost}, which is not in '{files[2].name}'")
    return Reconstruction(
        path=folder,
        pictures=images.names,
        sizes=np.array([cameras[each] for each in images.cameras], np.int64),
        centres=-np.einsum("kij,kj->ki", turns, images.poses[:, 4:]),
        turns=turns,
        points=points.places,
        errors=points.errors,
        seen_in=np.repeat(np.arange(len(images.names)), images.counts)[seen],
        seen_point=order[place],
        seen_at=images.at[seen],
        notes=[f"read: {folder}: {len(images.names)} pictures, {len(ids)} points, {seen.sum()} observations"],
    )


def _rotations(q: Floats) -> Floats:
    """Return the rotations from camera to world (k, 3, 3) of unit quaternions w x y z from world to camera."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(q[:, [1, 2, 3, 0]]).inv().as_matrix())


class _Bytes:
    """A file's bytes, taken in order. Each count is compared with what is left before anything of its size is made."""

    def __init__(self, path: Path) -> None:
        self._path, self._data, self._at = path, read_limited(path, f"'{path}'", BYTES_MAX), 0

    def numbers(self, layout: str) -> tuple[int | float, ...]:
        form = struct.Struct("<" + layout)
        self._need(form.size)
        self._at += form.size
        return form.unpack_from(self._data, self._at - form.size)

    def count(self, least_bytes: int, what: str) -> int:
        """Return a count of records that have at least `least_bytes` each."""
        (count,) = self.numbers("Q")
        left = len(self._data) - self._at
        if count * least_bytes > left:
            raise ValueError(
                f"'{self._path}': byte {self._at - 8}: announces {count} {what}, of {least_bytes} bytes "
                f"or more each, but {left} bytes follow: is it cut short?"
            )
        return int(count)

    def array(self, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
        self._need(dtype.itemsize * count)
        self._at += dtype.itemsize * count
        return np.frombuffer(self._data, dtype, count, self._at - dtype.itemsize * count)

    def skip(self, size: int) -> None:
        self._need(size)
        self._at += size

    def name(self) -> str:
        end = self._data.find(b"\0", self._at, self._at + NAME_MAX)
        if end < 0:
            raise ValueError(f"'{self._path}': byte {self._at}: a picture's name does not end within {NAME_MAX} bytes")
        found = self._data[self._at : end].decode("utf-8", errors="replace")
        self._at = end + 1
        return found

    def end(self) -> None:
        if self._at != len(self._data):
            raise ValueError(f"'{self._path}': {len(self._data) - self._at} bytes follow its last record")

    def _need(self, size: int) -> None:
        if self._at + size > len(self._data):
            raise ValueError(f"'{self._path}': ends at byte {len(self._data)}, within a record: is it cut short?")


def _read_binary(cameras: Path, images: Path, points: Path) -> tuple[dict[int, tuple[int, int]], _Images, _Points]:
    file, sizes = _Bytes(cameras), {}
    for _ in range(file.count(24, "cameras")):
        number, model, width, height = (int(each) for each in file.numbers("IiQQ"))
        if not 0 <= model < len(PARAMETERS):
            raise ValueError(f"'{cameras}': camera {number}: model {model}: must be 0 to {len(PARAMETERS) - 1}")
        file.skip(8 * PARAMETERS[model])
        sizes[number] = _size(cameras, number, width, height)
    file.end()

    file = _Bytes(images)
    names, own, poses, counts, seen = [], [], [], [], []
    for _ in range(file.count(73, "images")):
        _, *pose, camera = file.numbers("I7dI")
        poses.append(pose)
        own.append(int(camera))
        names.append(file.name())
        counts.append(file.count(OBSERVED.itemsize, "observations"))
        seen.append(file.array(OBSERVED, counts[-1]))
    file.end()
    joined = np.concatenate(seen) if seen else np.empty(0, OBSERVED)

    file = _Bytes(points)
    count = file.count(51, "points")
    ids, places, errors = np.empty(count, np.int64), np.empty((count, 3)), np.empty(count)
    for k in range(count):
        ids[k], *places[k], _, _, _, errors[k] = file.numbers("q3d3Bd")
        file.skip(TRACK.itemsize * file.count(TRACK.itemsize, "observations"))
    file.end()
    taken = _Images(names, own, np.array(poses).reshape(-1, 7), counts, joined["at"], joined["point"])
    return sizes, taken, _Points(ids, places, errors)


def _size(file: Path, number: int, width: int, height: int) -> tuple[int, int]:
    if not (0 < width < 1 << 20 and 0 < height < 1 << 20):
        raise ValueError(f"'{file}': camera {number}: {width} x {height} pixels: must be 1 to {(1 << 20) - 1} each")
    return width, height


def _lines(path: Path, *, blank: bool) -> Iterator[tuple[str, list[str]]]:
    """Yield each line's place and words, without comments. blank: blank lines mean something, too."""
    text = decoded(read_limited(path, f"'{path}'", BYTES_MAX), f"'{path}'", "text")
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("#") and (blank or line.strip()):
            yield f"'{path}': line {number}", line.split()


def _converted(place: str, words: list[str], kind: Callable[[str], int | float], what: str) -> list[Any]:
    try:
        return [kind(word) for word in words]
    except (ValueError, OverflowError):
        raise ValueError(f"{place}: '{' '.join(words)[:SHOWN]}': must be {what}") from None


def _read_text(cameras: Path, images: Path, points: Path) -> tuple[dict[int, tuple[int, int]], _Images, _Points]:
    sizes = {}
    for place, words in _lines(cameras, blank=False):
        if len(words) < 5:
            raise ValueError(f"{place}: must be CAMERA_ID MODEL WIDTH HEIGHT PARAMS")
        number, width, height = _converted(place, [words[0], *words[2:4]], int, "whole numbers")
        sizes[number] = _size(cameras, number, width, height)

    names, own, poses, counts, seen = [], [], [], [], []
    lines = _lines(images, blank=True)
    for place, words in lines:
        if not words:
            continue
        if len(words) < 10:
            raise ValueError(f"{place}: must be IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME")
        poses.append(_converted(place, words[1:8], float, "numbers"))
        own += _converted(place, words[8:9], int, "a whole number")
        names.append(" ".join(words[9:]))
        place, words = next(lines, (place, []))
        if len(words) % 3:
            raise ValueError(f"{place}: {len(words)} words: must be X Y POINT3D_ID for each observation")
        counts.append(len(words) // 3)
        seen.append(np.array(_converted(place, words, float, "numbers")).reshape(-1, 3))

    ids, rows = [], []
    for place, words in _lines(points, blank=False):
        if len(words) < 8:
            raise ValueError(f"{place}: must be POINT3D_ID X Y Z R G B ERROR TRACK")
        ids += _converted(place, words[:1], int, "a whole number")
        rows.append(_converted(place, words[1:8], float, "numbers"))
    joined = np.concatenate(seen) if seen else np.empty((0, 3))
    if not (np.abs(joined[:, 2]) < 1 << 53).all() or not all(0 <= each < 1 << 53 for each in ids):
        raise ValueError(f"'{points}': identifiers must be whole numbers below 2^53")
    table = np.array(rows, np.float64).reshape(-1, 7)
    taken = _Images(names, own, np.array(poses).reshape(-1, 7), counts, joined[:, :2], joined[:, 2].astype(np.int64))
    return sizes, taken, _Points(np.array(ids, np.int64), table[:, :3], table[:, 6])
