"""Which fields of a scenario are parameters, and their names where these differ from the field names."""

from __future__ import annotations

from typing import get_args

from uwsim.base.axes import AXES
from uwsim.scenario.spec.actuator import FinMount, ThrusterMount, ThrusterType
from uwsim.scenario.spec.battery import BatterySetup, BatteryType
from uwsim.scenario.spec.camera import INTRINSICS, CameraMount, Lamps
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.imaging_sonar import ImagingMount
from uwsim.scenario.spec.optics import WaterCoefficients
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.settings import Station
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import SonarSetup, VehicleEntry
from uwsim.scenario.spec.water import (
    AirySurface,
    FieldProfile,
    GriddedCurrent,
    GustyCurrent,
    JonswapSurface,
    LayeredCurrent,
    LinearProfile,
    StillSurface,
    TableProfile,
    TidalCurrent,
    TideCurrent,
    UniformCurrent,
    Water,
)

COORDINATES = ("x", "y", "z")
COLOURS = ("red", "green", "blue")

FIXED: dict[type[Model], frozenset[str]] = {
    Scenario: frozenset(
        [
            "name",
            "description",
            "seed",
            "step_s",
            "dynamics",
            "earth",
            "terrain",
            "ground",
            "detail",
            "view",
            "obstacles",
            "cover",
            "life",
            "objects",
            "props",
            "pingers",
            "sound",
            "wind",
            "water_targets",
            "link",
            "survey",
            "faults",
        ]
    ),
    Water: frozenset({"volume_strength_db", "tide"}),
    GriddedCurrent: frozenset({"file"}),
    TideCurrent: frozenset({"constituent", "begin"}),
    FieldProfile: frozenset({"file"}),
    TableProfile: frozenset({"file"}),
    Station: frozenset(["position_m", "yaw_deg", "mesh", "dock_m", "exit_m", "material", "carrier"]),
    VehicleEntry: frozenset({"name", "start", "failsafe", "trim", "wrenches", "tether", "droppers"}),
    VehicleModel: frozenset(
        [
            "builds_on",
            "name",
            "description",
            "mesh",
            "mesh_scale",
            "mesh_up",
            "mesh_forward",
            "collision",
            "collision_pieces",
            "density_kg_m3",
            "buoyancy",
            "sonar",
            "material",
            "control",
            "failsafe",
            "trim",
            "arm",
            "coefficients",
            "windage",
            "hydrophones",
        ]
    ),
    ThrusterMount: frozenset({"position_m", "axis", "spin", "force", "moved_from_m", "ventilates"}),
    ThrusterType: frozenset({"name", "description", "pwm", "thrust_n", "sheets"}),
    BatterySetup: frozenset({"initial_charge"}),
    BatteryType: frozenset({"name", "description", "open_circuit_v"}),
    FinMount: frozenset({"position_m", "span"}),
    SensorMount: frozenset({"kind", "grade", "position_m", "yaw_pitch_roll_deg", "noise_std", "parameters"}),
    SonarSetup: frozenset({"tilt_deg", "multipath", "water_column"}),
    CameraMount: frozenset(
        [
            *(
                "position_m",
                "yaw_pitch_roll_deg",
                "width",
                "height",
                *INTRINSICS,
                "calibration",
                "distortion_model",
                "distortion",
                "port",
            ),
            *("follows", "pan_tilt", "rate_hz"),
        ]
    ),
    Lamps: frozenset({"spots"}),
    ImagingMount: frozenset({"kind", "position_m", "yaw_pitch_roll_deg", "figures"}),
}
"""Fields that are fixed when the simulator is created (its parts, mounts and appearance), and those controlled by
another field or a command (a sonar's tilt is set by aim)."""

NAMES: dict[tuple[type[Model], str], str] = {
    (Scenario, "vehicles"): "",
    (VehicleEntry, "model"): "",
    (ThrusterMount, "model"): "",
    (BatterySetup, "model"): "",
    (VehicleModel, "linear_damping"): "drag.linear",
    (VehicleModel, "linear_damping_matrix"): "drag.linear",
    (VehicleModel, "quadratic_damping"): "drag.quadratic",
    (VehicleModel, "quadratic_damping_matrix"): "drag.quadratic",
    (VehicleModel, "added_mass_matrix"): "added_mass",
}
"""Names of fields; "" for fields whose own parts directly follow the name of their parent."""

ITEM_NAMES: dict[tuple[type[Model], str], tuple[str, ...]] = {
    (Lamps, "colour"): COLOURS,
    **{(WaterCoefficients, key): COLOURS for key in WaterCoefficients.model_fields},
}

KINDS: dict[type[Model], tuple[str, ...]] = {
    kind: tuple(get_args(arm.model_fields["kind"].annotation)[0] for arm in arms)
    for arms in (
        (StillSurface, AirySurface, JonswapSurface),
        (UniformCurrent, LayeredCurrent, TidalCurrent, GustyCurrent, GriddedCurrent, TideCurrent),
        (TableProfile, LinearProfile, FieldProfile),
    )
    for kind in arms
}
"""The kinds that may replace a model's kind, each with its own keys."""

WHOLE = {("water", "surface"), ("water", "current"), ("water", "profile"), ("optics", "coefficients")}
"""Places whose parts belong together: setting one from a dict or a list replaces all of them."""


def why_fixed(name: str) -> str:
    """Return the reason why a scenario's value is not a parameter, or an empty string if there is no such value."""
    field = name.rpartition(".")[2]
    if field == "tilt_deg":
        return "it holds for the start; aim() turns the head"
    return "it is fixed when the simulator is made" if any(field in fields for fields in FIXED.values()) else ""


def position_or_key(part: str) -> str | int:
    """Convert one part of a name to its form in plain values: an item index or a key."""
    for names in (COORDINATES, COLOURS):
        if part in names:
            return names.index(part)
    return int(part) if part.isdecimal() else part


def is_absent(model: Model, field: str) -> bool:
    """Return whether a field does not apply to a model because the model specifies its alternative."""
    if field in ("max_force_n", "max_torque_nm", "battery") or field.endswith("_matrix"):
        return getattr(model, field) is None
    if isinstance(model, CameraMount) and field == "field_of_view_deg":
        return model.fx is not None
    matrix = field + "_matrix"
    return matrix in type(model).model_fields and getattr(model, matrix) is not None


LISTS = {("water", "current")}
"""The places in WHOLE that contain a list; a scenario may specify a single item without a list."""


def item_names(owner: type[Model], field: str, count: int) -> tuple[str, ...]:
    """Return the names of the items of a tuple."""
    if (owner, field) in ITEM_NAMES:
        return ITEM_NAMES[owner, field]
    if field == "limits":
        return "low", "high"
    if owner is SensorMount and count > 3:
        return tuple(map(str, range(count)))
    return {6: AXES, 3: COORDINATES}.get(count) or tuple(map(str, range(count)))
