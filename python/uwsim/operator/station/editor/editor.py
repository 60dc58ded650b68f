"""The station's editor: who edits which scene, its parts as the page shows them, and where its files go."""

from __future__ import annotations

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
from uwsim.exercises.flyable import flyable
from uwsim.flight.flyable_lanes import checked
from uwsim.operator.station.editor.draft import Draft
from uwsim.operator.station.editor.files import MAX_BYTES, Place, SceneFiles, exercise_file
from uwsim.operator.station.editor.meshes import Meshes
from uwsim.operator.station.editor.parts import parts
from uwsim.scenario import Scenario
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
    saved, exercises: the paths of the scenarios in the folder and of the exercises beside them, those of earlier
    stations too, by their names on the start screen. Files that hold none are left out when they are listed. by: the
    client that edits, or "". Methods may be called on any thread.
    """

    def __init__(self, folder: Path, threads: int | None) -> None:
        files = [path for path in sorted(folder.glob("*.yaml")) if NAME.fullmatch(path.stem) and path.is_file()]
        self.saved = {path.name: path for path in files[:SAVED_MAX]}
        beside = [folder / exercise_file(path.name) for path in files[:SAVED_MAX]]
        self.exercises = {path.name: path for path in beside if path.is_file()}
        self._folder, self._threads = folder, threads
        self._lock, self._changing, self._building = threading.Lock(), threading.Lock(), threading.Lock()
        self._draft: Draft | None = None
        self._base = SceneFiles("", "")  # those that were opened or saved last
        self.by = self._opened = self._name = self._key = ""
        self.meshes = Meshes(folder)

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
        return self._take(client, NEW, lambda: Draft(SceneFiles(f"{NEW}.yaml", text), self._folder), is_of_same=True)

    def open_running(
        self, client: str, scenario: Scenario, is_of_file: Callable[[Scenario], bool], *, is_of_same: bool
    ) -> bool:
        """Open the scenario of the running simulator: its file's text or, if that gives another, its plain values.

        is_of_same: whether the scenario being edited is that of the same simulator; see `open`.
        """

        def make() -> Draft:
            document = scenario.source_file.document
            if document is not None:
                found = Draft(SceneFiles(Path(document.name).name, document.text), self._folder)
                if is_of_file(found.scenario):
                    return found
            return Draft(SceneFiles(f"{scenario.name}.yaml", yaml_text(plain(scenario))), self._folder)

        return self._take(client, scenario.name, make, is_of_same)

    def _of_file(self, path: Path) -> Draft:
        """Return a file's draft; a packaged one, which names packaged files only, may also name those in the folder."""
        folder = self._folder if assets_folder() in path.parents else path.resolve().parent
        return Draft(SceneFiles.of(path, read_yaml(path, path.name).text), folder)

    def _take(self, client: str, name: str, make: Callable[[], Draft], is_of_same: bool) -> bool:
        with self._alone():
            kept = self._draft
            is_of_same = is_of_same and name in (self._opened, self._name)
            self._key = secrets.token_hex(16)
            if kept is not None and is_of_same and kept.files != self._base:
                self.by = client
                return True
            draft = make()
            self._draft, self._base, self.by = draft, draft.files, client
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
            if client == self.by:
                self._draft, self.by, self._key = None, "", ""
                self.meshes.forget()

    def left(self, client: str) -> None:
        """End a client's editing, and keep what was not saved; a change that is being made is not waited for."""
        if client == self.by:
            self.by = ""

    def act(self, request: Values) -> Place:
        """Change the scenario; return the place of a part that was added or moved, or (). Raises ValueError."""
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
                draft.take(self._base)
                return ()
            section, values = str(request.get("section") or ""), request.get("values") or {}
            if not isinstance(values, dict) or (action == "set" and not values):
                raise ValueError("values: must be fields and their values")
            if action == "add":
                at_m, vehicle = request.get("at_m") or [0.0, 0.0], request.get("vehicle") or 0
                if not (isinstance(at_m, list) and len(at_m) == 2 and all(map(is_number, at_m))):
                    raise ValueError("at_m: must be two numbers")
                kind = str(request.get("kind") or "")
                return draft.add(section, kind, _whole("vehicle", vehicle), at_m, values)
            place = _place(request.get("place"))
            if action == "move":
                return draft.move(section, place, _whole("to", request.get("to")))
            if action == "remove":
                draft.remove(section, place)
            else:
                draft.set(section, place, values)
            return ()

    def save(self, name: object) -> Path:
        """Write the scenario under a name, and beside it the exercise; return its path. Raises ValueError or OSError.

        A file that is not as it was opened or last saved is not replaced.
        """
        with self._lock:
            if not isinstance(name, str) or not NAME.fullmatch(name):
                rule = "must be a letter followed by at most 39 letters, digits, '-' or '_'"
                raise ValueError(f"name = {str(name)[:40]!r}: {rule}")
            path = self._folder / f"{name}.yaml"
            beside, draft = path.with_name(exercise_file(path.name)), self.draft
            for file, known in ((path, self._base.scenario), (beside, self._base.exercise)):
                if file.exists() and not (known and file.read_bytes() == known.encode()):
                    raise ValueError(f"{file.name}: is another scene's: save under another name")
            draft.take(draft.files.renamed(name))
            draft.files.read(self._folder)  # the files that it names may lie elsewhere
            self._folder.mkdir(parents=True, exist_ok=True)
            write_atomically(path, draft.files.scenario.encode())
            self.saved[path.name] = path
            if draft.exercise is not None:
                write_atomically(beside, draft.files.exercise.encode())
                self.exercises[beside.name] = beside
            elif self.exercises.pop(beside.name, None):
                beside.unlink(missing_ok=True)
            self._base, self._name = draft.files, path.name
            return path

    def mistakes(self) -> list[str]:
        """Return the mistakes of the scenario or else of its exercise or, if there are none, warnings.

        See `checked` of flight.flyable_lanes, and exercises.flyable for what `uwsim exercise` refuses.
        """
        draft = self.draft
        with self._building:
            found = checked(lambda: draft.scenario, self._threads)
            wrong = list(found.mistakes)
            if not wrong and draft.exercise is not None:
                try:
                    flyable(draft.exercise, self._threads, draft.scenario)
                except ValueError as error:
                    wrong = [f"{draft.files.exercise_name}: {each}" for each in getattr(error, "mistakes", (error,))]
        return wrong or list(found.warnings)

    @property
    def address(self) -> str:
        """The address of the scene's files. It cannot be guessed: it is stated only to those who may edit."""
        return f"/edit/{self._key}"

    def require(self, key: str) -> None:
        """Raise ValueError unless this is the key in the present address."""
        if not self._key or not secrets.compare_digest(key, self._key):
            raise ValueError("this scene is not edited any more, or not by you")

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
                "can_redo": draft.can_redo, "is_saved": draft.files == self._base, "files": self.address,
                "grid": draft.plan.grid, "plan": draft.plan.edition,
                "vehicles": [entry.name for entry in draft.scenario.vehicles], "parts": list(parts(draft)),
                "text": draft.files.shown,
            }  # fmt: skip


def _whole(name: str, value: Any) -> int:
    """Return a whole number from a request. Raises ValueError."""
    if not is_number(value) or value % 1:
        raise ValueError(f"{name} = {str(value)[:40]}: must be a whole number")
    return int(value)


def _place(value: object) -> Place:
    """Return a place from a request. Raises ValueError."""
    if not isinstance(value, list) or not 1 <= len(value) <= PLACE_MAX:
        raise ValueError("place: must be the keys of a part")
    keys = [int(key) if isinstance(key, float) and key.is_integer() else key for key in value]
    if not all(isinstance(key, str) or (isinstance(key, int) and not isinstance(key, bool)) for key in keys):
        raise ValueError("place: must be the keys of a part")
    return tuple(keys)
