"""Requests and responses of the scene editor's services; see `messages`."""

from __future__ import annotations

from typing import Any, Literal

from uwsim.operator.station.wire.messages import Message


class Edit(Message):
    """A request to the editor.

    action: new, open, report, set, add, move, remove, undo, redo, revert, check, save,
    meshes, upload, apply or close.

    scenario: the one to open, by default the running one. section, place: of a part. kind, vehicle, at_m: of one to
    add. values: fields to set, also of one to add; null removes one. name: under
    which it is saved, or of a mesh to upload. to: the number of the goal with which one changes places. size, at, data:
    bytes of the whole mesh, and a part of it in Base64.
    """

    action: str
    scenario: str | None = None
    section: str | None = None
    place: list[Any] | None = None
    kind: str | None = None
    vehicle: int | None = None
    at_m: list[float] | None = None
    values: dict[str, Any] | None = None
    name: str | None = None
    to: int | None = None
    size: int | None = None
    at: int | None = None
    data: str | None = None


class BedGrid(Message):
    """The grid of heights in FILES/terrain.f32, in the world. edition: changes with the heights."""

    rows: int
    columns: int
    west_m: float
    south_m: float
    spacing_m: list[float]
    edition: int


class EditedPart(Message):
    """A part of the edited scene. vehicle: the number of the vehicle that carries it.

    place: its keys in the file, after "exercise" for the exercise's. is_inherited: whether it comes from the vehicle's
    own file, or is a start at the station. frame: x, y [m], yaw [deg] and z [m] in the world of the axes of its
    position. values: as written, tables as rows of numbers. outline_m: of an obstacle. choices: names of the scene that
    a field can have, by field.
    """

    section: str
    place: list[Any]
    name: str
    kind: str
    vehicle: int | None
    is_inherited: bool
    frame: list[float]
    values: dict[str, Any]
    outline_m: list[list[float]]
    choices: dict[str, list[str]]


class EditState(Message):
    """The editor's state; without a scenario, only is_open, false. by: the name of the client that edits.

    edition: changes with the text. files: the secret address FILES of what belongs to the scene. plan: changes with the
    obstacles and props, whose solids are FILES/PLAN/NUMBER.glb, in this order. added: the place of what was added or
    moved, or empty. mistakes: found by `check`.
    meshes: the files of which solids can be made, with a still at FILES/mesh/FILE.png. mesh: the file of a finished
    upload, "" before; lost: what of it was not taken along.
    """

    success: Literal[True]
    message: str
    is_open: bool
    by: str
    name: str | None = None
    edition: int | None = None
    can_undo: bool | None = None
    can_redo: bool | None = None
    is_saved: bool | None = None
    is_of_running: bool | None = None
    grid: BedGrid | None = None
    plan: int | None = None
    vehicles: list[str] | None = None
    parts: list[EditedPart] | None = None
    text: str | None = None
    added: list[Any] | None = None
    mistakes: list[str] | None = None
    files: str | None = None
    meshes: list[str] | None = None
    mesh: str | None = None
    lost: str | None = None


class FormField(Message):
    """A field of a kind of part. type: number (width: how many), flag, choice, text, file, table (columns) or yaml.

    low, high: bounds in unit, or null. choices: what it can be or, of a text, what is packaged. by_default: its value
    if it is left out; of a table, one for each column. role: place, turn or line for what the chart moves, mesh for a
    mesh's file, or "". start: with which a new part begins, or null. one_of: fields of which a part has one.
    """

    name: str
    meaning: str
    type: Literal["number", "flag", "choice", "text", "file", "table", "yaml"]
    unit: str
    low: float | None
    high: float | None
    width: int
    columns: list[str]
    choices: list[Any]
    by_default: Any
    is_required: bool
    role: Literal["", "place", "turn", "line", "mesh"]
    start: Any
    one_of: list[str]


class FormKind(Message):
    """A kind of part, "" if its section has no kinds, and its fields."""

    kind: str
    fields: list[FormField]


class FormSection(Message):
    """A section of a scenario. holds: list, names or one. of_vehicle: whether each vehicle has it."""

    name: str
    title: str
    holds: Literal["list", "names", "one"]
    of_vehicle: bool
    kinds: list[FormKind]


class EditForms(Message):
    """The sections of a scenario that can be edited, with their kinds and fields, from its schema."""

    success: Literal[True]
    sections: list[FormSection]
