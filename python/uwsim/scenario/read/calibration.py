"""Calibrations of cameras, in the YAML of ROS's camera_calibration and of OpenCV's FileStorage."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base import lens_model
from uwsim.base.atomic_file import write_atomically
from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.base.texts.yaml_document import MAX_BYTES, YamlDocument, yaml_document
from uwsim.scenario.read.errors import ScenarioError

SIDE_MAX = 1_000_000
MATRIX = ("camera_matrix", "K", "M", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix")
COEFFICIENTS = ("distortion_coefficients", "D", "distCoeffs", "dist_coeffs", "Distortion_Coefficients", "dist_coeff")
WIDTH, HEIGHT = ("image_width", "width", "image_Width"), ("image_height", "height", "image_Height")


class CalibrationWarning(UserWarning):
    """Issued for a calibration with which pictures are not, or perhaps not, as the camera's."""


def read_calibration(path: str | Path) -> dict[str, Any]:
    """Return a file's calibration as fields of a CameraMount: width, height, fx, fy, cx, cy and distortion.

    The file is by ROS's camera_calibration (camera_matrix, distortion_model, distortion_coefficients) or OpenCV's
    FileStorage (the same, or K and D, in which the size may be missing). Rectification and projection matrices are not
    read: they describe a use of the pictures, not the lens. Raises ScenarioError with the file's name and line.
    """
    document = _document(Path(path))
    try:
        return _fields(document)
    except ValueError as error:
        raise error if isinstance(error, ScenarioError) else ScenarioError(f"{document.name}: {error}") from None


def calibrated_fields(path: Path, width: object = None, height: object = None) -> dict[str, Any]:
    """Return the fields of a file's calibration, scaled to a width and a height [pixels], by default the file's own.

    With only one of both, the aspect ratio is the file's. Raises ScenarioError.
    """
    found = read_calibration(path)
    whole = [value if type(value) is int and value > 0 else None for value in (width, height)]
    if "width" not in found:
        if None in whole:
            raise ScenarioError(f"{path}: holds no image_width and image_height: give width and height beside it")
        return {**found, "width": whole[0], "height": whole[1]}
    size = found["width"], found["height"]
    to = (
        whole[0] or (size[0] if whole[1] is None else max(1, round(size[0] * whole[1] / size[1]))),
        whole[1] or (size[1] if whole[0] is None else max(1, round(size[1] * whole[0] / size[0]))),
    )
    scaled = lens_model.resized(*(found[key] for key in ("fx", "fy", "cx", "cy")), size=size, to=to)
    return {**found, **dict(zip(("fx", "fy", "cx", "cy"), scaled, strict=True)), "width": to[0], "height": to[1]}


def write_calibration(path: str | Path, info: Any, name: str = "camera") -> None:
    """Write a calibration atomically: .yaml as ROS's camera_info, .yml as OpenCV's FileStorage.

    info: as sensor_msgs/CameraInfo, such as a camera's `info`. Raises ValueError for other suffixes, OSError if writing
    fails.
    """
    target = Path(path)
    check_suffix(target)
    matrices = {
        "camera_matrix": np.reshape(info.k, (3, 3)),
        "distortion_coefficients": np.reshape(info.d, (1, -1)),
        "rectification_matrix": np.reshape(info.r, (3, 3)),
        "projection_matrix": np.reshape(info.p, (3, 4)),
    }
    is_ros = target.suffix == ".yaml"
    lines = [] if is_ros else ["%YAML:1.0", "---"]
    lines += [f"image_width: {info.width}", f"image_height: {info.height}", f"camera_name: {name}"]
    for key, matrix in matrices.items():
        if key == "distortion_coefficients":
            lines.append(f"distortion_model: {info.distortion_model}")
        lines += [f"{key}:" if is_ros else f"{key}: !!opencv-matrix", *(f"  rows: {len(matrix)}",)]
        lines += [f"  cols: {matrix.shape[1]}", *(() if is_ros else ("  dt: d",))]
        lines.append(f"  data: [{', '.join(_number(value) for value in matrix.ravel())}]")
    write_atomically(target, ("\n".join(lines) + "\n").encode())


def check_suffix(path: Path) -> None:
    """Raise ValueError unless the suffix names a format of calibrations."""
    if path.suffix not in (".yaml", ".yml"):
        raise ValueError(f"calibration = {path}: must end in .yaml (ROS) or .yml (OpenCV)")


def _number(value: float) -> str:
    """Return a number as all versions of YAML read it: with a point, which 1.1 needs before an exponent."""
    mantissa, e, exponent = repr(float(value)).partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}{e}{exponent}"


def _document(path: Path) -> YamlDocument:
    name = str(path)
    try:
        text = decoded(read_limited(path, name, MAX_BYTES), name, "YAML text")
        # OpenCV's "%YAML:1.0" and "!!opencv-matrix" are no YAML; without them, its files are.
        return yaml_document(re.sub(r"!!opencv-[a-z-]+", "", re.sub(r"\A%YAML[^\n]*", "", text)), name)
    except ValueError as error:
        raise ScenarioError(str(error)) from None


def _fields(document: YamlDocument) -> dict[str, Any]:
    values = document.values
    inner = [name for name, part in values.items() if isinstance(part, Mapping) and _key(part, MATRIX)]
    if _key(values, MATRIX) is None and inner:
        raise ValueError(f"camera_matrix: missing; {', '.join(inner)} have one: a calibration is one of one camera")
    matrix = _numbers(document, MATRIX)
    if len(matrix) != 9 or matrix[1] or matrix[3] or matrix[6:] != [0.0, 0.0, 1.0]:
        raise ValueError(f"{_key(values, MATRIX)} = {matrix}: must be fx, 0, cx; 0, fy, cy; 0, 0, 1")
    if matrix[0] <= 0.0 or matrix[4] <= 0.0:
        raise ValueError(
            f"fx = {matrix[0]:g}, fy = {matrix[4]:g} pixels: must be above 0: the file holds no calibration"
        )
    given = str(values.get("distortion_model") or ("equidistant" if values.get("fisheye_model") else ""))
    model, distortion = lens_model.coefficients(given, _numbers(document, COEFFICIENTS))
    found: dict[str, Any] = {"fx": matrix[0], "fy": matrix[4], "cx": matrix[2], "cy": matrix[5]}
    found |= {"distortion_model": model, "distortion": distortion}
    size = [values[key] for names in (WIDTH, HEIGHT) if (key := _key(values, names)) is not None]
    if not size:
        return found
    if len(size) < 2 or not all(type(side) is int and 0 < side <= SIDE_MAX for side in size):
        raise ValueError(f"image_width, image_height = {size}: must be two numbers of pixels, at most {SIDE_MAX}")
    for key, side in (("cx", size[0]), ("cy", size[1])):
        if not 0.0 <= found[key] < side:
            text = (
                f"{document.name}: {key} = {found[key]:g} is beyond the picture's {side} pixels: check the file's size"
            )
            warnings.warn(text, CalibrationWarning, stacklevel=2)
    return {"width": size[0], "height": size[1], **found}


def _key(values: Mapping[str, Any], names: Sequence[str]) -> str | None:
    return next((name for name in names if values.get(name) is not None), None)


def _numbers(document: YamlDocument, names: Sequence[str]) -> list[float]:
    """Return a matrix's numbers, row by row: its `data`, or a list of numbers or rows. Raises ScenarioError."""
    key = _key(document.values, names)
    if key is None:
        raise ValueError(f"{names[0]}: missing")
    value = document.values[key]
    listed = value.get("data") if isinstance(value, Mapping) else value
    try:
        numbers = np.array(listed, np.float64).ravel()
    except (TypeError, ValueError, OverflowError):
        numbers = np.array([np.nan])
    if not isinstance(listed, list) or not np.isfinite(numbers).all():
        raise ScenarioError(f"{document.name}:{document.line([key])}: {key}: must be a list of finite numbers")
    return [float(number) for number in numbers]
