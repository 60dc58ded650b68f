"""The station's editor: who edits which scenario, its parts as the page shows them, and where it goes."""

from __future__ import annotations

import math
import secrets
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import orjson

from uwsim.base.arguments import is_number
from uwsim.base.atomic_file import write_atomically
from uwsim.base.texts.yaml_document import read_yaml
from uwsim.channels.guest import Values
from uwsim.flight.survey_check import checked
from uwsim.operator.station.editor.draft import MAX_BYTES, Draft, Place
from uwsim.operator.station.editor.forms import SECTIONS
from uwsim.operator.station.editor.meshes import Meshes
from uwsim.operator.station.editor.vehicle_parts import is_inherited
from uwsim.scenario import Scenario, exports, start_pose
from uwsim.scenario.dump import plain, yaml_text
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.fields import NAME

PLACE_MAX = 6
NEW = "scene"
"""The name of a new scene."""
SAVED_MAX = 100
"""The files of a folder that are looked through."""


class Editor:
    """One scenario being edited by one client at a time. folder: where it is saved. threads: of simulators.

    What a client leaves unsaved, for example as its page reloads, is there for the next who opens the same scenario.
    saved: the paths of the scenarios in the folder, those of earlier stations too, by their names on the start screen.
    Files that hold none are left out when they are listed. Methods may be called on any thread.
    """

    def __init__(self, folder: Path, threads: int | None) -> None:
        files = [path for path in sorted(folder.glob("*.yaml")) if NAME.fullmatch(path.stem) and path.is_file()]
        self.saved = {path.name: path for path in files[:SAVED_MAX]}
        self._folder, self._threads = folder, threads
        self._lock, self._changing, self._building = threading.Lock(), threading.Lock(), threading.Lock()
        self._draft: Draft | None = None
        self._base = ""  # the text that was opened or saved last
        self._by = self._opened = self._name = ""
        self._archive = ("", b"")
        self.meshes = Meshes(folder)

    @property
    def by(self) -> str:
        """The client that edits, or ""."""
        return self._by

    def open(self, client: str, name: str, path: Path, *, is_of_same: bool) -> bool:
        """Open a scenario's file for a client. Raises ScenarioError or ValueError.

        is_of_same: whether the scenario being edited was opened from a file, too. If it is this one, and has unsaved
        changes, editing continues, and the result is True.
        """
        make = partial(self._of_file, path)
        return self._take(client, name, make, is_of_same)

    def open_new(self, client: str) -> bool:
        """Open a new scene, with no more than a bed, water and a vehicle. If one is unsaved, editing continues."""
        text = (assets_folder() / "templates" / "scene.yaml").read_text(encoding="utf-8").replace("@NAME@", NEW)
        return self._take(client, NEW, lambda: Draft(text, f"{NEW}.yaml", self._folder), is_of_same=True)

    def open_running(
        self, client: str, scenario: Scenario, is_of_file: Callable[[Scenario], bool], *, is_of_same: bool
    ) -> bool:
        """Open the scenario of the running simulator: its file's text or, if that gives another, its plain values.

        is_of_same: whether the scenario being edited is that of the same simulator; see `open`.
        """

        def make() -> Draft:
            document = scenario.source_file.document
            if document is not None:
                found = Draft(document.text, Path(document.name).name, self._folder)
                if is_of_file(found.scenario):
                    return found
            return Draft(yaml_text(plain(scenario)), f"{scenario.name}.yaml", self._folder)

        return self._take(client, scenario.name, make, is_of_same)

    def _of_file(self, path: Path) -> Draft:
        """Return a file's draft; a packaged one, which names packaged files only, may also name those in the folder."""
        folder = self._folder if assets_folder() in path.parents else path.resolve().parent
        return Draft(read_yaml(path, path.name).text, path.name, folder)

    def _take(self, client: str, name: str, make: Callable[[], Draft], is_of_same: bool) -> bool:
        with self._alone():
            kept = self._draft
            is_of_same = is_of_same and name in (self._opened, self._name)
            if kept is not None and is_of_same and kept.text != self._base:
                self._by = client
                return True
            draft = make()
            self._draft, self._base, self._by = draft, draft.text, client
            self._opened = self._name = name
            return False

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Make one change at a time, and refuse others, which would occupy the threads of all services."""
        if not self._changing.acquire(blocking=False):
            raise ValueError("another change is being made: wait for its answer")
        try:
            with self._lock:
                yield
        finally:
            self._changing.release()

    def close(self, client: str) -> None:
        """End a client's editing, and forget what was not saved."""
        with self._lock:
            if client == self._by:
                self._draft, self._by, self._archive = None, "", ("", b"")
                self.meshes.forget()

    def left(self, client: str) -> None:
        """End a client's editing, and keep what was not saved; a change that is being made is not waited for."""
        if client == self._by:
            self._by = ""

    def act(self, request: Values) -> Place:
        """Change the scenario; return the place of a part that was added, or (). Raises ValueError."""
        try:
            size = len(orjson.dumps(request))
        except TypeError as error:  # such as whole numbers of more than 64 bits
            raise ValueError(f"a change must be plain JSON: {error}") from None
        if size > MAX_BYTES:  # before anything is made of it
            raise ValueError(f"a change must have at most {MAX_BYTES} bytes")
        with self._alone():
            draft, action = self.draft, request.get("action")
            if action in ("undo", "redo"):
                draft.undo(1 if action == "undo" else -1)
                return ()
            if action == "revert":
                draft.replace(self._base)
                return ()
            section, values = str(request.get("section") or ""), request.get("values") or {}
            if not isinstance(values, dict) or (action == "set" and not values):
                raise ValueError("values: must be fields and their values")
            if action == "add":
                at_m, vehicle = request.get("at_m") or [0.0, 0.0], request.get("vehicle") or 0
                if not (isinstance(at_m, list) and len(at_m) == 2 and all(map(is_number, at_m))):
                    raise ValueError("at_m: must be two numbers")
                if not is_number(vehicle) or vehicle % 1:
                    raise ValueError(f"vehicle = {str(vehicle)[:40]}: must be a whole number")
                return draft.add(section, str(request.get("kind") or ""), int(vehicle), at_m, values)
            place = _place(request.get("place"))
            if action == "remove":
                draft.remove(section, place)
            else:
                draft.set(section, place, values)
            return ()

    def save(self, name: object) -> Path:
        """Write the scenario under a name; return its path. Raises ValueError or OSError."""
        with self._lock:
            if not isinstance(name, str) or not NAME.fullmatch(name):
                rule = "must be a letter followed by at most 39 letters, digits, '-' or '_'"
                raise ValueError(f"name = {str(name)[:40]!r}: {rule}")
            path = self._folder / f"{name}.yaml"
            self.draft.rename(name)
            self.draft.checked(self.draft.text, self._folder)  # the files that it names may lie elsewhere
            self._folder.mkdir(parents=True, exist_ok=True)
            write_atomically(path, self.draft.text.encode())
            self.saved[path.name] = path
            self._base, self._name = self.draft.text, path.name
            return path

    def mistakes(self) -> list[str]:
        """Return the scenario's mistakes or, if there are none, its warnings; see flight.survey_check."""
        scenario = self.draft.scenario
        with self._building:
            found = checked(lambda: scenario, self._threads)
        return list(found.mistakes or found.warnings)

    def export(self, suffix: object) -> Values:
        """Make the scenario's files for another simulator; return their archive's address, and what was left out.

        The address cannot be guessed, since a trainee must not see what an instructor edits. Raises ValueError.
        """
        scenario = self.draft.scenario
        with self._building:
            made = exports.export(scenario, scenario.name, str(suffix)[:40])
            self._archive = (f"{secrets.token_hex(16)}/{scenario.name}_{suffix}.zip", exports.zipped(made.files))
        return {"file": f"/edit/export/{self._archive[0]}", "notes": made.notes}

    def archive(self, name: str) -> bytes:
        """Return the archive that was exported last. Raises ValueError if it has another name."""
        known, content = self._archive
        if not known or name != known:
            raise ValueError("this archive is no more: export it again")
        return content

    def solid(self, edition: int, number: int) -> bytes:
        """Return an obstacle of the plan; see `GroundPlan.solid`. b"" after the editing has ended."""
        draft = self._draft
        return b"" if draft is None else draft.plan.solid(edition, number)

    @property
    def draft(self) -> Draft:
        """The scenario being edited. Raises ValueError if there is none."""
        if self._draft is None:
            raise ValueError("no scenario is being edited: open one")
        return self._draft

    def state(self, by: str) -> Values:
        """Return what the page shows; see wire.editor.EditState. by: the name of the client that edits."""
        with self._lock:
            draft = self._draft
            if draft is None:
                return {"is_open": False, "by": ""}
            return {
                "is_open": True, "by": by, "name": self._name, "edition": draft.edition, "can_undo": draft.can_undo,
                "can_redo": draft.can_redo, "is_saved": draft.text == self._base,
                "grid": draft.plan.grid, "plan": draft.plan.edition,
                "vehicles": [entry.name for entry in draft.scenario.vehicles], "parts": list(_parts(draft)),
                "text": draft.text,
            }  # fmt: skip


def _parts(draft: Draft) -> Iterator[Values]:
    """Yield the scenario's parts; see wire.editor.EditedPart."""
    values, scenario = draft.values, draft.scenario
    for section, found in SECTIONS.items():
        for vehicle in range(len(scenario.vehicles) if found.of_vehicle else 1):
            above = found.below(vehicle)
            frame = _frame(scenario, vehicle) if found.of_vehicle and section != "starts" else [0.0, 0.0, 0.0, 0.0]
            for place, name in _places(draft, section, above, values):
                own = draft.shown(section, place)
                is_docked = section == "starts" and not own
                outline = draft.plan.outlines_m[int(place[1])] if section == "obstacles" else []
                if is_docked:
                    position_m, yaw_rad = start_pose(scenario, scenario.vehicles[vehicle])
                    own = {"position_m": list(position_m), "yaw_deg": math.degrees(yaw_rad)}
                yield {
                    "section": section, "place": list(place), "name": str(own.get(found.field("name"), name)),
                    "kind": str(own.get(found.field(found.key), "")), "vehicle": vehicle if found.of_vehicle else None,
                    "is_inherited": is_docked or is_inherited(values, place),
                    "frame": frame, "values": own, "outline_m": outline,
                }  # fmt: skip


def _places(draft: Draft, section: str, above: Place, values: Any) -> Iterator[tuple[Place, str]]:
    """Yield the places of a section's parts, and names for those that have none of their own."""
    holds = SECTIONS[section].holds
    if holds == "names":
        yield from (((*above, name), name) for name in draft.names(above))
        return
    for key in above:
        values = values.get(key) if isinstance(values, dict) else values[int(key)]
        if values is None:
            break
    if section == "starts":
        yield above, draft.scenario.vehicles[int(above[1])].name
    elif (holds == "one" and values is not None) or isinstance(values, dict):
        yield above, section
    else:
        yield from (((*above, k), f"{section} {k + 1}") for k in range(len(values or ())))


def _frame(scenario: Scenario, vehicle: int) -> list[float]:
    """Return the place and direction, x, y [m], yaw [deg], z [m], of the frame of a vehicle's parts."""
    (x, y, z), yaw_rad = start_pose(scenario, scenario.vehicles[vehicle])
    return [x, y, math.degrees(yaw_rad), z]


def _place(value: object) -> Place:
    """Return a place from a request. Raises ValueError."""
    if not isinstance(value, list) or not 1 <= len(value) <= PLACE_MAX:
        raise ValueError("place: must be the keys of a part")
    keys = [int(key) if isinstance(key, float) and key.is_integer() else key for key in value]
    if not all(isinstance(key, str) or (isinstance(key, int) and not isinstance(key, bool)) for key in keys):
        raise ValueError("place: must be the keys of a part")
    return tuple(keys)
