"""The scene editor's laws: a file, edited, is the file that a careful hand would have left."""

from __future__ import annotations

import base64
import difflib
import io
import json
import struct
import threading
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import trimesh
from PIL import Image

from station_pages import require_described
from uwsim.base.quaternions import turned
from uwsim.evidence.scenario_check import check_file
from uwsim.exercises.flight import fly_exercise
from uwsim.flight.survey import run_survey
from uwsim.operator.station import Site, Station
from uwsim.operator.station.editor import Editor
from uwsim.operator.station.editor.draft import Draft
from uwsim.operator.station.editor.files import MAX_BYTES, SceneFiles
from uwsim.operator.station.editor.forms import OF_EXERCISE, SECTIONS, forms
from uwsim.operator.station.editor.meshes import MESH_BYTES_MAX
from uwsim.operator.station.services import editing
from uwsim.operator.station.sessions.saves import continue_maps
from uwsim.operator.station.wire.calls import CALLS
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.read.assets import assets_folder, packaged_names
from uwsim.simulator.moving_shapes import moving_shapes, shape_poses
from uwsim.simulator.simulator import Simulator

ROV = ("vehicles", 0, "model")
NOT_REMOVED = ("terrain", "survey", "water", "optics", "starts", *OF_EXERCISE, "exercise", "exercise_start")
OF_A_FILE = ("currents", "grid")  # of which none is packaged
EACH = sorted({(name, kind) for name in forms() if name not in NOT_REMOVED for kind in forms()[name]} - {OF_A_FILE})
BOX, DVL, LAMP = ("obstacles", 0), (*ROV, "sensors", "dvl"), (*ROV, "lamps", "front")


def draft(name: str = "pool") -> Draft:
    path = assets_folder() / "scenarios" / f"{name}.yaml"
    return Draft(SceneFiles.of(path, path.read_text()), path.parent)


@pytest.fixture(scope="module")
def pool() -> Draft:
    return draft()


def lines(before: str, after: str) -> tuple[list[str], list[str]]:
    """Return the lines that were removed and added."""
    found = list(difflib.ndiff(before.splitlines(), after.splitlines()))
    return [each[2:] for each in found if each[0] == "-"], [each[2:] for each in found if each[0] == "+"]


@pytest.mark.parametrize(("section", "kind"), EACH)
def test_each_kind_is_added_read_again_and_removed_without_a_trace(
    pool, section: str, kind: str, tmp_path: Path
) -> None:
    found = draft()
    place = found.add(section, kind, 0, [0.5, -1.0])
    again = Draft(SceneFiles("again.yaml", found.files.scenario), tmp_path)
    assert again.scenario == found.scenario and again.part(section, place) == found.part(section, place)
    fields = {"kind", *SECTIONS[section].without, *(each["name"].partition(".")[0] for each in forms()[section][kind])}
    assert fields >= found.part(section, place).keys()
    added = found.files.scenario
    found.remove(section, place)
    assert found.scenario == pool.scenario
    found.undo()
    assert found.files.scenario == added
    found.undo()
    assert found.files.scenario == pool.files.scenario
    found.undo(-2)
    assert found.scenario == pool.scenario


def test_a_part_of_a_file_is_added_once_the_file_is_named(tmp_path: Path) -> None:
    found = Draft(draft().files, tmp_path)
    for values, message in (
        ({}, "file: must be named first: a packaged file, or one"),
        ({"file": "tide.csv"}, "no such file"),
    ):
        with pytest.raises(ValueError, match=message):
            found.add(*OF_A_FILE, 0, [0, 0], values)
    cells = [f"{x},{y},{z},0.1,0,0" for x in (-9, 9) for y in (-9, 9) for z in (-5, 0)]
    (tmp_path / "tide.csv").write_text("\n".join(["x_m,y_m,z_m,u_m_s,v_m_s,w_m_s", *cells]))
    place = found.add(*OF_A_FILE, 0, [0, 0], values)
    assert found.part("currents", place) == {"kind": "grid", "file": "tide.csv"}


def test_a_solid_of_an_older_edition_is_empty_and_one_that_never_was_is_refused() -> None:
    """A page that asks while another change is on its way gets the newer solid next: it is no error."""
    found = draft()
    older = found.plan.edition
    assert found.plan.solid(older, 0)[:4] == b"glTF"
    found.set("obstacles", ("obstacles", 0), {"position_m": [1, 2, -3]})
    assert found.plan.edition == older + 1 and found.plan.solid(older, 0) == b""
    for edition, number in ((older + 2, 0), (older + 1, len(found.scenario.obstacles))):
        with pytest.raises(ValueError, match="does not exist"):
            found.plan.solid(edition, number)


def test_each_prop_that_is_added_stands_on_the_bed_and_is_seen_as_the_simulator_builds_it() -> None:
    found, (x, y) = draft("lake"), (-30.0, 20.0)  # on a slope
    for name in packaged_names("props"):
        place = found.add("props", "", 0, [x, y], {"model": name, "colour": [0.02, 0.2, 0.5]})
        prop, bed = found.scenario.placed_props[-1], build_terrain(found.scenario.terrain)
        first = len(found.scenario.obstacles) - len(prop.model.obstacles)
        shown = trimesh.load(io.BytesIO(found.plan.solid(found.plan.edition, first)), file_type="glb", force="mesh")
        points = np.vstack([shown.vertices, prop.position_m])
        clear_m = points[:, 2] - bed.height_at(points[:, :2])
        assert clear_m.min() == pytest.approx(0, abs=2e-3), name
        built = Simulator(found.scenario)
        moving = zip(moving_shapes(found.scenario), shape_poses(built), strict=True)
        solids = [obstacle_solid(each, bed).vertices for each in found.scenario.obstacles[first:]]
        solids += [
            pose[:3] + turned(pose[3:], each.mesh()[0]) for each, pose in moving if each.name.startswith(prop.name)
        ]
        points = np.vstack(solids)
        np.testing.assert_allclose(shown.bounds, [points.min(axis=0), points.max(axis=0)], atol=1e-5)
        if name == "drum":  # which has no colour of its own
            assert np.unique(shown.visual.vertex_colors, axis=0).tolist() == [[5, 51, 128, 255]]
        found.remove("props", place)
    with pytest.raises(ScenarioError, match="lies outside the terrain"):
        found.add("props", "", 0, [1e4, 0])


def test_a_loose_bodys_shape_and_its_own_fields_are_one_part() -> None:
    found = draft("harbour")
    before, place = found.files.scenario, ("objects", 0)
    assert found.shown("objects", place)["shape.name"] == "workboat"
    found.set("objects", place, {"shape.position_m": [-20, 10, 0], "shape.name": "launch"})
    boat = found.scenario.objects[0]
    assert (boat.name, boat.shape.position_m) == ("launch", (-20.0, 10.0, 0.0))
    assert [len(each) for each in lines(before, found.files.scenario)] == [1, 1]
    with pytest.raises(ScenarioError, match=r"density_kg_m3 = 900.*: must be left out for a body on a path"):
        found.set("objects", place, {"density_kg_m3": 900})
    found.set("objects", place, {"shape.material": None, "path": None, "density_kg_m3": 900})
    assert "shape.material" not in found.shown("objects", place)
    assert found.add("objects", "sphere", 0, [3, 4]) == ("objects", 1) and found.scenario.objects[1].name == "sphere"
    found.undo(3)
    assert found.files.scenario == before


def test_strokes_change_the_bed_in_one_step_each_and_outlive_its_source() -> None:
    found = draft()
    before, edition = found.plan.heights(), found.plan.grid["edition"]
    values = {"line_m": [[0, 0], [2, 0]], "width_m": 3, "height_m": 1}
    place = found.add("strokes", "", 0, [0, 0], values)
    assert found.part("strokes", place) == values and found.plan.grid["edition"] == edition + 1
    rise = np.frombuffer(found.plan.heights(), "<f4") - np.frombuffer(before, "<f4")
    assert rise.max() == pytest.approx(1, abs=1e-5) and rise.min() == 0
    found.add("terrain", "raster", 0, [0, 0])
    assert found.part("strokes", place) == values
    found.undo(2)
    assert found.plan.heights() == before
    with pytest.raises(ValueError, match="depth: unknown key"):
        found.add("strokes", "", 0, [0, 0], {"depth": 1})


def test_goals_are_about_the_scene_and_follow_each_other_through_renaming_and_removal() -> None:
    found = draft("panel")
    assert found.exercise is None
    for kind in forms()["goals"]:
        if kind == "find":
            with pytest.raises(ValueError, match="find: there is no obstacle that it can be about"):
                found.add("goals", kind, 0, [1, 2])
        else:
            found.add("goals", kind, 0, [1, 2])
    joint = next(goal for goal in found.goals if goal.kind == "move_joint")
    assert (joint.object, joint.joint, joint.to_deg) == ("valve", "handle", 90)
    names = [goal.name for goal in found.goals]
    assert [goal.after for goal in found.goals] == [None, *names[:-1]]
    found.set("goals", ("exercise", "goals", 0), {"name": "begin"})
    found.remove("goals", ("exercise", "goals", 1))
    assert [goal.after for goal in found.goals] == [None, "begin", *names[2:-1]]
    look = ("exercise", "goals", [goal.kind for goal in found.goals].index("look_at"))
    found.set("goals", look, {"object": "valve"})
    assert found.part("goals", look).keys() == {"kind", "name", "title", "after", "object"}
    found.set("goals", look, {"position_m": [1, 2, -3]})
    assert "object" not in found.part("goals", look)
    order, after = [goal.name for goal in found.goals], [goal.after for goal in found.goals]
    assert found.move("goals", ("exercise", "goals", 1), 2) == ("exercise", "goals", 2)
    moved = [order[0], order[2], order[1], *order[3:]]
    assert [goal.name for goal in found.goals] == moved  # and each place comes after the one that it came after
    assert [goal.after for goal in found.goals] == [name and moved[order.index(name)] for name in after]
    found.undo()
    assert [goal.name for goal in found.goals] == order
    with pytest.raises(ValueError, match="to = 99: must be the number of a goal"):
        found.move("goals", look, 99)
    with pytest.raises(ValueError, match="layout: there is no other prop"):
        found.add("layout", "", 0, [0, 0])
    prop = found.part("props", found.add("props", "", 0, [3, 3], {"model": "pipes"}))["name"]
    assert found.exercise.layout == [] and found.part("layout", found.add("layout", "", 0, [0, 0]))["prop"] == prop
    start = found.add("exercise_start", "", 0, [1, 2])
    found.set("exercise_start", start, {"yaw_deg": 90})
    assert (found.exercise.start.position_m, found.exercise.start.yaw_deg) == ((1, 2, -1), 90)
    with pytest.raises(ValueError, match=r"exercise\.start: exists already"):
        found.add("exercise_start", "", 0, [1, 2])
    for section in ("limits", "events", "aids"):
        for kind in forms()[section]:
            place = found.add(section, kind, 0, [0, 0])
            assert found.part(section, place)
    scene = found.files.scenario
    found.remove("exercise", ("exercise",))
    assert found.exercise is None and found.files.scenario == scene
    found.undo()
    assert len(found.goals) == len(names) - 1


def test_comments_and_untouched_lines_stay() -> None:
    for name in ("pair", "reef"):
        found, before = draft(name), draft(name).files.scenario
        found.set("starts", ("vehicles", 0, "start"), {"position_m": [1.25, -2, -3], "yaw_deg": 30})
        assert found.scenario.vehicles[0].start.position_m == (1.25, -2.0, -3.0)
        assert max(map(len, lines(before, found.files.scenario))) <= 2
    found, before = draft(), draft().files.scenario
    found.set("obstacles", BOX, {"name": "buoy"})
    assert list(found.part("obstacles", BOX)) == list(draft().part("obstacles", BOX))  # in its place
    assert lines(before, found.files.scenario)[0] == [each for each in before.splitlines() if "name: box" in each]
    found, before = draft("lake"), draft("lake").files.scenario
    found.set("obstacles", ("obstacles", 1), {"position_m": [-57.5, -54], "lower_bar_m": 1.5})
    found.set("survey", ("survey",), {"tilt_deg": 25})
    found.remove("obstacles", ("obstacles", 2))
    removed, added = lines(before, found.files.scenario)
    assert added == [
        "    position_m: [-57.5, -54]",
        "    lower_bar_m: 1.5",
        "  tilt_deg: 25                # nose down",
    ]
    assert removed[0] == "    position_m: [-58, -54]" and removed[-1] == "  tilt_deg: 30                # nose down"
    assert "  - kind: gate                # inside the survey, 3 m below the flying height" in found.files.scenario


def test_a_part_of_a_packaged_vehicle_is_written_whole_into_the_scenario() -> None:
    found = draft()
    before = found.scenario.vehicles[0].model.sensors
    found.set("sensors", DVL, {"position_m": [0.1, 0, -0.3]})
    after = found.scenario.vehicles[0].model.sensors
    assert after["dvl"].position_m == (0.1, 0.0, -0.3) and after["dvl"].channels == before["dvl"].channels
    assert {**after, "dvl": None} == {**before, "dvl": None}
    found.set("lamps", LAMP, {"spots": [[0.5, 0.3, 0.2, 0, 12, 0], [0.5, -0.3, 0.2, 0, 0, 0]]})
    assert [spot.yaw_pitch_roll_deg[1] for spot in found.scenario.vehicles[0].model.lamps["front"].spots] == [12, 0]
    found.remove("sensors", DVL)
    assert "dvl" not in found.scenario.vehicles[0].model.sensors and "dvl: null" in found.files.scenario


@pytest.mark.parametrize(
    ("section", "place", "values", "message"),
    [
        ("obstacles", BOX, {"size_m": [-1, 1, 1]}, r"^pool.yaml:21: .*size_m\[0\] = -1 m: must be in \[0.01, "),
        ("obstacles", BOX, {"size_m": ["1", 1, 1]}, r"size_m\[0\] = '1': must be a number"),
        ("obstacles", BOX, {"position_m": [50, 0, 0], "on_bed": True}, r"^pool.yaml:18: .* outside the terrain"),
        ("obstacles", BOX, {"width": 1}, "width: unknown key"),
        ("obstacles", ("obstacles", 9), {"size_m": [1, 1, 1]}, r"obstacles\[9\]: is no part"),
        ("obstacles", ("vehicles", 0), {"name": "x"}, "is no part of obstacles"),
        ("obstacles", BOX, {"name": "rov"}, "rov.* already in use"),
        ("obstacles", BOX, {"material": "{kind: "}, "not valid YAML"),
        ("obstacles", BOX, {"material": "/etc/passwd"}, "must be a packaged file"),
        ("lamps", LAMP, {"spots": [[0, 0]]}, "spots: each row must have 6 values"),
        ("sensors", DVL, {"range_max_m": 0}, r"range_max_m = 0 m: must be in \[0.1, 1000\]"),
        ("sensors", ("vehicles", 7, "model", "sensors", "dvl"), {"on": True}, "is no part of sensors"),
        ("hats", BOX, {"x": 1}, "must be one of obstacles"),
    ],
)
def test_a_wrong_value_is_refused_and_nothing_changes(pool, section, place, values, message) -> None:
    before = pool.files.scenario
    with pytest.raises(ValueError, match=message):
        pool.set(section, place, values)
    assert pool.files.scenario == before and not pool.can_undo


def test_an_alias_that_would_change_two_places_and_a_large_file_are_refused(pool) -> None:
    sizes = {"a": "&s [1, 1, 1]", "b": "*s"}.items()
    twins = [f"  - {{kind: box, name: {name}, size_m: {size}, position_m: [0, 0, -2]}}\n" for name, size in sizes]
    twice = pool.files.scenario.replace("obstacles:\n", f"obstacles:\n{''.join(twins)}", 1)
    found = Draft(SceneFiles("pool.yaml", twice), Path())
    with pytest.raises(ValueError, match="edit it by hand"):
        found.set("obstacles", ("obstacles", 1), {"size_m": [1, 2, 1]})
    found.set("obstacles", ("obstacles", 1), {"position_m": [4, 0, -2]})
    with pytest.raises(ValueError, match=f"at most {MAX_BYTES}"):  # before it is read
        SceneFiles("lake.yaml", "#" * (MAX_BYTES + 1))


BOX_AT = "position_m: [3, 0, -4.5]\n    size_m: [1, 1, 1]"
OF_SURVEYS = {  # edits of the packaged pool, and the number of their mistakes
    "none": ([], 0),
    "no sonar": ([("model: rov\n", "model: {builds_on: rov, sonar: null}\n"), ("    sonar: {model: 2,", "    #")], 1),
    "a box in the lanes": ([(BOX_AT, "position_m: [0, 0, -1]\n    size_m: [9, 9, 3]")], 1),
    "beyond the altimeter's range, with turns beside the terrain": ([("altitude_m: 2\n", "altitude_m: 150\n")], 2),
}


@pytest.mark.parametrize("what", OF_SURVEYS)
def test_the_editor_the_check_and_the_survey_have_one_verdict(what: str, tmp_path: Path) -> None:
    path, text = tmp_path / "mine.yaml", draft().files.scenario
    edits, count = OF_SURVEYS[what]
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path.write_text(text)
    editor, refused = Editor(tmp_path, 1), []
    editor.open("anna", path.name, path, is_of_same=False)
    try:
        run_survey(path, tmp_path / "out", time_limit_s=0.1, report="none")
    except ScenarioError as error:
        refused = [each.replace(f"{path}", path.name) for each in error.mistakes]
    assert editor.mistakes() == refused == [each.replace(f"{path}", path.name) for each in check_file(path).mistakes]
    assert len(refused) == count


class Member:
    """A client of a station, without a connection."""

    def __init__(self, station: Station, name: str) -> None:
        self.name, self.calls = name, {service.name: service.call for service in station.services}
        self("join", name=name)

    def __call__(self, service: str, **request):
        answer = self.calls[f"station/{service}"](self.name, request)
        if service in ("edit", "edit_forms"):
            require_described(CALLS[service], answer)
        return answer


def node() -> Mock:
    """A wire without clients."""
    return Mock(**{"is_wanted.return_value": False, "is_awaited.return_value": False, "silence_s.return_value": 0.0})


@pytest.fixture
def station(tmp_path: Path):
    found = Station(offered="pool", folder=tmp_path)
    found.connect(node())
    yield found
    found.sessions.close()


@pytest.fixture
def anna(station: Station) -> Member:
    """A member who edits the pool."""
    member = Member(station, "anna")
    assert member("edit", action="open", scenario="pool")["parts"]
    return member


def test_what_is_saved_opens_everywhere_and_replaces_no_foreign_file(anna, station: Station, tmp_path: Path) -> None:
    ben = Member(station, "ben")
    assert {each["name"] for each in anna("edit_forms")["sections"]} == set(SECTIONS)
    assert "anna edits" in ben("edit", action="add", section="obstacles", kind="box", at_m=[0, 0])["message"]
    assert "anna edits" in ben("edit", action="open", scenario="pool")["message"]
    added = anna("edit", action="add", section="obstacles", kind="box", at_m=[2, 2])
    assert added["added"] == ["obstacles", 1] and not added["is_saved"]
    (mistake,) = anna("edit", action="check")["mistakes"]  # the box reaches up into the lanes
    assert "of the survey's lanes cannot be flown" in mistake
    (tmp_path / "mine.yaml").write_text("# by hand\n")
    assert "is another scene's" in anna("edit", action="save", name="mine")["message"]
    assert "must be a letter" in anna("edit", action="save", name="../x")["message"]
    assert anna("edit", action="save", name="my_pool")["is_saved"]
    scenario = load(tmp_path / "my_pool.yaml")
    assert scenario.name == "my_pool" and scenario.obstacles[1].name == "box_2"
    assert (tmp_path / "mine.yaml").read_text() == "# by hand\n"
    assert "my_pool.yaml" in [each["name"] for each in anna("catalog")["scenarios"]]
    assert anna("check", scenario="my_pool.yaml")["success"]
    station.left("anna")
    assert ben("edit", action="open", scenario="my_pool.yaml")["by"] == "ben"
    again = Station(offered="pool", folder=tmp_path)  # another day
    again.connect(node())
    names = [each["name"] for each in Member(again, "eve")("catalog")["scenarios"]]
    assert names[0] == "my_pool.yaml" and "mine.yaml" not in names
    again.sessions.close()


def test_a_scene_is_built_from_nothing_and_has_the_verdict_of_a_file(anna, tmp_path: Path) -> None:
    assert anna("edit", action="new")["vehicles"] == ["rov"]
    for section, kind in (
        ("terrain", "image"), ("terrain", "noise"), ("surface", "jonswap"), ("tide", ""), ("optics", ""),
        ("life", "school"), ("cover", "kelp"), ("obstacles", "box"), ("props", ""), ("vehicles", ""),
        ("currents", "layers"), ("survey", ""),
    ):  # fmt: skip
        answer = anna("edit", action="add", section=section, kind=kind, at_m=[12, -8])
        assert answer["success"], answer["message"]
    assert "exists already" in anna("edit", action="add", section="terrain", kind="noise")["message"]
    for place, values in ((["optics"], {"sun_elevation_deg": 20}), (["props", 0], {"position_m": [12, -8, 0]})):
        assert anna("edit", action="set", section=place[0], place=place, values=values)["success"]
    (verdict,) = anna("edit", action="check")["mistakes"]  # the drum is in the way of the survey's lanes
    assert anna("edit", action="save", name="mine")["is_saved"]
    report = check_file(tmp_path / "mine.yaml")
    assert verdict.removeprefix("scene.yaml") in [each.removeprefix(report.file) for each in report.warnings]
    scenario = load(tmp_path / "mine.yaml")
    assert [entry.model.name for entry in scenario.vehicles] == ["bluerov2_heavy_outfit"] * 2
    assert (scenario.terrain.source, scenario.optics.sun_elevation_deg) == ("noise", 20.0)


def test_an_exercise_is_saved_beside_its_scene_replaces_none_and_is_flown_another_day(anna, tmp_path: Path) -> None:
    goal = {"section": "goals", "kind": "reach", "at_m": [2, 3]}
    assert anna("edit", action="add", **goal)["added"] == ["exercise", "goals", 0]
    assert anna("edit", action="check")["mistakes"] == []
    anna("edit", action="add", section="limits", kind="tangled")
    (mistake,) = anna("edit", action="check")["mistakes"]
    assert anna("edit", action="save", name="bay")["is_saved"]
    with pytest.raises(ValueError) as refused:  # the very line of `uwsim exercise`
        fly_exercise(tmp_path / "bay.exercise.yaml", lambda vehicle: iter(()))
    assert mistake.removeprefix("pool.exercise.yaml: ").replace("'pool'", "'bay'") == str(refused.value)
    assert anna("edit", action="remove", section="limits", place=["exercise", "limits", 0])["success"]
    assert anna("edit", action="save", name="bay")["is_saved"]
    kept = (tmp_path / "bay.exercise.yaml").read_bytes()
    anna("edit", action="new")
    assert "bay.yaml: is another scene's" in anna("edit", action="save", name="bay")["message"]
    (tmp_path / "bay.yaml").rename(tmp_path / "kept")
    anna("edit", action="add", **goal)
    assert "bay.exercise.yaml: is another scene's" in anna("edit", action="save", name="bay")["message"]
    assert (tmp_path / "bay.exercise.yaml").read_bytes() == kept
    (tmp_path / "kept").rename(tmp_path / "bay.yaml")

    again = Station(offered="pool", folder=tmp_path)  # another day
    again.connect(node())
    eve = Member(again, "eve")
    first = eve("catalog")["exercises"][0]
    assert (first["name"], first["scenario"]) == ("bay.exercise.yaml", "bay.yaml")
    assert "must be one of bay.exercise.yaml, hover" in eve("start", exercise_name="../bay")["message"]
    assert eve("start", exercise_name=first["name"])["success"] and eve("control", action="begin")["success"]
    again.sessions.quit()
    assert json.loads((tmp_path / "sheet-1/score.json").read_text())["title"] == "New exercise"
    opened = eve("edit", action="open", scenario="bay.yaml")
    assert [each["place"] for each in opened["parts"]][-2:] == [["exercise"], ["exercise", "goals", 0]]
    assert eve("edit", action="remove", section="exercise", place=["exercise"])["success"]
    assert eve("edit", action="save", name="bay")["is_saved"] and not (tmp_path / "bay.exercise.yaml").exists()
    again.sessions.close()


def test_what_was_left_unsaved_is_there_for_whoever_opens_it_next_and_can_be_dropped(station: Station) -> None:
    before = Member(station, "anna")("edit", action="open", scenario="pool")["text"]
    Member(station, "anna")("edit", action="add", section="obstacles", kind="box", at_m=[2, 2])
    station.left("anna")
    ben = Member(station, "ben")
    kept = ben("edit", action="open", scenario="pool")
    assert kept["message"] == "continues with what was not saved" and kept["can_undo"] and kept["text"] != before
    reverted = ben("edit", action="revert")
    assert reverted["text"] == before and reverted["is_saved"]
    assert ben("edit", action="undo")["text"] == kept["text"]
    assert ben("edit", action="open", scenario="reef")["message"] == ""
    assert ben("edit", action="open", scenario="pool")["text"] == before  # another was opened meanwhile
    station.left("ben")
    assert not Member(station, "anna")("edit", action="report")["can_undo"]


def test_a_file_that_was_removed_or_broken_leaves_the_start_screen_to_the_others(anna, station: Station) -> None:
    assert anna("edit", action="save", name="one")["is_saved"] and anna("edit", action="save", name="two")["is_saved"]
    (station.sessions.folder / "one.yaml").unlink()
    (station.sessions.folder / "two.yaml").write_text("name: [")
    names = [each["name"] for each in anna("catalog")["scenarios"]]
    assert "pool" in names and not {"one.yaml", "two.yaml"} & set(names)
    assert "must be one of" in anna("check", scenario=["pool"])["message"]


def test_hostile_changes_are_refused_in_a_line(anna) -> None:
    deep: list[object] = []
    for _ in range(300):
        deep = [deep]
    for values, rule in (
        ({"position_m": deep}, "must be plain JSON"),
        ({"position_m": [2**70, 0]}, "must be plain JSON"),
        ({"name": "\ud800"}, "must be plain JSON"),
        ({"material": "[" * 1000}, "is nested more than 20 deep"),
        ({"material": '["' + "]" * 1000 + '", ' + "[" * 1000}, "is nested more than 20 deep"),
    ):
        answer = anna("edit", action="set", section="obstacles", place=["obstacles", 0], values=values)
        assert rule in answer["message"]


def test_a_change_beside_another_is_refused_and_occupies_no_thread(anna, station: Station) -> None:
    with station.sessions.editor._changing:
        for request in ({"action": "undo"}, {"action": "open", "scenario": "pool"}):
            assert "another change is being made" in anna("edit", **request)["message"]
    assert "nothing to undo" in anna("edit", action="undo")["message"]


def test_a_client_leaves_without_waiting_for_a_change(anna, station: Station) -> None:
    editor = station.sessions.editor
    leaving = threading.Thread(target=station.left, args=("anna",), daemon=True)
    with editor._lock:  # as while a change is made
        leaving.start()
        leaving.join(10)
        assert not leaving.is_alive(), "the network thread calls this, and all stop goes through it"
    assert not editor.by


def test_what_is_edited_is_served_at_its_own_address_alone(anna, station: Station) -> None:
    seen = anna("edit", action="report")["files"]
    site = Site(station)
    for name in ("terrain.f32", "1/0.glb", "mesh/meshes/wreck.glb.png"):
        assert site._made(f"{seen}/{name}").body
        for other in (f"/edit/{name}", f"/edit/{'0' * 32}/{name}", f"/edit/{seen[6:-1]}/{name}"):
            with pytest.raises((ValueError, LookupError)):
                site._made(other)


def test_a_rebuilt_world_keeps_vehicle_and_time(station: Station, monkeypatch: pytest.MonkeyPatch) -> None:
    anna, ben = Member(station, "anna"), Member(station, "ben")
    assert anna("start", scenario="pool", seed=7)["success"]
    anna("take_control")
    live = station.present().live
    live.command("undock", vehicle="rov").result()
    live.command("place", vehicle="rov", position_world_m=[-3.0, 3.0, -2.0]).result()
    live.command("set_effort", vehicle="rov", surge=0.5).result()
    anna("edit", action="open")
    anna("edit", action="add", section="obstacles", kind="sphere", at_m=[3, 0])
    assert "pause it first" in anna("edit", action="apply")["message"]
    anna("control", action="pause")
    assert "anna has the controls" in ben("edit", action="apply")["message"]

    def there(sim):
        return sim.time_s, np.array(sim.rov.pose.position_world_m), np.array(sim.rov.velocity.linear_body_m_s), sim.seed

    def stopped_meanwhile(rebuilt, folder):
        ben("all_stop", vehicle="rov", on=True).result()
        continue_maps(rebuilt, folder)

    before = live.read(there).result()
    monkeypatch.setattr(editing, "continue_maps", stopped_meanwhile)
    assert anna("edit", action="apply")["success"]
    assert station.present().live.simulator.rov.all_stopped
    again = station.present().live
    assert again is not live and again.paused
    for one, other in zip(before, again.read(there).result(), strict=True):
        np.testing.assert_array_equal(one, other)
    assert [each.name for each in again.simulator.scenario.obstacles][-1] == "sphere"
    anna("edit", action="set", section="obstacles", place=["obstacles", 1], values={"position_m": [-3, 3, 0]})
    anna("edit", action="set", section="obstacles", place=["obstacles", 1], values={"radius_m": 4})
    assert "would be inside 'sphere'" in anna("edit", action="apply")["message"]
    assert anna("edit", action="undo")["success"]
    assert anna("edit", action="add", section="sensors", kind="dvl", vehicle=0)["success"]
    assert "state.sensors" in anna("edit", action="apply")["message"]
    assert station.present().live is again
    anna("edit", action="open", scenario="pool")
    assert "is not the running simulator's" in anna("edit", action="apply")["message"]


FOREIGN = rb'{"buffers": [{"\u0075ri": "../secret.bin"}]}'


def sent(client: Member, name: str, content: bytes, parts: int = 1) -> dict[str, object]:
    step = -(-len(content) // parts)
    for at in range(0, len(content), step):
        data = base64.b64encode(content[at : at + step]).decode()
        answer = client("edit", action="upload", name=name, size=len(content), at=at, data=data)
    return answer


def test_a_mesh_is_uploaded_in_parts_replaces_nothing_and_has_a_still(anna, station: Station, tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 2, 3))
    content = box.export(file_type="stl")
    files = ("my box.stl", "../my box.stl", "tyre.STL", "tyre.obj.stl")
    names = [sent(anna, each, content, 3)["mesh"] for each in files]
    assert names == ["meshes/my_box.stl", "meshes/my_box_2.stl", "meshes/tyre.stl", "meshes/tyre_obj.stl"]
    obj = b"mtllib /secret.mtl\nusemtl red\n" + box.export(file_type="obj").encode()
    named = str(sent(anna, "tyre.obj", obj)["mesh"])
    assert named == "meshes/tyre_2.obj" and b"mtllib" not in (tmp_path / named).read_bytes()  # of another file
    assert "without its colours, which are in /secret.mtl" in str(sent(anna, "tyre.obj", obj)["lost"])
    assert sent(anna, "plain.obj", box.export(file_type="obj").encode())["lost"] == ""
    listed = anna("edit", action="meshes")["meshes"]
    assert {named, *names} <= set(listed) and "meshes/wreck.glb" in listed
    still = np.asarray(Image.open(io.BytesIO(station.sessions.editor.meshes.still(named))))
    assert len(np.unique(still.reshape(-1, 3), axis=0)) > 3 and np.ptp(still) > 60  # sides in their own light
    mesh = {"section": "obstacles", "kind": "mesh", "values": {"file": named, "scale": 1}}
    assert anna("edit", action="add", at_m=[1, 2], **mesh)["success"]
    assert anna("edit", action="save", name="with_mesh")["is_saved"]
    assert load(tmp_path / "with_mesh.yaml").obstacles[-1].file == tmp_path / named


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.exe", b"MZ", "must end in .glb"),
        ("a.stl", b"solid a\nendsolid a\n", "mesh 'a.stl': "),
        ("a.stl", b"x" * (MESH_BYTES_MAX + 1), "size = 20000001 bytes: must be 1 to 20000000"),
        ("a.glb", b"glTF" + bytes(8) + struct.pack("<I4s", len(FOREIGN), b"JSON") + FOREIGN, "takes data from other"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "mesh 'a.obj': line 4: a face names vertex 0"),
    ],
)
def test_what_is_no_sound_mesh_is_refused_at_the_door(
    anna, tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    answer = sent(anna, name, content)
    assert not answer["success"] and message in answer["message"] and str(tmp_path) not in answer["message"]
    assert list(tmp_path.rglob("*.*")) == []
    again = anna("edit", action="upload", name="a.stl", size=9, at=3, data="AAAA")
    assert "is not the next part" in again["message"]
