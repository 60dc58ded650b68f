"""Files of the field: what is read, what is refused, and that a flight by one is as long as the file."""

import csv
import json
import re
import zipfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.flight.coverage import lanes_flown
from uwsim.flight.field_flight import FieldNote
from uwsim.flight.fly import fly
from uwsim.flight.flyable_lanes import survey_plan
from uwsim.flight.mission_file import MissionError
from uwsim.flight.plan_export import plan_of
from uwsim.mapping.files.georeference import HOME, Home
from uwsim.missions import OwnVehicle, StoppedError, goto, run
from uwsim.missions.fence import Fence, Zone
from uwsim.missions.field import FieldFileError, is_mission_file, read_mission_file
from uwsim.missions.items import planned_legs_m
from uwsim.scenario import load

BAY = Home(54.4, 10.2)
ROUTE = [(0.0, 0.0), (0.0, 5.0), (4.0, 5.0)]  # metres east and north of the first point: 9 m


def degrees(at: tuple[float, float]) -> list[float]:
    return [float(value) for value in BAY.degrees(np.array(at))]


def simple(command: int, *values: float | None, at: tuple[float, float] = (0.0, 0.0), z: float = 0.0, own: int = 0):
    place = degrees(at) if command in (16, 22) else [0, 0]
    params = [*values, *[None] * (4 - len(values)), *place, z]
    return {"type": "SimpleItem", "command": command, "frame": 3, "params": params, "doJumpId": own}


def survey(items: list[Any], points: list[Any]) -> dict[str, Any]:
    calc = {"DistanceToSurface": -2, "DistanceMode": 1}
    inner = {"Items": items, "VisualTransectPoints": points, "CameraCalc": calc}
    return {"type": "ComplexItem", "complexItemType": "survey", "TransectStyleComplexItem": inner}


def plan(*items: Any) -> str:
    return json.dumps({"fileType": "Plan", "mission": {"plannedHomePosition": [54.4, 10.2, 0], "items": list(items)}})


def fenced(text: str, *polygons: list[Any], circles: list[Any] | None = None) -> str:
    """Return a plan with a fence: polygons to stay in, and circles (centre, radius, whether to stay in)."""
    fence = {
        "polygons": [{"inclusion": True, "polygon": [degrees(at) for at in each]} for each in polygons],
        "circles": [
            {"inclusion": is_in, "circle": {"center": degrees(at), "radius": radius}}
            for at, radius, is_in in circles or []
        ],
    }
    return json.dumps({**json.loads(text), "geoFence": fence})


BOX = [(-2.0, -2.0), (6.0, -2.0), (6.0, 7.0), (-2.0, 7.0)]
TRANSECTS = [simple(16, at=at, z=-2.0) for at in ROUTE]
TRIGGER = simple(206, 25.0)
WPL = "QGC WPL 110\r\n0\t1\t0\t16\t0\t0\t0\t0\t54.4\t10.2\t0\t1\r\n" + "".join(
    f"{k}\t0\t3\t16\t0\t0\t0\t0\t{degrees(at)[0]:.9f}\t{degrees(at)[1]:.9f}\t-2\t1\r\n" for k, at in enumerate(ROUTE, 1)
)
FILES = {
    "simple.plan": plan(simple(22, at=(0, 0), z=10.0), *TRANSECTS),
    "survey.plan": plan(survey([TRANSECTS[0], TRIGGER, *TRANSECTS[1:]], [])),
    "points.plan": plan(survey([], [degrees(at) for at in ROUTE])),
    "route.waypoints": WPL,
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_flown_as_long_as_it_is_and_what_is_not_flown_is_a_line(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(FILES[name])
    with pytest.warns(FieldNote) as notes:
        flown = fly(tmp_path / name, "pool", arguments={"speed_m_s": 0.7})
    assert flown.ended_because == "the mission is over" or not flown.ended_early
    legs = lanes_flown(flown.events)
    assert legs is not None and legs.planned_m == pytest.approx(9.0, rel=0.01) and legs.flown_m > 0.95 * 9.0
    track = np.array([legs.each[k]["planned_m"] for k in range(legs.lanes)])
    np.testing.assert_allclose(track, [5.0, 4.0], rtol=0.01)
    lines = " ".join(str(note.message) for note in notes)
    assert "item 1, the first point, is assumed at the vehicle's start" in lines or name == "simple.plan"
    assert ("take-off (22): left out" in lines) == (name == "simple.plan")
    assert ("transects' points" in lines) == (name == "points.plan")


def test_altitudes_of_an_aircraft_are_refused_with_the_way_to_fly_them_under_water(tmp_path: Path) -> None:
    path = tmp_path / "air.plan"
    path.write_text(plan(*[simple(16, at=at, z=50.0) for at in ROUTE]))
    with pytest.raises(MissionError, match=r"air.plan: mission item 1: altitude = 50 m: .*--set altitude_m=3"):
        fly(path, "pool")
    with pytest.warns(FieldNote, match="1.5 m above the bed"):
        flown = fly(path, "pool", arguments={"altitude_m": 1.5, "first_at_m": [2.0, -3.0]})
    track = flown.samples["rov"].path_world_m
    assert track[-1] == pytest.approx([6.0, 2.0, -3.5], abs=0.6)
    with pytest.raises(MissionError, match=r"altitude_m = -1 m: must be in \(0, 1000\]"):
        fly(path, "pool", arguments={"altitude_m": -1})
    with pytest.raises(MissionError, match=r"must be above the terrain.*first_at_m"):
        fly(path, "pool", arguments={"altitude_m": 1.5, "first_at_m": [200, 0]})


def test_a_plan_of_which_nothing_can_be_flown_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.plan").write_text(
        plan(simple(22, at=(0, 0), z=10.0), {"type": "ComplexItem", "complexItemType": "x"})
    )
    with pytest.raises(MissionError, match=r"nothing that can be flown: item 2: ComplexItem x: .* take-off \(22\)"):
        fly(tmp_path / "a.plan", "pool")


def corridor(line: list[Any], width_m: float, apart_m: float, entry: int = 0, beyond_m: float = 0.0) -> str:
    calc = {"DistanceToSurface": -2, "DistanceMode": 1, "AdjustedFootprintSide": apart_m}
    inner = {"CameraCalc": calc, "TurnAroundDistance": beyond_m}
    whole = {"type": "ComplexItem", "complexItemType": "CorridorScan", "CorridorWidth": width_m, "EntryPoint": entry}
    return plan({**whole, "polyline": [degrees(at) for at in line], "TransectStyleComplexItem": inner})


def test_a_corridor_without_items_is_lanes_beside_its_line(tmp_path: Path) -> None:
    """A line of 30 m that turns left by 90 deg after 20 m: each lane is d further, or less, from both of its legs."""
    path, line = tmp_path / "corridor.plan", [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0)]

    def lanes(*values: float) -> np.ndarray:
        path.write_text(corridor(line, *values))  # type: ignore[arg-type]
        mission = read_mission_file(path)
        assert "flown along lanes by its line, width and spacing" in mission.notes[0]
        assert {(item.frame, item.z) for item in mission.items} == {(3, -2)}
        return np.array([BAY.world_m(1e-7 * item.x, 1e-7 * item.y, 0.0)[:2] for item in mission.items]).reshape(
            -1, 3, 2
        )

    offsets = [4.0, 0.0, -4.0]
    expected = np.array([[(0, d), (20 - d, d), (20 - d, 10)] for d in offsets])
    expected[1] = expected[1][::-1]
    np.testing.assert_allclose(lanes(12.0, 4.0), expected, atol=0.03)
    np.testing.assert_allclose(lanes(12.0, 4.0, 1), expected[::-1], atol=0.03)
    np.testing.assert_allclose(lanes(12.0, 4.0, 2), expected[:, ::-1], atol=0.03)
    np.testing.assert_allclose(lanes(12.0, 0.0, 0, 3.0), [[(-3, 0), (20, 0), (20, 13)]], atol=0.03)
    for wrong, words in [
        (corridor([(0, 0), (20, 0), (0, 0.5)], 8, 4), "polyline: turns by 179 deg at point 2: must be at most 160"),
        (corridor(line, 1e5, 0.5), "more than 20000 points"),
        (corridor(line[:1], 8, 4), "must have 2 to 20000 points"),
        (corridor(line, -8, 4), "CorridorWidth = -8 m: must be in [0, 100000]"),
    ]:
        path.write_text(wrong)
        with pytest.raises(FieldFileError, match=re.escape(words)):
            read_mission_file(path)


KML = b"""<kml><Placemark><LineString><altitudeMode>absolute</altitudeMode><coordinates>10.2,54.4,-2 10.3,54.4,-3
</coordinates></LineString></Placemark></kml>"""


def test_a_return_ends_where_the_vehicle_floats(tmp_path: Path) -> None:
    """The rov's thrust holds it no higher than 0.26 m deep, where its hull emerges."""
    (path := tmp_path / "return.plan").write_text(plan(TRANSECTS[0], simple(20)))
    flown = fly(path, "pool")
    assert not flown.ended_early
    (event,) = (event for event in flown.events if event.name == "at_surface")
    assert 0.2 < event.values["depth_m"] < 0.35


def test_a_kmz_is_its_doc_kml_and_unpacks_no_more_than_a_file_may_have(tmp_path: Path) -> None:
    path, bare = tmp_path / "area.kmz", tmp_path / "area.kml"
    bare.write_bytes(KML)

    def read(**parts: bytes) -> Any:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in parts.items():
                archive.writestr(name.replace("_", "."), data)
        return read_mission_file(path)

    assert read(doc_kml=KML, other_kml=b"", a_png=b"x") == read(route_kml=KML) == read_mission_file(bare)
    assert is_mission_file(path) and not is_mission_file(path.rename(tmp_path / "area.zip"))
    for parts, words in [
        ({"doc_kml": b" " * 20_000_001}, "doc.kml unpacks to 20000001 bytes: must be at most 20000000"),
        ({"a_kml": KML, "b_kml": KML}, "2 .kml files: must be a KMZ with doc.kml"),
        ({"a_png": KML}, "0 .kml files"),
    ]:
        with pytest.raises(FieldFileError, match=words):
            read(**parts)
    path.write_bytes((tmp_path / "area.zip").read_bytes()[:-30])
    with pytest.raises(FieldFileError, match="is a damaged archive: File is not a zip file"):
        read_mission_file(path)


def test_a_jump_of_a_plan_leads_to_the_item_with_its_own_number(tmp_path: Path) -> None:
    path = tmp_path / "jump.plan"
    path.write_text(plan(*[simple(16, at=at, z=-2.0, own=7 + k) for k, at in enumerate(ROUTE)], simple(177, 8, 2)))
    assert read_mission_file(path).items[-1].param1 == 2
    path.write_text(plan(simple(177, 3, 2)))
    with pytest.raises(FieldFileError, match="jumps to doJumpId 3, which no item has"):
        read_mission_file(path)


def test_a_plan_that_leaves_its_fence_is_refused_and_a_vehicle_that_does_ends(tmp_path: Path) -> None:
    path, text = tmp_path / "fence.plan", plan(*TRANSECTS)
    for fence, words in {
        fenced(text, [(-2, -2), (6, -2), (6, 3), (-2, 3)]): "item 2: the leg .* leaves zone 1 .*, a polygon with 4",
        fenced(text, BOX, [(-2, -2), (1, -2), (1, 7), (-2, 7)]): "item 3: the leg .* leaves zone 2",
        fenced(
            text, BOX, circles=[((2.0, 5.0), 1.0, False)]
        ): "item 3: .* enters zone 2 .*, a circle of 1 m to stay out",
        fenced(
            text, BOX, circles=[((0.0, 0.0), 5.5, True)]
        ): "item 3: .* leaves zone 2 .*, a circle of 5.5 m to stay in",
        fenced(text, [(1, 1), (6, 1), (6, 7)]): "the start of vehicle 'rov', .* leaves zone 1",
    }.items():
        path.write_text(fence)
        with pytest.raises(MissionError, match=words):
            fly(path, "pool")
    path.write_text(fenced(text, BOX))
    assert not fly(path, "pool").ended_early
    narrow = Fence([Zone(True, ((54.4, 10.2),), 3.0)], BAY)
    with Simulator("pool") as sim:
        sim.rov.undock()
        events: list[Any] = []

        def leaves(vehicle: OwnVehicle) -> Any:
            yield from narrow.kept(vehicle, goto(vehicle, [4.0, 0.0, -2.0]))

        sim.rov.place([0.0, 0.0, -2.0], [0, 0, 0, 1])
        with pytest.raises(StoppedError, match=r"the vehicle at \(3.0, .*\) m leaves zone 1 of the fence"):
            run(leaves, sim.rov, sim, hear=events.append)
    assert [event.name for event in events] == ["fence_breached"] and events[0].values["x_m"] == pytest.approx(
        3, abs=0.2
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("QGC WPL 999\n", "line 1: version '999': must be 110 or 120"),
        ("QGC WPL 110\n0 1 0 16 0 0 0 0 54 10 0\n", "line 2: has 11 columns: must have 12"),
        ("QGC WPL 110\n0 1 0 16 0 0 0 0 91 10 0 1\n", "line 2: position: latitude = 91.0 deg: must be in [-90, 90]"),
        ("QGC WPL 110\n0 1 0 16 0 0 0 x 54 10 0 1\n", "line 2: parameter = 'x': must be a number"),
        ("QGC WPL 110\n", "has nothing to fly"),
        ('{"fileType": "Mission"}', "fileType = 'Mission': must be 'Plan'"),
        ('{"fileType": "Plan", "mission": {"items": [3]}}', "mission.items[0] = 3: must be an object"),
        (plan({"type": "SimpleItem", "params": [1]}), "mission.items[0]: params = [1]: must be a list of 7 numbers"),
        ('{"fileType": ', "not JSON"),
        (
            fenced(FILES["simple.plan"], [(0, 0), (1, 0)]),
            "geoFence zone 1 of polygons: polygon: has 2 corners: must be",
        ),
        (
            fenced(FILES["simple.plan"], circles=[((0, 0), -1, True)]),
            "zone 1 of circles: radius = -1 m: must be in [0.01",
        ),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_with_the_place(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "m.txt").write_text(text)
    with pytest.raises(FieldFileError) as caught:
        read_mission_file(tmp_path / "m.txt")
    assert str(caught.value).startswith(str(tmp_path / "m.txt")) and words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_triggers_take_pictures_with_their_places_by_distance_and_by_time(tmp_path: Path) -> None:
    """By distance, one for each 2 m of 9 m and the first; by time, three at once, after 1 s and 2 s."""
    path, out = tmp_path / "triggers.plan", tmp_path / "out"
    by_time = simple(2000, 0, 1.0, 3.0)
    path.write_text(plan(TRANSECTS[0], simple(206, 2.0, 0, 1), *TRANSECTS[1:], by_time, simple(93, 4.0), TRIGGER))
    flown = fly(path, "pool", out, arguments={"first_at_m": [-4.0, -3.0]}, report="none")
    rows = list(csv.DictReader((out / "pictures" / "pictures.csv").open()))
    assert [row["file"] for row in rows] == sorted(each.name for each in (out / "pictures").glob("*.png"))
    by_item = {item: [row for row in rows if row["item"] == str(item)] for item in (2, 3, 4, 5, 6)}
    far = [Home(54.4, 10.2).world_m(float(row["latitude_deg"]), float(row["longitude_deg"]), 0) for row in rows]
    count = sum(len(by_item[item]) for item in (2, 3, 4))
    assert count in (5, 6) and len(by_item[5]) + len(by_item[6]) == 3
    gaps = [float(np.linalg.norm(b - a)) for a, b in pairwise(far[:5])]
    assert gaps == pytest.approx([2.0] * 4, abs=0.25)
    times = [float(row["time_s"]) for row in by_item[5] + by_item[6]]
    assert np.diff(times) == pytest.approx([1.0, 1.0], abs=0.11)
    assert all(abs(float(row["depth_m"]) - 2.0) < 0.5 for row in rows)
    assert sum(event.name == "picture" for event in flown.events) == len(rows)


def test_a_plan_that_is_written_is_read_alike_and_as_long_as_its_lanes(tmp_path: Path) -> None:
    out, source = tmp_path / "out.plan", tmp_path / "in.plan"
    document, note = plan_of("pool")
    assert note is not None and "is not on Earth: its origin is assumed" in note
    out.write_text(json.dumps(document))
    items = read_mission_file(out).items
    survey = load("pool").survey
    assert survey is not None
    lanes = survey_plan(survey).lanes_near(np.zeros(2))
    legs = list(planned_legs_m(items, HOME))
    assert legs[::2] == pytest.approx([lane.length_m for lane in lanes], abs=0.02)
    assert {(item.frame, item.z) for item in items[1:]} == {(10, survey.altitude_m)} and items[0].param2 == 0.5
    source.write_text(fenced(plan(*TRANSECTS, TRIGGER, simple(177, 0, 2)), BOX, circles=[(ROUTE[0], 1.0, False)]))
    out.write_text(json.dumps(plan_of(str(source))[0]))
    assert read_mission_file(out) == read_mission_file(source)
