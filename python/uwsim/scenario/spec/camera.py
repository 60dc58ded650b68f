"""Cameras and lamps of a vehicle or of a scenario's station."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, StrictBool, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.base import lens_model
from uwsim.scenario.read.calibration import calibrated_fields
from uwsim.scenario.spec.fields import (
    AssetFile,
    Degrees,
    InRange,
    Model,
    Name,
    OneOf,
    Point3,
    YawPitchRoll,
    asset_at,
    broken,
)

LARGEST_SIDE = 8192
FIELD_DEG = 1, 170
INTRINSICS = ("fx", "fy", "cx", "cy")
DOCK_VIEW_M = (2.9, 1.3, 1.5)
FORWARD: tuple[float, float, float] = (0.0, 0.0, 0.0)
Pixels = Annotated[int, InRange(1, LARGEST_SIDE, "pixels")]
FocalLength = Annotated[float, InRange(1, 1e6, "pixels")]
Principal = Annotated[float, InRange(-1e5, 1e5, "pixels")]
Coefficient = Annotated[float, InRange(-1e4, 1e4)]
Share = Annotated[float, InRange(0, 1)]
Colour = tuple[Share, Share, Share]


class PanTilt(Model):
    """A motor that turns a camera on its mount: pan about its z, positive to port, then tilt about y, positive down.

    pan_limits_deg, tilt_limits_deg: lower, upper; the range must include 0, the mount's own direction. rate_deg_s:
    turning rate of each axis.
    """

    pan_limits_deg: tuple[Degrees, Degrees] = (0.0, 0.0)
    tilt_limits_deg: tuple[Degrees, Degrees] = (0.0, 0.0)
    rate_deg_s: Annotated[float, InRange(0.01, 1e4, "deg/s")] = 30.0

    @model_validator(mode="after")
    def _includes_zero(self) -> PanTilt:
        for key in ("pan_limits_deg", "tilt_limits_deg"):
            low, high = getattr(self, key)
            if not low <= 0.0 <= high:
                raise broken("must be from, to, with 0 between them", at=(key,), value=[low, high], unit="deg")
        return self


class FlatPort(Model):
    """A flat window between the lens, in air, and the water, across the camera's axis.

    distance_m: distance from the lens's centre of projection to the inside of the glass. thickness_m: thickness of the
    glass. refractive_index: refractive index of the glass, by default that of acrylic.
    """

    distance_m: Annotated[float, InRange(0, 1, "m")] = 0.0
    thickness_m: Annotated[float, InRange(0, 1, "m")] = 0.0
    refractive_index: Annotated[float, InRange(1, 3)] = 1.49


class CameraMount(Model):
    """A camera: its mount, lens and image sensor.

    It looks along its x: yaw 90 turns it to port, pitch 90 down. position_m: position in the frame of its carrier.
    width, height: size in pixels. field_of_view_deg: angle across the image's width, before distortion, for square
    pixels and a principal point in the middle. fx, fy, cx, cy: instead of it, the focal lengths and the principal point
    of a calibration; pixel centres have whole coordinates, as in OpenCV. calibration: instead of these, width, height
    and distortion, a YAML file of ROS's camera_calibration or of OpenCV's FileStorage; a width or height beside it
    scales the picture. distortion_model: plumb_bob (Brown and Conrady), rational_polynomial, or equidistant, a fisheye
    (Kannala and Brandt). distortion: its coefficients as in OpenCV: k1, k2, p1, p2, k3; these and k4, k5, k6; or k1,
    k2, k3, k4. port: a flat window, at which rays from the
    water are refracted: field of view and distortion are then those of the lens in air. Without it they hold in water
    as in air, as behind a dome, or after a calibration under water. exposure: a factor on the automatic or
    fixed exposure. full_well, read_noise: numbers of electrons at base gain. vignetting: fraction of the cos^4 law.
    wobble_mrad: largest deflection of a ray by turbulence; by default derived from `optics.turbulence_k`. shutter_ms:
    time for which each row collects light, during which the camera's own motion blurs the picture. readout_ms: time
    from the first row's exposure to the last's, for a rolling shutter. The time stamp is the middle of both. follows:
    its carrier; `body`: fixed to the hull, which does not appear in its pictures; `heading`: it follows the vehicle's
    position and heading from outside, level, and stays above the ground. pan_tilt: its motor, if any. rate_hz: pictures
    in a second on its topics, in simulated time; the service set_stream changes it. on: a camera that is off produces
    black pictures.
    """

    position_m: Point3
    yaw_pitch_roll_deg: YawPitchRoll = FORWARD
    width: Pixels = 640
    height: Pixels = 360
    field_of_view_deg: Annotated[float, InRange(*FIELD_DEG, "deg")] = 80.0
    fx: FocalLength | None = None
    fy: FocalLength | None = None
    cx: Principal | None = None
    cy: Principal | None = None
    calibration: AssetFile | None = None
    distortion_model: Annotated[str, OneOf(tuple(lens_model.COEFFICIENTS))] = "plumb_bob"
    distortion: Annotated[tuple[Coefficient, ...], Field(min_length=4, max_length=8)] = (0.0, 0.0, 0.0, 0.0, 0.0)
    port: FlatPort | None = None
    exposure: Annotated[float, InRange(0.001, 1000)] = 1.0
    full_well: Annotated[float, InRange(1, 1e9, "electrons")] = 8000.0
    read_noise: Annotated[float, InRange(0, 1e6, "electrons")] = 6.0
    vignetting: Share = 0.5
    wobble_mrad: Annotated[float, InRange(0, 100, "mrad")] | None = None
    shutter_ms: Annotated[float, InRange(0, 1000, "ms")] = 0.0
    readout_ms: Annotated[float, InRange(0, 1000, "ms")] = 0.0
    follows: Literal["body", "heading"] = "body"
    pan_tilt: PanTilt | None = None
    rate_hz: Annotated[float, InRange(0.01, 10, "Hz")] = 10.0
    on: StrictBool = True

    @model_validator(mode="before")
    @classmethod
    def _reads_its_calibration(cls, data: object, info: ValidationInfo) -> object:
        if not isinstance(data, Mapping) or data.get("calibration") is None:
            return data
        found = calibrated_fields(asset_at(data["calibration"], info), data.get("width"), data.get("height"))
        for key, value in found.items():
            if key in data and np.any(np.asarray(data[key]) != np.asarray(value)):
                raise broken(f"must be that of calibration, {value}, or left out", at=(key,), value=data[key])
        return {**data, **found}

    @model_validator(mode="after")
    def _has_the_coefficients_of_its_model(self) -> CameraMount:
        names = lens_model.COEFFICIENTS[self.distortion_model]
        if "distortion" not in self.model_fields_set:
            self.__dict__["distortion"] = (0.0,) * len(names)
        if len(self.distortion) != len(names):
            rule = f"must be {', '.join(names)}, as distortion_model is {self.distortion_model}"
            raise broken(rule, at=("distortion",), value=list(self.distortion))
        return self

    @model_validator(mode="after")
    def _has_one_lens(self) -> CameraMount:
        stated = [key for key in INTRINSICS if getattr(self, key) is not None]
        absent = [key for key in INTRINSICS if key not in stated]
        if stated and absent:
            raise broken(f"missing: give all or none of {', '.join(INTRINSICS)}", at=(absent[0],))
        if self.fx is None:
            return self
        if "field_of_view_deg" in self.model_fields_set:
            rule = f"must not be given beside {', '.join(INTRINSICS)}"
            raise broken(rule, at=("field_of_view_deg",), value=self.field_of_view_deg, unit="deg")
        self.__dict__["field_of_view_deg"] = _across_deg(self.fx, self.width)
        if not FIELD_DEG[0] <= self.field_of_view_deg <= FIELD_DEG[1]:
            rule = (
                f"the field of view across the width, {self.field_of_view_deg:.3g} deg, must be in {[*FIELD_DEG]} deg"
            )
            raise broken(rule, at=("fx",), value=self.fx, unit="pixels")
        return self

    @model_validator(mode="after")
    def _turns_on_the_hull(self) -> CameraMount:
        if self.pan_tilt is not None and self.follows == "heading":
            raise broken("is only for a camera that is fixed to the hull", at=("pan_tilt",))
        return self

    def resized(self, width: int, height: int) -> CameraMount:
        """Return this mount for a picture of another size with the same field of view across the width."""
        other: dict[str, Any] = {"width": width, "height": height}
        if None not in (lens := [getattr(self, key) for key in INTRINSICS]):
            scaled = lens_model.resized(*lens, size=(self.width, self.height), to=(width, height))
            other |= {**dict(zip(INTRINSICS, scaled, strict=True)), "field_of_view_deg": _across_deg(scaled[0], width)}
        return self.model_copy(update=other)


def _across_deg(fx: float, width: int) -> float:
    """Return the angle across a width in pixels, before distortion."""
    return 2.0 * math.degrees(math.atan(0.5 * width / fx))


class LampSpot(Model):
    """The mount of one lamp on a switch; the lamp shines along its x.

    position_m: position in the body frame.
    """

    position_m: Point3
    yaw_pitch_roll_deg: YawPitchRoll = FORWARD


class Lamps(Model):
    """The lamps on one switch, identical except for their mounts.

    spots: their mounts. on: whether they are initially on. flux_lm: luminous flux of each lamp. half_angle_deg: half
    angle of the cone of light, outside which it is dark. soft_share: fraction of that angle over which the light fades.
    colour: red, green, blue relative to daylight white.
    """

    spots: Annotated[tuple[LampSpot, ...], Field(min_length=1, max_length=16)]
    on: StrictBool = False
    flux_lm: Annotated[float, InRange(0, 1e6, "lm")] = Field(examples=[3000])
    half_angle_deg: Annotated[float, InRange(1, 85, "deg")] = 35.0
    soft_share: Annotated[float, InRange(0.01, 1)] = 0.5
    colour: Colour = (1.0, 0.96, 0.9)


CameraMounts = Annotated[dict[Name, CameraMount], Field(max_length=32)]
LampSwitches = Annotated[dict[Name, Lamps], Field(max_length=16)]

DECK_CAMERA = CameraMount.model_construct(
    position_m=(-3.4, 0.9, 4.6), yaw_pitch_roll_deg=(22.0, 16.0, 0.0), field_of_view_deg=80.0
)
"""Above the hut of the packaged station, overlooking its deck and the water ahead, with the mast at the right."""


def dock_camera(dock_m: Point3) -> CameraMount:
    """Return a camera in front of a dock, above and beside the exit, looking back at the docked vehicle."""
    ahead_m, aside_m, above_m = DOCK_VIEW_M
    back_deg = 180.0 + math.degrees(math.atan2(aside_m, ahead_m))
    down_deg = math.degrees(math.atan2(above_m, math.hypot(ahead_m, aside_m)))
    return CameraMount.model_construct(
        position_m=(dock_m[0] + ahead_m, dock_m[1] + aside_m, dock_m[2] + above_m),
        yaw_pitch_roll_deg=(back_deg, down_deg, 0.0),
        field_of_view_deg=70.0,
    )
