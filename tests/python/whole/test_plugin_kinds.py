"""A package of others, tests/plugin, adds one of each kind by its entry points alone."""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from command_line import error_line, uwsim, uwsim_in_another_process
from docs_pages import ROOT
from plugin_package import add_package, with_plugins
from uwsim.scenario.spec.sensor_kind import DerivedKind

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
  - {kind: cone, name: cones, density_per_m2: 0.01, size_m: [0.2, 0.3], depth_m: [22, 30], material: maerl}
ground: {bed: maerl}
"""
UNKNOWN = ["'slope'", "'maerl'", "'pyramid'", "'cone'", "'light'", "'clipped'", "'kelp'"]
SONAR = "eye: {kind: clipped, position_m: [0.2, 0, 0], margin_db: 20, beams: 64, range_bins: 200}"
LIGHT = "light: {kind: light, rate_hz: 2, latency_s: 0.1, attenuation_1_m: 0.2, noise: {std: 1.5, turn_on_std: 0.5}}"


Ran = dict[str, subprocess.CompletedProcess[str]]

PARTS = ("fault", "sensor", "imaging_sonar", "exercise", "terrain", "obstacle", "cover")
FLY = "from uwsim.missions import wait\ndef mission(vehicle):\n    vehicle.set_effort(yaw={})\n    yield wait({})\n"
FILES = {
    "toy.yaml": SCENARIO,
    "sink.py": FLY.format(0.3, 4),
    "pilot.py": FLY.format(0.5, 40),
    "turn.yaml": "title: Turn\nbrief: Turn round.\nscenario: pool\nstart: {position_m: [0, 0, -2]}\ntime_s: 60\n"
    "pass_points: 5\ngoals:\n  - {kind: spin, name: turn, title: Turn round, turns: 1}\n",
    "a.xyz": "1 2 3\n4.5 5 -6\n",
    "wrong.csv": "x,y,z\n1,2,what\n",
    "drive.yaml": "name: drive\ntime_constant_s: 0.1\ndiameter_m: 0.1\nthrust_n: {kind: knee, most_n: 40}\n",
    "probe.dat": "TOYPROBE 7\n0.5 15\n10 14\n",
}
COMMANDS = {  # {} is the folder
    **{f"schema {part}": f"scenario schema {part}" for part in PARTS},
    "compare help": "compare --help",
    "exercise": "exercise {}/turn.yaml --pilot {}/pilot.py --out {}/exercised",
    "compare": "compare square --scenario pool --seeds 1 --set side_m=2 --out {}/compared",
    "convert help": "map convert --help",
    "csv": "map convert {}/a.xyz {}/b.csv",
    "xyz": "map convert {}/b.csv {}/c.xyz",
    "wrong csv": "map convert {}/wrong.csv {}/d.ply",
    "grid": "map convert {}/a.xyz {}/d.asc --cell 2",
    "run": "run {}/sink.py --scenario {}/toy.yaml --record {}/sink.mcap --report none --out {}/flown",
    "recording": "recording {}/sink.mcap",
    "replay": "replay {}/sink.mcap",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with FILES, and a vehicle with the package's instruments."""
    made = tmp_path_factory.mktemp("kinds")
    rov = (ROOT / "assets/vehicles/rov.yaml").read_text()
    for key, instrument in (("sensors", LIGHT), ("imaging_sonars", SONAR)):
        rov = rov.replace(f"\n{key}:\n", f"\n{key}:\n  {instrument}\n", 1)
    for name, text in {**FILES, "toy_rov.yaml": rov}.items():
        (made / name).write_text(text)
    return made


@pytest.fixture(scope="module")
def ran(plugins: Path, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """The results of COMMANDS and of the check of all MISTAKES, in one process in which package and MISFITS are."""
    whole, rov = SCENARIO, (folder / "toy_rov.yaml").read_text()
    for k, (old, new, _) in enumerate(MISTAKES):
        (folder / f"rov_{k}.yaml").write_text(rov.replace(old, new, 1))
        (folder / f"wrong_{k}.yaml").write_text(whole.replace("toy_rov.yaml", f"rov_{k}.yaml").replace(old, new, 1))
    wrong = " ".join(f"{{}}/wrong_{k}.yaml" for k in range(len(MISTAKES)))
    commands = COMMANDS | {"check": f"scenario check {{}}/toy.yaml {wrong}"}
    words = [text.replace("{}", str(folder)).split() for text in commands.values()]
    (misfits := tmp_path_factory.mktemp("misfits") / "misfit.py").write_text(MISFITS)
    for part, (name, _) in RULES.items():
        add_package(misfits.parent, f"misfit_{part}", f"uwsim.kinds.{part}", f"mine = misfit:{name}")
    env = with_plugins(plugins, misfits.parent)
    return dict(zip(commands, uwsim_in_another_process(*words, env=env), strict=True))


@pytest.fixture(scope="module")
def found(plugins: Path, folder: Path) -> dict[str, Any]:
    """The JSON that SCRIPT prints in a process in which the package is installed."""
    command = [sys.executable, "-W", "error::UserWarning", "-c", SCRIPT, folder / "toy.yaml", folder / "dumped.yaml"]
    done = subprocess.run(command, env=with_plugins(plugins), capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_kinds_are_in_help_and_schemas(ran: Ran) -> None:
    assert "reach_dock, square" in " ".join(ran["compare help"].stdout.split())
    schemas = {part: json.loads(ran[f"schema {part}"].stdout) for part in PARTS}
    assert schemas["fault"]["definitions"]["Kelp"]["properties"]["times"]["maximum"] == 100
    light, clipped = (
        next(arm for arm in schemas[part]["oneOf"] if arm["properties"]["kind"]["const"] == kind)
        for part, kind in (("sensor", "light"), ("imaging_sonar", "clipped"))
    )
    assert light["properties"]["attenuation_1_m"]["x-unit"] == "1/m"
    assert clipped["description"] == "A forward-looking sonar that drops faint echoes"
    assert {"margin_db", "beams", "field_of_view_deg"} < set(clipped["properties"])
    assert schemas["terrain"]["definitions"]["Slope"]["properties"]["slope_deg"]["x-unit"] == "deg"
    assert "width_m" in schemas["obstacle"]["definitions"]["Pyramid"]["required"]
    assert schemas["cover"]["definitions"]["Cone"]["properties"]["density_per_m2"]["x-unit"] == "1/m2"
    assert schemas["exercise"]["definitions"]["Spin"]["description"] == "Turn round on the spot."


MISFITS = """
from dataclasses import dataclass
from typing import Literal
from uwsim.instruments.sonars.imaging import ForwardLooking
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.imaging_sonar import ImagingKind
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


RULES = {
    "obstacle": ("Obstacle", "must have the fields material"),
    "terrain": ("Terrain", 'must have the field `source: Literal["mine"]`'),
    "imaging_sonar": ("SONAR", "Sonar.plain: must be made by uwsim.scenario.spec.imaging_sonar.figure"),
}


def test_kinds_that_do_not_fit_are_left_out_with_a_warning(ran: Ran) -> None:
    schemas = [ran[f"schema {part}"] for part in RULES]
    assert all(each.returncode == 0 and '"mine"' not in each.stdout for each in schemas)
    assert all(" of misfit-" in line for each in schemas for line in each.stderr.splitlines())
    lines = [line for each in ran.values() for line in each.stderr.splitlines() if " of misfit-" in line]
    assert len(lines) == len(RULES), lines
    for part, (name, rule) in RULES.items():
        start = f"uwsim: warning: uwsim.kinds.{part}: 'mine' of misfit-{part.replace('_', '-')} (misfit:{name}): "
        assert [line.startswith(f"{start}cannot be used: ") for line in lines if rule in line] == [True]


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
    ("bed: maerl", "bed: mael", "ground.bed = 'mael': must be one of plain, sand, gravel, mud,"),
    ("margin_db: 20", "margin: 20", "unknown key; did you mean 'margin_db'?"),
    ("turn_on_std", "walk", "noise.walk = 0.5: must be 0 for 'light'"),
]


def test_kinds_are_checked_with_the_scenario(ran: Ran, folder: Path) -> None:
    checked = ran["check"]
    assert "toy.yaml: ok" in checked.stdout and checked.returncode == 1
    all_lines = (checked.stdout + checked.stderr).splitlines()
    assert [line for line in all_lines if ": ok" in line and "toy.yaml: ok" not in line] == []
    for k, (_, _, rule) in enumerate(MISTAKES):
        lines = [line for line in all_lines if f"wrong_{k}.yaml" in line or f"rov_{k}.yaml" in line]
        assert any(rule in line for line in lines), (rule, lines)
    missing = uwsim("scenario", "check", folder / "toy.yaml")
    assert "kind = 'light': must be one of imu" in missing.stderr, "without the package"


SCRIPT = """
import json, pickle, sys
import numpy as np
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from uwsim import Batch, Simulator
from uwsim.channels import Table
from uwsim.channels.families.telemetry import plain_panel
from uwsim.instruments.sonars import imaging
from uwsim.link import Carrier
from uwsim.live import LiveSimulator
from uwsim.operator.station.sessions.running import SHOWN
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.cast_file import read_cast
from uwsim.scenario.spec.actuator import load_thruster
from uwsim.scenario.spec.link import load_modem

def refusal(call):
    try:
        call()
    except ValueError as error:
        return str(error)

sim = Simulator(sys.argv[1])
rov, table = sim.rov, Table(sim)
scenario = load(sys.argv[1])
write_scenario(Path(sys.argv[2]), scenario)
again = load(sys.argv[2])
world = {
    "bed": sim.world.height_at([[0.0, 0.0], [7.0, 6.0]]).tolist(),
    "above": sim.scene.distance_m([[20.0, 5.0, -10.0]]).tolist(),
    "same": [each == scenario for each in (again, pickle.loads(pickle.dumps(scenario)))],
    "labels": sim.label_names,
    "sound": scenario.ground.backscatter.fluid,
    "modem": load_modem("blue_light").bit_rate_bit_s,
    "cast": {k: list(v) for k, v in read_cast(Path(sys.argv[1]).with_name("probe.dat")).columns.items()},
    "thrust": [load_thruster(Path(sys.argv[1]).with_name("drive.yaml")).thrust_n[k] for k in (0, 400, 560, 800)],
    "look": scenario.cover[0].material.looks,
    "cones": len(sim.around().scene.cover_in([-30, -30], [30, 30])[0]),
    "fingerprints": [scenario_fingerprint(scenario), scenario_fingerprint(again)],
}

sonar = rov.imaging_sonars["eye"]
image = sonar.look()
plain = imaging.ForwardLooking(beams=64, range_bins=200)
core = imaging.look_ahead(sim.around("rov"), sonar.world_from_sonar, plain, name=sonar.stream)
loud = core.level_db >= core.noise_db[:, None] + 20
(picture,) = [each for each in table.channels if each.name.endswith("eye/picture/compressed")]
before = sim.parameters["rov.imaging_sonars.eye.margin_db"]
sim.parameters["rov.imaging_sonars.eye.margin_db"] = 0.0
seen = {
    "loud": float(loud.mean()),
    "same": bool((image.level_db == np.where(loud, core.level_db, core.noise_db[:, None])).all()),
    "picture": picture.type, "margins": [before, sonar.model.margin_db],
    "refused": refusal(lambda: imaging.check(replace(sonar.model, margin_db=-1.0))),
    "louder": float((sonar.look().level_db > core.noise_db[:, None]).mean()),
}

light, stream = rov.sensors["light"], rov.sensors["light"].stream()
drag = [sim.parameters["rov.drag.quadratic.surge"]]
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
repeated = light.read()
(channel,) = [each for each in table.channels if each.type.endswith("Illuminance")]
(topic,) = [each for each in table.channels if each.name == "to_station"]
(service,) = [each for each in table.services if each.name == "where"]
live = SimpleNamespace(read=lambda act: SimpleNamespace(result=lambda: act(sim)))
batch = Batch(sys.argv[1], n=1)
batch.step(round(2.0 / sim.step_s))
member_light = batch.aboard(0).vehicles["rov"].sensors["light"].read()
fresh = Simulator(sys.argv[1])
fresh.advance(2.0)
same = member_light == fresh.rov.sensors["light"].read() == light_at_2_s
sim.faults.inject("sensor", sensor="light", mode="bias", bias=100.0)
measured = {
    "drag": drag, "unit": light.unit, "first": first, "later": [later, repeated, light.read()],
    "stream": [rows.stamps_ns.tolist(), rows.readings[:, 0].tolist()],
    "true": light.read(noise=False), "depth": -rov.pose.position_world_m[2], "type": channel.type,
    "wire": [topic.type, topic.read(sim).data, service.call(live, {})],
    "illuminance": channel.read(sim).illuminance, "refused": refusal(lambda: batch.read("light")), "same": same,
}
(gauges,) = [each for each in table.channels if each.name.endswith("sensor_gauges")]
message = gauges.read(sim)
shown = {"message": [message.names, message.units, message.values.tolist()], "read": light.read()}
shown["panel"] = plain_panel(sim, table.sources[0])["sensor light"]
sim.parameters["rov.sensors.light.on"] = False
off = gauges.read(sim)
shown["off"] = [str(off.values[0]), str(off.ages[0])]
far = Simulator(scenario.with_changes(modem="micromodem"))
far.advance(1.0)
with LiveSimulator(far, paused=True) as live, Carrier(live, Table(far), only=SHOWN) as carrier:
    live.step(4000)
    arrived = carrier.newest("sensor_gauges")
    shown["arrived"] = [arrived.names, arrived.units, arrived.values.tolist()]
print(json.dumps({"world": world, "sonar": seen, "light": measured, "gauges": shown}))
"""


def test_the_terrain_and_the_obstacle_are_in_the_world_and_in_files(found: dict[str, Any]) -> None:
    world = found["world"]
    rise = math.tan(math.radians(10))
    assert world["bed"] == pytest.approx([-20, -20 + 6 * rise], abs=1e-4)
    # It stands on the northern edge of its base, at y = 6.
    assert world["above"] == pytest.approx([10 - 6 * rise - 3], abs=1e-4)
    assert world["labels"][3] == "cones" and 2 < world["cones"] < 40
    assert world["modem"] == 500_000 and world["cast"] == {"depth_m": [0.5, 10], "temperature_deg_c": [15, 14]}
    assert world["thrust"] == [[-1, -40], [0, 0], [pytest.approx(0.4), pytest.approx(20)], [1, 40]]
    assert world["sound"][:2] == [2.492, 1.337] and world["look"] == "gravel"
    assert all(world["same"]) and len(set(world["fingerprints"])) == 1


def test_the_sonar_changes_the_cores_picture_and_has_channels_and_parameters(found: dict[str, Any]) -> None:
    sonar = found["sonar"]
    assert sonar["same"] and 0.0 < sonar["loud"] < sonar["louder"] < 1.0
    assert sonar["picture"] == "sensor_msgs/msg/CompressedImage" and sonar["margins"] == [20.0, 0.0]
    assert sonar["refused"] == "sonar.margin_db = -1 dB: must be in [0, 60] dB"


def test_the_fault_multiplies_the_drag_and_the_sensor_measures_the_light(found: dict[str, Any]) -> None:
    light = found["light"]
    before, during, after = light["drag"]
    assert during == pytest.approx(4 * before) and after == before
    assert light["unit"] == "W/m^2"
    assert light["true"] == pytest.approx(500 * math.exp(-0.2 * light["depth"]), rel=1e-12)
    assert light["first"][0] == light["first"][1] == light["stream"][1][-1], "a sample is the same however it is read"
    assert light["stream"][0] == [500_000_000, 1_000_000_000, 1_500_000_000]
    later, again, biased = light["later"]
    assert later == again != light["first"][0]
    assert biased == pytest.approx(later + 100.0)
    assert 0.0 < abs(later - light["true"]) < 10.0
    assert light["same"] and "rov.sensors['light']: is of a kind in Python" in light["refused"]
    assert light["type"] == "sensor_msgs/msg/Illuminance" and light["illuminance"] == pytest.approx(120.0 * biased)


def test_the_topic_and_the_service_are_of_the_vehicle(found: dict[str, Any]) -> None:
    kind, distance_m, answer = found["light"]["wire"]
    assert kind == "std_msgs/msg/Float64" and 0.0 < distance_m < 100.0
    assert answer["success"] and answer["message"].startswith("[")


def test_the_sensor_is_a_gauge_without_an_entry_of_its_own(found: dict[str, Any], ran: Ran, folder: Path) -> None:
    """On the panel, in pictures, samples, recordings and replays, and over a slow modem; see also station.mjs."""
    gauges = found["gauges"]
    assert gauges["message"] == [["sensor light"], ["W/m^2"], [pytest.approx(gauges["read"])]]
    assert gauges["panel"] == pytest.approx(gauges["read"]) and gauges["off"] == ["nan", "inf"]
    assert gauges["arrived"][:2] == [["sensor light"], ["W/m^2"]] and 0.0 < gauges["arrived"][2][0] < 500.0
    assert "sensor_light" in (folder / "flown/track-rov.csv").read_text().splitlines()[0].split(",")
    assert "sensor_gauges" in ran["recording"].stdout and ran["replay"].returncode == 0, ran["replay"]


def test_the_goal_is_judged_and_the_planner_flies(ran: Ran) -> None:
    assert "10.0 of 10  Turn round" in ran["exercise"].stdout, ran["exercise"]
    assert ran["compare"].returncode == 0 and "square" in ran["compare"].stdout, ran["compare"]


def test_formats_of_clouds_and_grids_are_in_help_written_read_and_refused(ran: Ran, folder: Path) -> None:
    assert ".xyz, .csv)" in " ".join(ran["convert help"].stdout.split())
    assert "b.csv: 2 points" in ran["csv"].stdout and "c.xyz: 2 points" in ran["xyz"].stdout, ran
    assert (folder / "b.csv").read_text() == "x,y,z\n1,2,3\n4.5,5,-6\n"
    assert (folder / "c.xyz").read_text() == "1.0 2.0 3.0\n4.5 5.0 -6.0\n"
    assert "d.asc: 3 x 2 cells of 2 m" in ran["grid"].stdout
    assert (folder / "d.asc").read_text().splitlines()[2:] == [
        *("xllcorner 0.0", "yllcorner 2.0", "cellsize 2.0", "nodata_value nan"),
        *("nan nan 6", "-3 nan nan"),
    ]
    assert "wrong.csv': not a valid CSV file: " in error_line(ran["wrong csv"])
    unknown = error_line(uwsim("map", "convert", folder / "a.xyz", folder / "e.csv"))  # without the package
    assert "must end in .bt, .ot, .pcd, .ply, .las, .laz, .xyz, .tif, .tiff" in unknown


def test_a_recording_with_the_packages_kinds_repeats_to_the_byte(ran: Ran, folder: Path) -> None:
    assert ran["run"].returncode == 0, ran["run"]
    assert "light" in ran["recording"].stdout and "to_station" in ran["recording"].stdout
    assert ran["replay"].returncode == 0 and "the same bytes" in ran["replay"].stdout, ran["replay"]
    lines = uwsim("replay", folder / "sink.mcap").stderr.splitlines()  # without the package
    assert [line.partition(" = ")[2].partition(":")[0] for line in lines] == UNKNOWN, lines


@pytest.mark.parametrize(
    ("fields", "rule"), [({"x": (1, "m\t")}, "unit 'm\\\\t' of 'x': must be printable"), ({}, "at least one")]
)
def test_a_sensor_without_numbers_or_with_an_odd_unit_is_refused(fields: dict[str, Any], rule: str) -> None:
    with pytest.raises(ValueError, match=rule):
        DerivedKind("odd", "odd", "position", fields, lambda values, figures, time_s: {})
