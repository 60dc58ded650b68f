"""A scenario file is loaded as written, or refused with a one-line error that gives the location and the reason."""

import pickle
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from command_line import uwsim
from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError, load, load_vehicle, packaged_scenarios
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.survey import area, narrowest_width

POOL = (assets_folder() / "scenarios" / "pool.yaml").read_text()
ROV = (assets_folder() / "vehicles" / "rov.yaml").read_text()


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def refusal(path: Path, text: str | bytes) -> str:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ScenarioError) as caught:
        load(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message.removeprefix(f"{path}:")


def models(kind: type[Model] = Model) -> Iterator[type[Model]]:
    yield kind
    for below in kind.__subclasses__():
        yield from models(below)


def test_unvalidated_defaults_are_valid() -> None:
    fields = [(kind, name, field.default) for kind in models() for name, field in kind.model_fields.items()]
    for kind, name, default in fields:
        if isinstance(default, Model):
            chosen = {key: getattr(default, key) for key in default.model_fields_set}
            assert repr(type(default).model_validate(chosen)) == repr(default), (kind, name)


@pytest.mark.parametrize("name", packaged_scenarios())
def test_packaged_scenarios_load_by_name_and_as_a_copy_elsewhere(name: str, tmp_path: Path) -> None:
    scenario = load(name)
    assert scenario.name == name
    copy = tmp_path / "copy.yaml"
    copy.write_text((assets_folder() / "scenarios" / f"{name}.yaml").read_text())
    assert load(copy) == load(str(copy)) == scenario
    assert load(scenario) is scenario


def test_files_are_sought_beside_the_yaml_that_names_them(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(ROV.replace("name: rov", "name: mine"))
    (tmp_path / "pool.yaml").write_text(POOL.replace("model: rov", "model: mine.yaml"))
    assert load(tmp_path / "pool.yaml").vehicles[0].model.name == "mine"
    assert load_vehicle("mine.yaml", folder=tmp_path).name == "mine"


def test_the_error_about_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(
        ScenarioError,
        match=r"unknown scenario 'laek': .*cove, .*, lagoon, lake, .*pair, .*, valley.*did you mean 'lake'\?$",
    ):
        load("laek")
    with pytest.raises(ScenarioError, match=r"unknown vehicle 'rv': .*did you mean 'rov'\?$"):
        load_vehicle("rv")
    with pytest.raises(ScenarioError, match=r"^no/such\.yaml: no such file$"):
        load("no/such.yaml")


@pytest.mark.parametrize(
    ("given", "instead", "message"),
    [
        ("sonar: {", "sonr: {", "vehicles[0].sonr: unknown key; did you mean 'sonar'?"),
        ("bed_depth_m: 5", "bed_dept_m: 5", "terrain.bed_dept_m: unknown key; did you mean 'bed_depth_m'?"),
        ("source: noise", "source: nois", "terrain.source = 'nois': must be one of 'noise', 'raster', 'image'; did"),
        ("kind: box", "kind: bx", "obstacles[0].kind = 'bx': must be one of"),
        ("spacing_m: 0.5", "spacing_m: half", "terrain.spacing_m = 'half': must be a number"),
        ("spacing_m: 0.5", "spacing_m: true", "terrain.spacing_m = true: must be a number"),
        ("spacing_m: 0.5", "spacing_m: .nan", "terrain.spacing_m = nan m: must be in [0.02, 100] m"),
        ("size_m: [20, 20]", "size_m: [20.3, 20]", "terrain.size_m = 20.3 m: must be a whole number of spacing_m"),
        ("size_m: [20, 20]", "size_m: [20]", "terrain.size_m = [20]: must have 2 values"),
        ("size_m: [20, 20]", "size_m: [9000, 9000]", "terrain.spacing_m = 0.5 m: makes 324036001 heights"),
        ("model: 2", "model: 5", "vehicles[0].sonar.model = 5: must be in [1, 4]"),
        ("model: 2", "model: 2.5", "vehicles[0].sonar.model = 2.5: must be a whole number"),
        ("mission_time_s: 600", "mission_time_s: -1", "mission_time_s = -1 s: must be in [1, 1000000] s"),
        ("start: station", "start: dock", "vehicles[0].start = 'dock': must be 'station', or position_m and yaw_deg"),
        ("name: box", "name: rov", "vehicles[0].name = 'rov': is already in use"),
        ("name: box", "name: terrain", "obstacles[0].name = 'terrain': is already in use"),
        ("model: rov", "model: rv", "vehicles[0].model: unknown vehicle 'rv'"),
        ("source: noise", "source: image\n  file: no.png", "terrain.bed_depth_m: unknown key"),
        ("[4, -4], [4, 4]", "[4, 4], [4, -4]", "survey.area_m: the edges that start at its corners 0 and 2 meet"),
        ("name: pool", "name: pool\nname: lake", 'duplicate key "name"'),
        ("mission_time_s: 600", "mission_time_s: [600", "not valid YAML"),
        ("mission_time_s: 600", "mission_time_s: 2001-01-01", "neither text, number"),
        ("mission_time_s: 600", "mission_time_s: 2001-99-01", "not valid YAML: not a number or date"),
        ("mission_time_s: 600", "mission_time_s: 0x_", "not valid YAML: not a number or date"),
        ("mission_time_s: 600", "mission_time_s: !!omap [a: 1]", "tags are not supported: remove '!!omap'"),
        ("name: pool", "name: !!python/object/apply:os.system [x]", "tags are not supported: remove '!!python/obj"),
        ("mission_time_s: 600", "seed: " + "9" * 4000, "seed = a number of about 4000 digits: must be in [0, 9"),
        ("mission_time_s: 600", "seed: " + "9" * 5000, "not valid YAML: not a number or date that can be read: '999"),
        ("mission_time_s: 600", f"mission_time_s: {'9' * 4000}", "mission_time_s = a number of about 4000 digits s: m"),
    ],
)
def test_a_mistake_is_reported_with_line_key_value_unit_and_rule(given, instead, message, tmp_path) -> None:
    text = POOL.replace(given, instead, 1)
    got = refusal(tmp_path / "pool.yaml", text)
    number, got = got.split(": ", 1)
    assert got.startswith(message)
    assert len(got) < 300  # names of vehicles
    culprit = message.split(" ")[0].strip(":").split(".")[-1].split("[")[0]
    if culprit.endswith("_m") or culprit in ("sonr", "kind", "model", "start"):
        assert culprit in text.splitlines()[int(number) - 1]


def test_a_mistake_of_a_file_that_two_vehicles_name_is_reported_once(tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("builds_on: bluerov2_heavy\nname: own\nmass_kg: -3\ndrag: 1\n")
    place = "terrain: {source: noise, size_m: [100, 100], spacing_m: 5, bed_depth_m: 8}\n"
    vehicles = "vehicles: [{name: a, model: own.yaml}, {name: b, model: own.yaml}]\n"
    (tmp_path / "two.yaml").write_text(f"name: two\n{place}{vehicles}")
    with pytest.raises(ScenarioError) as refusal:
        load(tmp_path / "two.yaml")
    assert len(refusal.value.mistakes) == 2, refusal.value.mistakes
    assert all("vehicles[0].model: " in mistake and "own.yaml:" in mistake for mistake in refusal.value.mistakes)


def test_all_mistakes_of_a_file_are_reported_at_once_each_with_its_line(tmp_path: Path) -> None:
    """Errors in referenced files are included; errors that merely follow from another error are not."""
    edits = (
        ("bed_depth_m: 5", "bed_dept_m: 5"),  # bed_depth_m is misspelt, not missing
        ("mission_time_s: 600", "mission_time_s: -600"),
        ("spacing_m: 0.5", "spacing_m: half"),
        ("kind: box", "kind: bx"),
        ("model: rov", "model: mine.yaml"),  # `vehicles` is not empty: its item is invalid
        ("model: 2", "model: 7"),
    )
    text = POOL
    for right, wrong in edits:
        text = text.replace(right, wrong, 1)
    vehicle = ROV.replace("kind: altitude", "kind: altitud").replace("buoyancy: neutral", "mass_kg: -3")
    (tmp_path / "mine.yaml").write_text(vehicle)
    path = tmp_path / "pool.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load(path)
    entry = f"{path}:{line_of(text, 'model: mine')}: vehicles[0].model: {tmp_path / 'mine.yaml'}"
    expected = [
        f"{path}:{line_of(text, 'bed_dept_m')}: terrain.bed_dept_m: unknown key; did you mean 'bed_depth_m'?",
        f"{path}:{line_of(text, 'mission_time_s')}: mission_time_s = -600 s: must be in",
        f"{path}:{line_of(text, 'spacing_m')}: terrain.spacing_m = 'half': must be a number",
        f"{path}:{line_of(text, 'kind: bx')}: obstacles[0].kind = 'bx': must be one of",
        f"{entry}:{line_of(vehicle, 'mass_kg')}: mass_kg = -3 kg: must be in",
        f"{entry}:{line_of(vehicle, 'kind: altitud')}: sensors.altitude.kind = 'altitud': must be one of",
        f"{path}:{line_of(text, 'model: 7')}: vehicles[0].sonar.model = 7: must be in [1, 4]",
    ]
    mistakes = caught.value.mistakes
    assert [mistake[: len(start)] for mistake, start in zip(mistakes, expected, strict=True)] == expected
    assert str(caught.value) == mistakes[0]
    assert caught.value.__notes__ == list(mistakes[1:]), "tracebacks show them"


def test_a_mistake_that_is_found_when_the_vehicle_is_built_names_both_files_and_lines(tmp_path: Path) -> None:
    start = ROV.index("centre_of_mass_m:")
    vehicle = ROV[:start] + "centre_of_mass_m: [0, 0, 5]" + ROV[ROV.index("\n", start) :]
    (tmp_path / "mine.yaml").write_text(vehicle)
    text = POOL.replace("model: rov", "model: mine.yaml")
    (tmp_path / "pool.yaml").write_text(text)
    with pytest.raises(ScenarioError) as caught:
        Simulator(tmp_path / "pool.yaml")
    assert str(caught.value).startswith(
        f"{tmp_path / 'pool.yaml'}:{line_of(text, 'name: rov')}: vehicles[0].model: "
        f"{tmp_path / 'mine.yaml'}:{line_of(vehicle, 'centre_of_mass_m')}: vehicle 'rov': centre_of_mass_m = (0, 0, 5)"
    )


def test_the_shell_gets_a_line_for_each_mistake(tmp_path: Path) -> None:
    path = tmp_path / "pool.yaml"
    text = POOL.replace("spacing_m: 0.5", "spacing_m: half")
    path.write_text(text.replace("mission_time_s: 600", "mission_time_s: -600"))
    result = uwsim("scenario", "check", str(path))
    assert result.returncode == 1
    lines = result.stderr.splitlines()
    assert len(lines) == 2
    assert all(line.startswith(f"uwsim: error: {path}:") for line in lines)


def test_a_missing_key_is_named(tmp_path: Path) -> None:
    got = refusal(tmp_path / "pool.yaml", POOL.replace("  bed_depth_m: 5\n", ""))
    assert got == f"{line_of(POOL, 'terrain:')}: terrain.bed_depth_m: missing"


def test_a_missing_terrain_file_is_reported_with_its_line(tmp_path: Path) -> None:
    text = POOL.replace("source: noise", "source: raster\n  water_level_m: 3\n  file: no.tif")
    text = text.replace("  bed_depth_m: 5\n", "")
    got = refusal(tmp_path / "pool.yaml", text)
    assert got.startswith(f"{line_of(text, 'file: no.tif')}: terrain.file = 'no.tif': no such file in ")


def test_an_error_in_a_vehicle_file_names_both_places(tmp_path: Path) -> None:
    vehicle = tmp_path / "mine.yaml"
    vehicle.write_text(ROV.replace("buoyancy: neutral", "buoyancy: neutral\nmass_kg: 3"))
    got = refusal(tmp_path / "pool.yaml", POOL.replace("model: rov", "model: mine.yaml"))
    assert got.startswith(f"{line_of(POOL, 'model: rov')}: vehicles[0].model: {vehicle}:")
    assert "exactly one of mass_kg, density_kg_m3 and buoyancy" in got
    vehicle.write_text(ROV.replace("kind: proximity", "kind: proxmity"))
    with pytest.raises(ScenarioError, match=r"sensors\.proximity_port\.kind = 'proxmity': .*did you mean 'proximity'"):
        load_vehicle(vehicle)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"# only a comment\n",
        b"\x00\x01\x02\x03",
        b"name: \xff\n",
        b"- 1\n",
        b"hello\n",
        b"a:\n\t- b\n",
        b"a: " + b"[" * 1000,
        b"a: 1\n" * 250_000,
        b"a: &x [1,2]\n" + b"".join(b"k%d: &x [*x,*x]\n" % k for k in range(40)),
        b"a: &a {b: *a}\n",
        b"a: 1\n---\nb: 2\n",
        b"1: 2\n",
    ],
    ids=lambda content: content[:12].decode("latin-1"),
)
def test_a_file_that_holds_no_scenario_is_refused_quickly(content: bytes, tmp_path: Path) -> None:
    refusal(tmp_path / "x.yaml", content)


def test_anything_but_a_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="is a folder"):
        load(tmp_path)
    with pytest.raises(ScenarioError, match="not a regular file"):
        load("/dev/zero")
    with pytest.raises(ScenarioError, match="expected a name, a path, a dict or a Scenario"):
        load(5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("area_m", "rule"),
    [
        ([[0, 0], [1e-4, 0], [0, 1e-4]], r"is 7\.07e-05 m across where .*: must be at least 2 voxels, 1 m"),
        ([[0, 0], [8, 8], [8, 8.6]], r"is 0\.4\d* m across"),
        ([[5, 5], [6.5, 5], [6.5, 6.5], [5, 6.5]], r"covers 2\.25 m2: must be at least 10 voxels, 2\.5 m2"),
    ],
)
def test_a_survey_of_too_small_an_area_is_refused(area_m: list[list[float]], rule: str, tmp_path: Path) -> None:
    start = POOL.index("area_m: ")
    end = POOL.index("\n", start)
    got = refusal(tmp_path / "pool.yaml", f"{POOL[:start]}area_m: {area_m}{POOL[end:]}")
    assert re.fullmatch(rf"\d+: survey\.area_m: {rule}.*", got)


@given(turn_deg=st.floats(-180, 180), length=st.floats(1, 100), width=st.floats(0.01, 1), far=st.floats(-1e4, 1e4))
def test_a_polygons_area_and_width_do_not_depend_on_its_place(turn_deg, length, width, far) -> None:
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    corners = np.array([[0, 0], [length, 0], [length, width], [length / 2, width / 2], [0, width]])  # with a notch
    moved = [(float(x), float(y)) for x, y in corners @ [[c, s], [-s, c]] + far]
    assert narrowest_width(moved) == pytest.approx(width, abs=1e-9)
    assert area(moved) == pytest.approx(0.75 * length * width, abs=1e-7)
    assert area(moved[::-1]) == pytest.approx(area(moved), abs=1e-9)


@settings(max_examples=50)
@given(
    line=st.integers(0, len(POOL.splitlines()) - 1),
    edit=st.sampled_from(["drop", "double", "null", "list", "text", "huge", "typo", "indent"]),
)
def test_a_spoilt_line_is_loaded_or_refused(line: int, edit: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    """However a line is changed, the file loads or is refused in one line; no other exception is raised."""
    lines = POOL.splitlines()
    key, colon, value = lines[line].partition(": ")
    lines[line] = {
        "drop": "",
        "double": lines[line] + "\n" + lines[line],
        "null": key + colon,
        "list": f"{key}{colon}[{value}, 1]",
        "text": f"{key}{colon}'{value}'",
        "huge": f"{key}{colon}1e300",
        "typo": f"{key}x{colon}{value}",
        "indent": " " + lines[line],
    }[edit]
    path = tmp_path_factory.getbasetemp() / "spoilt.yaml"
    path.write_text("\n".join(lines))
    try:
        assert isinstance(load(path), Scenario)
    except ScenarioError as error:
        assert str(error).startswith(str(path))
        assert "\n" not in str(error)


def test_changes_are_checked_and_do_not_touch_the_original() -> None:
    pool = load("pool")
    changed = pool.with_changes(seed=5, mission_time_s=60.0, sonar_model=3)
    assert (changed.seed, changed.mission_time_s, changed.vehicles[0].sonar.model) == (5, 60.0, 3)
    assert changed.vehicles[0].sonar.tilt_deg == pool.vehicles[0].sonar.tilt_deg
    assert pool.seed == 0
    assert pool.with_changes() == pool
    with pytest.raises(ScenarioError, match=r"^vehicles\[0\]\.sonar\.model = 7: must be in \[1, 4\]$"):
        pool.with_changes(sonar_model=7)
    with pytest.raises(ScenarioError, match=r"^mission_time_s = 0 s: "):
        pool.with_changes(mission_time_s=0)


def test_numbers_from_numpy_are_accepted_and_booleans_are_not() -> None:
    pool = load("pool")
    changed = pool.with_changes(seed=np.int64(5), mission_time_s=np.float32(60), sonar_model=np.int64(3))  # type: ignore[arg-type]
    assert changed == pool.with_changes(seed=5, mission_time_s=60.0, sonar_model=3)
    assert (type(changed.seed), type(changed.mission_time_s)) == (int, float)
    assert pool.with_changes(mission_time_s=np.int32(60)).mission_time_s == 60.0  # type: ignore[arg-type]
    for wrong in (True, np.bool_(True)):
        with pytest.raises(ScenarioError, match=r"^seed = true: must be a whole number$"):
            pool.with_changes(seed=wrong)  # type: ignore[arg-type]
        with pytest.raises(ScenarioError, match=r"^mission_time_s = true: must be a number$"):
            pool.with_changes(mission_time_s=wrong)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match=r"^seed = a number of about 5000 digits: must be in"):
        pool.with_changes(seed=10**5000)


def test_a_scenario_refers_to_its_file_until_it_is_changed() -> None:
    pool = load("pool")
    line = f"pool.yaml:{line_of(POOL, 'station:')}: "
    assert pool.source_file.line_prefix("station", "nothing") == line
    assert pool.with_changes(seed=3).source_file.line_prefix("station") == line
    assert pickle.loads(pickle.dumps(pool)).source_file.line_prefix("station") == line
    assert pool.model_copy(update={"seed": 3}).source_file.line_prefix("station") == ""
    assert Scenario.model_validate(dict(pool)) == pool
