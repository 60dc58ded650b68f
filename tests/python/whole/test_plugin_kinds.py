"""A package of others, tests/plugin, adds one of each kind by its entry points alone."""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from command_line import error_line, uwsim_in_another_process, uwsim_process
from docs_pages import ROOT
from plugin_package import add_package, installed_plugin, with_plugins

SCENARIO = """
name: toy
seed: 4
terrain: {source: slope, size_m: [60, 60], depth_m: 20, slope_deg: 10}
vehicles:
  - {name: rov, model: toy_rov.yaml, start: {position_m: [0, 0, -5]}}
faults:
  - {kind: kelp, times: 4, at_s: 1, for_s: 2}
obstacles:
  - {kind: pyramid, name: cairn, position_m: [20, 5, 0], on_bed: true, width_m: 2, height_m: 3}
cover:
  - {kind: cone, name: cones, density_per_m2: 0.01, size_m: [0.2, 0.3], depth_m: [22, 30]}
"""
UNKNOWN = ["'slope'", "'pyramid'", "'cone'", "'light'", "'clipped'", "'kelp'"]
SONAR = "eye: {kind: clipped, position_m: [0.2, 0, 0], margin_db: 20, beams: 64, range_bins: 200}"
LIGHT = "light: {kind: light, rate_hz: 2, latency_s: 0.1, attenuation_1_m: 0.2, noise: {std: 1.5, turn_on_std: 0.5}}"


@pytest.fixture(scope="module")
def plugins(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return installed_plugin(tmp_path_factory.mktemp("plugins"))


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """Write a scenario with the package's terrain, obstacle and fault; its vehicle has the package's instruments."""
    rov = (ROOT / "assets/vehicles/rov.yaml").read_text()
    for key, instrument in (("sensors", LIGHT), ("imaging_sonars", SONAR)):
        rov = rov.replace(f"\n{key}:\n", f"\n{key}:\n  {instrument}\n", 1)
    (tmp_path / "toy_rov.yaml").write_text(rov)
    (tmp_path / "toy.yaml").write_text(SCENARIO)
    return tmp_path / "toy.yaml"


def run(script: str, plugins: Path, *arguments: Path) -> Any:
    """Return what a script prints, as JSON, in a process in which the package is installed."""
    command = [sys.executable, "-W", "error::UserWarning", "-c", script, *map(str, arguments)]
    done = subprocess.run(command, env=with_plugins(plugins), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_kinds_are_in_help_schemas_and_on_the_instructors_page(plugins: Path) -> None:
    environment = with_plugins(plugins)
    parts = ("fault", "sensor", "imaging_sonar", "exercise", "terrain", "obstacle", "cover")
    commands = [["compare", "--help"], *(["scenario", "schema", part] for part in parts)]
    compare, *shown = uwsim_in_another_process(*commands, env=environment)
    assert "reach_dock, square" in " ".join(compare.stdout.split())
    schemas = {part: json.loads(each.stdout) for part, each in zip(parts, shown, strict=True)}
    assert schemas["fault"]["definitions"]["Kelp"]["properties"]["times"]["maximum"] == 100
    light = next(arm for arm in schemas["sensor"]["oneOf"] if arm["properties"]["kind"]["const"] == "light")
    assert light["properties"]["attenuation_1_m"]["x-unit"] == "1/m"
    clipped = next(arm for arm in schemas["imaging_sonar"]["oneOf"] if arm["properties"]["kind"]["const"] == "clipped")
    assert clipped["description"] == "A forward-looking sonar that drops faint echoes"
    assert {"margin_db", "beams", "field_of_view_deg"} < set(clipped["properties"])
    assert schemas["terrain"]["definitions"]["Slope"]["properties"]["slope_deg"]["x-unit"] == "deg"
    assert "width_m" in schemas["obstacle"]["definitions"]["Pyramid"]["required"]
    assert schemas["cover"]["definitions"]["Cone"]["properties"]["density_per_m2"]["x-unit"] == "1/m2"
    assert schemas["exercise"]["definitions"]["Spin"]["description"] == "Turn round on the spot."
    page = "import json; from uwsim.operator.station.fault_kinds import fault_kinds; print(json.dumps(fault_kinds()))"
    (kelp,) = [kind for kind in run(page, plugins) if kind["kind"] == "kelp"]
    times = kelp["fields"][0]
    assert (times["name"], times["value"], times["high"]) == ("times", 3.0, 100)


MISFITS = """
from dataclasses import dataclass
from typing import Literal
from uwsim.instruments.sonars.imaging import ForwardLooking
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.imaging_kind import ImagingKind
from uwsim.scenario.spec.obstacle import OnBed
from uwsim.scenario.spec.terrain import TerrainModel

class Obstacle(OnBed):
    kind: Literal["mine"]
    name: Name

class Terrain(TerrainModel):
    source: Literal["other"]

@dataclass(frozen=True, kw_only=True)
class Sonar(ForwardLooking):
    kind = "mine"
    plain: float = 1.0

SONAR = ImagingKind(Sonar, print)
"""


@pytest.mark.parametrize(
    ("part", "name", "rule"),
    [
        ("obstacle", "Obstacle", "must have the fields material"),
        ("terrain", "Terrain", 'must have the field `source: Literal["mine"]`'),
        ("imaging_sonar", "SONAR", "Sonar.plain: must be made by uwsim.scenario.spec.imaging_kind.figure"),
    ],
)
def test_a_kind_that_does_not_fit_is_left_out_with_a_warning(part: str, name: str, rule: str, tmp_path: Path) -> None:
    (tmp_path / "misfit.py").write_text(MISFITS)
    package = add_package(tmp_path, "misfit", f"uwsim.kinds.{part}", f"mine = misfit:{name}")
    shown = uwsim_process("scenario", "schema", part, env=with_plugins(package))
    assert shown.returncode == 0 and "mine" not in shown.stdout
    (line,) = shown.stderr.splitlines()
    assert line.startswith(f"uwsim: warning: uwsim.kinds.{part}: 'mine' of misfit (misfit:{name}): cannot be used: ")
    assert rule in line


MISTAKES = [  # in the scenario, or in its vehicle's file
    ("times: 4", "times: 0.5", ":8: faults[0].times = 0.5: must be in [1, 100]"),
    ("times: 4", "time: 4", "faults[0].time: unknown key; did you mean 'times'?"),
    ("[60, 60]", "[60, 60.2]", ":4: terrain.size_m = 60.2 m: must be a whole number of spacing_m"),
    ("slope_deg: 10", "slope_deg: 80", "terrain.slope_deg = 80 deg: must be in [0, 60] deg"),
    ("slope,", "slop,", "'noise', 'raster', 'image', 'slope'; did you mean 'slope'?"),
    (", width_m: 2", "", ":10: obstacles[0].width_m: missing"),
    ("[20, 5, 0]", "[40, 5, 0]", "obstacle 'cairn': (39, 4) m lies outside the terrain"),
    ("kind: kelp", "kind: kel", "'current', 'tether', 'kelp'; did you mean 'kelp'?"),
    ("0.2, noise", "-1, noise", "attenuation_1_m = -1 1/m: must be in [0, 10] 1/m"),
    ("margin_db: 20", "margin_db: 70", "margin_db = 70 dB: must be in [0, 60]"),
    ("margin_db: 20", "margin: 20", "unknown key; did you mean 'margin_db'?"),
    ("turn_on_std", "walk", "noise.walk = 0.5: must be 0 for 'light'"),
]


def test_kinds_are_checked_with_the_scenario(plugins: Path, scenario: Path) -> None:
    environment = with_plugins(plugins)
    whole, rov = scenario.read_text(), scenario.with_name("toy_rov.yaml").read_text()
    files = []
    for k, (old, new, _) in enumerate(MISTAKES):
        files.append(scenario.with_name(f"wrong_{k}.yaml"))
        scenario.with_name(f"rov_{k}.yaml").write_text(rov.replace(old, new, 1))
        files[k].write_text(whole.replace("toy_rov.yaml", f"rov_{k}.yaml").replace(old, new, 1))
    checked = uwsim_process("scenario", "check", scenario, *files, env=environment)
    assert "toy.yaml: ok" in checked.stdout and checked.returncode == 1
    found = checked.stdout + checked.stderr
    assert ": ok" not in found.replace("toy.yaml: ok", "")
    for k, (_, _, rule) in enumerate(MISTAKES):
        lines = [line for line in found.splitlines() if f"wrong_{k}.yaml" in line or f"rov_{k}.yaml" in line]
        assert any(rule in line for line in lines), (rule, lines)
    missing = uwsim_process("scenario", "check", scenario)
    assert "kind = 'light': must be one of imu" in missing.stderr, "without the package"


def test_the_terrain_and_the_obstacle_are_in_the_world_and_in_files(plugins: Path, scenario: Path) -> None:
    script = """
import json, pickle, sys
from pathlib import Path
from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario
from uwsim.scenario.fingerprint import scenario_fingerprint
sim = Simulator(sys.argv[1])
scenario = load(sys.argv[1])
write_scenario(Path(sys.argv[2]), scenario)
again = load(sys.argv[2])
print(json.dumps({
    "bed": sim.world.height_at([[0.0, 0.0], [7.0, 6.0]]).tolist(),
    "above": sim.scene.distance_m([[20.0, 5.0, -10.0]]).tolist(),
    "same": [each == scenario for each in (again, pickle.loads(pickle.dumps(scenario)))],
    "labels": sim.label_names,
    "cones": len(sim.around().scene.cover_in([-30, -30], [30, 30])[0]),
    "fingerprints": [scenario_fingerprint(scenario), scenario_fingerprint(again)],
}))
"""
    found = run(script, plugins, scenario, scenario.with_name("dumped.yaml"))
    rise = math.tan(math.radians(10))
    assert found["bed"] == pytest.approx([-20, -20 + 6 * rise], abs=1e-4)
    # It stands on the northern edge of its base, at y = 6.
    assert found["above"] == pytest.approx([10 - 6 * rise - 3], abs=1e-4)
    assert found["labels"][3] == "cones" and 2 < found["cones"] < 40
    assert all(found["same"]) and len(set(found["fingerprints"])) == 1


def test_the_sonar_changes_the_cores_picture_and_has_channels_and_parameters(plugins: Path, scenario: Path) -> None:
    script = """
import json, sys
import numpy as np
from dataclasses import replace
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.instruments.sonars import imaging
sim = Simulator(sys.argv[1])
sonar = sim.rov.imaging_sonars["eye"]
image = sonar.look()
plain = imaging.ForwardLooking(beams=64, range_bins=200)
core = imaging.look_ahead(sim.around("rov"), sonar.world_from_sonar, plain, name=sonar.stream)
loud = core.level_db >= core.noise_db[:, None] + 20
(picture,) = [each for each in Table(sim).channels if each.name.endswith("eye/picture/compressed")]
before = sim.parameters["rov.imaging_sonars.eye.margin_db"]
sim.parameters["rov.imaging_sonars.eye.margin_db"] = 0.0
try:
    imaging.check(replace(sonar.model, margin_db=-1.0))
except ValueError as error:
    refused = str(error)
print(json.dumps({
    "loud": float(loud.mean()),
    "same": bool((image.level_db == np.where(loud, core.level_db, core.noise_db[:, None])).all()),
    "picture": picture.type, "margins": [before, sonar.model.margin_db], "refused": refused,
    "louder": float((sonar.look().level_db > core.noise_db[:, None]).mean()),
}))
"""
    found = run(script, plugins, scenario)
    assert found["same"] and 0.0 < found["loud"] < found["louder"] < 1.0
    assert found["picture"] == "sensor_msgs/msg/CompressedImage" and found["margins"] == [20.0, 0.0]
    assert found["refused"] == "sonar.margin_db = -1 dB: must be in [0, 60] dB"


def test_the_fault_multiplies_the_drag_and_the_sensor_measures_the_light(plugins: Path, scenario: Path) -> None:
    script = """
import json, math, sys
from uwsim import Batch, Simulator
from uwsim.channels import Table
sim = Simulator(sys.argv[1])
light = sim.rov.sensors["light"]
drag = [sim.parameters["rov.drag.quadratic.surge"]]
stream = light.stream()
sim.advance(2.0)
light_at_2_s = light.read()
sim.advance(0.05)
drag.append(sim.parameters["rov.drag.quadratic.surge"])
first, state = [light.read(), light.read()], sim.save_state()
rows = stream.take()
sim.advance(2.0)
drag.append(sim.parameters["rov.drag.quadratic.surge"])
later = light.read()
sim.restore_state(state)
sim.advance(2.0)
again = light.read()
(channel,) = [each for each in Table(sim).channels if each.type.endswith("Illuminance")]
batch = Batch(sys.argv[1], n=1)
batch.step(round(2.0 / sim.step_s))
try:
    batch.read("light")
except ValueError as error:
    refused = str(error)
member = batch.aboard(0)
member_light = member.vehicles["rov"].sensors["light"].read()
fresh = Simulator(sys.argv[1])
fresh.advance(2.0)
same = member_light == fresh.rov.sensors["light"].read() == light_at_2_s
sim.faults.inject("sensor", sensor="light", mode="bias", bias=100.0)
print(json.dumps({
    "drag": drag, "unit": light.unit, "first": first, "later": [later, again, light.read()],
    "stream": [rows.stamps_ns.tolist(), rows.readings[:, 0].tolist()],
    "true": light.read(noise=False), "depth": -sim.rov.pose.position_world_m[2], "type": channel.type,
    "illuminance": channel.read(sim).illuminance, "refused": refused, "same": same,
}))
"""
    found = run(script, plugins, scenario)
    before, during, after = found["drag"]
    assert during == pytest.approx(4 * before) and after == before
    assert found["unit"] == "W/m^2"
    assert found["true"] == pytest.approx(500 * math.exp(-0.2 * found["depth"]), rel=1e-12)
    assert found["first"][0] == found["first"][1] == found["stream"][1][-1], "a sample is the same however it is read"
    assert found["stream"][0] == [500_000_000, 1_000_000_000, 1_500_000_000]
    later, again, biased = found["later"]
    assert later == again != found["first"][0]
    assert biased == pytest.approx(later + 100.0)
    assert 0.0 < abs(later - found["true"]) < 10.0
    assert found["same"] and "rov.sensors['light']: is of a kind in Python" in found["refused"]
    assert found["type"] == "sensor_msgs/msg/Illuminance" and found["illuminance"] == pytest.approx(120.0 * biased)


def test_the_goal_is_judged_and_the_planner_flies(plugins: Path, tmp_path: Path) -> None:
    environment = with_plugins(plugins)
    (tmp_path / "turn.yaml").write_text(
        "title: Turn\nbrief: Turn round.\nscenario: pool\nstart: {position_m: [0, 0, -2]}\ntime_s: 60\npass_points: 5\n"
        "goals:\n  - {kind: spin, name: turn, title: Turn round, turns: 1}\n"
    )
    (tmp_path / "pilot.py").write_text(
        "from uwsim.missions import wait\ndef mission(vehicle):\n    vehicle.set_effort(yaw=0.5)\n    yield wait(40)\n"
    )
    options = ["--pilot", tmp_path / "pilot.py", "--out", tmp_path / "out"]
    exercise = ["exercise", tmp_path / "turn.yaml", *options]
    options = ["--scenario", "pool", "--seeds", "1", "--set", "side_m=2", "--out", tmp_path / "compared"]
    flown, compared = uwsim_in_another_process(exercise, ["compare", "square", *options], env=environment)
    assert "10.0 of 10  Turn round" in flown.stdout, flown
    assert compared.returncode == 0 and "square" in compared.stdout, compared


def test_formats_of_clouds_and_grids_are_in_help_written_read_and_refused(plugins: Path, tmp_path: Path) -> None:
    environment = with_plugins(plugins)
    (tmp_path / "a.xyz").write_text("1 2 3\n4.5 5 -6\n")
    (tmp_path / "wrong.csv").write_text("x,y,z\n1,2,what\n")
    files = {"a.xyz": "b.csv", "b.csv": "c.xyz", "wrong.csv": "d.ply"}
    help_, *converted, gridded = uwsim_in_another_process(
        ["map", "convert", "--help"],
        *(["map", "convert", tmp_path / source, tmp_path / target] for source, target in files.items()),
        ["map", "convert", tmp_path / "a.xyz", tmp_path / "d.asc", "--cell", "2"],
        env=environment,
    )
    assert ".xyz, .csv)" in " ".join(help_.stdout.split())
    assert "b.csv: 2 points" in converted[0].stdout and "c.xyz: 2 points" in converted[1].stdout, converted
    assert (tmp_path / "b.csv").read_text() == "x,y,z\n1,2,3\n4.5,5,-6\n"
    assert (tmp_path / "c.xyz").read_text() == "1.0 2.0 3.0\n4.5 5.0 -6.0\n"
    assert "d.asc: 3 x 2 cells of 2 m" in gridded.stdout
    assert (tmp_path / "d.asc").read_text().splitlines()[2:] == [
        *("xllcorner 0.0", "yllcorner 2.0", "cellsize 2.0", "nodata_value nan"),
        *("nan nan 6", "-3 nan nan"),
    ]
    assert "wrong.csv': not a valid CSV file: " in error_line(converted[2])
    unknown = error_line(uwsim_process("map", "convert", tmp_path / "a.xyz", tmp_path / "b.csv"))  # without the package
    assert "must end in .bt, .ot, .pcd, .ply, .las, .xyz, .tif, .tiff" in unknown


def test_a_recording_with_the_packages_kinds_repeats_to_the_byte(plugins: Path, scenario: Path) -> None:
    environment = with_plugins(plugins)
    mission, recording = scenario.with_name("sink.py"), scenario.with_name("sink.mcap")
    mission.write_text(
        "from uwsim.missions import wait\ndef mission(vehicle):\n    vehicle.set_effort(yaw=0.3)\n    yield wait(4)\n"
    )
    options = ["--scenario", scenario, "--record", recording, "--out", scenario.with_name("out")]
    flown = uwsim_process("run", mission, *options, env=environment)
    assert flown.returncode == 0, flown
    shown, replayed = uwsim_in_another_process(["recording", recording], ["replay", recording], env=environment)
    assert "light" in shown.stdout
    assert replayed.returncode == 0 and "the same bytes" in replayed.stdout, replayed
    lines = uwsim_process("replay", recording).stderr.splitlines()  # without the package
    assert [line.partition(" = ")[2].partition(":")[0] for line in lines] == UNKNOWN, lines
