"""Public objects describe and plot themselves, can be pickled, and have the types that they declare."""

import copy
import pickle
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import get_type_hints

import nbformat
import numpy as np
import pytest
from matplotlib.figure import Figure
from nbclient import NotebookClient

import uwsim
from uwsim import _core
from uwsim.instruments.readings import READINGS
from uwsim.mapping import OccupancyMap
from uwsim.mapping.plan_view import highest
from uwsim.missions import Steps, wait
from uwsim.navigation.control import Controller, PathFollower
from uwsim.scenario.spec.optics import Optics, OpticsChanges
from uwsim.scoring.survey_track import SurveyTrack

ROOT = Path(__file__).parents[3]
PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def sim() -> uwsim.Simulator:
    made = uwsim.Simulator("pool", seed=3)
    made.rov.undock()
    made.advance(0.5)
    return made


def equal(one: object, other: object) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return one == other


@pytest.mark.parametrize("what", ["ping", "telemetry", "pose", "velocity", "imu", "frame", "batch"])
def test_results_travel(sim: uwsim.Simulator, what: str) -> None:
    results = {
        "ping": sim.rov.sonar.ping,
        "telemetry": sim.rov.telemetry,
        "pose": lambda: sim.rov.pose,
        "velocity": lambda: sim.rov.velocity,
        "imu": sim.rov.sensors["imu"].read,
        "frame": lambda: sim.rov.cameras["front"].capture(geometry_only=True),
        "batch": lambda: sim.rov.sonar.ping_batch(sim.rov.pose.world_from_body[None]),
    }
    result = results[what]()
    fields = result.to_dict()
    assert fields
    for other in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        for name, value in fields.items():
            if name != "info":
                assert equal(value, getattr(other, name)), name


def test_pickled_arrays_stay_read_only(sim: uwsim.Simulator) -> None:
    ping = pickle.loads(pickle.dumps(sim.rov.sonar.ping()))
    with pytest.raises(ValueError, match="read-only"):
        ping.ranges_m[0] = 1.0


def test_a_physics_ping_travels() -> None:
    model = _core.multibeam_model(2)
    sim = uwsim.Simulator("pool", seed=3)
    sonar = _core.AcousticMultibeam(model, _core.AcousticSpec(), sim.world.water)
    ping = sonar.ping(sim.scene, (0.0, 0.0, -1.0), (0.0, 0.0, 0.0, 1.0))
    again = pickle.loads(pickle.dumps(ping))
    assert all(equal(value, getattr(again, name)) for name, value in ping.to_dict().items())


def test_descriptions_are_one_short_line_without_an_address(sim: uwsim.Simulator) -> None:
    rov = sim.rov
    controller = Controller(rov, 0.1, settings=rov.control)
    follower = PathFollower(controller, [(0.0, 0.0, -2.0), (5.0, 0.0, -2.0)], 0.5)
    things = [sim, sim.scenario, rov, rov.pose, rov.telemetry(), rov.sonar, rov.estimate, rov.battery, rov.control]
    things += [sim.events, sim.faults, sim.parameters, sim.world, sim.scene, uwsim.Batch("pool", n=2).observe()]
    things += [*rov.sensors.values(), *rov.cameras.values(), *rov.lamps.values(), controller, follower]
    for thing in things:
        assert_short(thing)
    assert "cross_track_m=" in assert_short(follower.steer())
    assert repr(rov).endswith("balanced in the water>") and str(sim.scenario) == repr(sim.scenario)
    assert repr(sim) == f"<Simulator 'pool', seed 3, at {sim.time_s:.3f} s, with rov>"


def assert_short(thing: object) -> str:
    text = repr(thing)
    assert "\n" not in text and " at 0x" not in text and len(text) < 400, text
    return text


def test_notebooks_show_pictures(sim: uwsim.Simulator, tmp_path: Path) -> None:
    rov = sim.rov
    sonars, ping, frame = rov.imaging_sonars, rov.sonar.ping(), rov.cameras["front"].capture()
    images = [sonars["forward_looking"].look(), sonars["side_scan"].line()]
    images += [sonars["profiler"].profile(np.linspace(-0.5, 0.5, 5)), ping]
    for image in images:
        assert_short(image)
        assert isinstance(image.plot(), Figure)
    world = OccupancyMap(resolution_m=0.1)
    world.insert_scan(np.array([[1.0, 2.0, -3.0]], np.float32), np.zeros(3))
    for thing in (*images, frame, world, OccupancyMap()):
        assert thing._repr_png_().startswith(PNG)
    frame.save_npz(tmp_path / "frame.npz")
    with np.load(tmp_path / "frame.npz") as saved:
        assert np.array_equal(saved["rgb"], frame.rgb)
        assert np.array_equal(saved["world_from_camera"], frame.world_from_camera)
    with pytest.raises(ValueError, match=r"must end in \.npz"):
        frame.save_npz(tmp_path / "frame.txt")


def test_tracks_show_themselves() -> None:
    path = np.array([[0.0, 0.0, -1.0], [3.0, 4.0, -2.0]])
    track = SurveyTrack(path, np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]]), 50.0, "pool")
    assert repr(track) == "<SurveyTrack of 'pool': 2 pings on 5 m>"
    assert track._repr_png_().startswith(PNG)
    axes = track.plot().axes[0]
    assert axes.collections[0].get_offsets().tolist() == path[:, :2].tolist()
    assert SurveyTrack(path[:0], track.area_world_m, 50.0).plot().axes
    flight = uwsim.fly(waiting, "pool")
    assert repr(flight).startswith("<FlightRecord of waiting in 'pool': 1.0 s simulated") and len(repr(flight)) < 200
    samples = flight.samples["rov"]
    assert samples.plot().axes and " at 0x" not in repr(samples)


def test_progress_in_a_notebook_ends_with_the_last_state(tmp_path: Path) -> None:
    cell = nbformat.v4.new_code_cell("""
        from uwsim.flight.terminal import Terminal
        with Terminal().flight("surveying pool") as show:
            for k in range(1001):
                show(k / 1000, 0.06 * k)
    """)
    notebook = nbformat.v4.new_notebook(cells=[cell])
    NotebookClient(notebook, timeout=600).execute()
    assert [output.data["text/plain"] for output in cell.outputs] == ["surveying pool: 100 %, 1.0 min simulated"]


def waiting(vehicle: object) -> Steps[None]:
    yield wait(1.0)


def test_the_view_from_above_shows_the_highest_voxel() -> None:
    voxels = np.array([[0.1, 0.1, -5.0], [0.1, 0.1, -3.0], [0.5, 0.1, -4.0]])
    heights, extent = highest(voxels, 0.2)
    assert heights.tolist()[0][0] == -3.0
    assert heights.tolist()[0][2] == -4.0
    assert np.isnan(heights[0, 1])
    assert extent == pytest.approx((0.0, 0.6, 0.0, 0.2))


def test_parts_of_a_running_simulator_report_how_to_copy_it(sim: uwsim.Simulator) -> None:
    rov = sim.rov
    parts = [sim, rov, rov.estimate, rov.sensors["imu"], rov.sonar, rov.lamps["front"], rov.cameras["front"]]
    for part in [*parts, next(iter(rov.imaging_sonars.values()))]:
        for attempt in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError, match=r"cannot be copied or pickled: .*save_state\(\)"):
                attempt(part)


def test_advance_names_the_nearest_duration(sim: uwsim.Simulator) -> None:
    with pytest.raises(ValueError, match=r"advance\(0\.035\), or wait\(0\.0333333\)"):
        sim.advance(1 / 30)


def test_optics_have_keyword_arguments() -> None:
    assert set(get_type_hints(OpticsChanges)) == set(Optics.model_fields)


def test_readings_have_the_fields_of_their_kinds() -> None:
    for name in _core.sensor_kinds():
        fields = _core.sensor_kind(name).fields
        if name in READINGS:
            assert set(READINGS[name].__dataclass_fields__) == set(fields)
        else:
            assert [width for width, _ in fields.values()] == [1]


def test_scenarios_are_listed() -> None:
    assert "lake" in uwsim.scenarios()


def test_a_sensor_named_as_a_kind_is_of_that_kind() -> None:
    scenario = uwsim.Simulator("pool").scenario
    rov = scenario.vehicles[0]
    sensors = {**rov.model.sensors, "depth": rov.model.sensors["imu"]}
    with pytest.raises(ValueError, match="must be depth"):
        type(rov.model).model_validate({**dict(rov.model), "sensors": sensors})


USER_SCRIPT = """
    import uwsim

    sim = uwsim.Simulator("pool", seed=7)
    rov = sim.rov
    rov.undock()
    rov.set_effort(surge=0.5)
    sim.advance(1.0)
    speed: float = rov.telemetry().speed_m_s
    rates = rov.sensors["imu"].read().angular_velocity_rad_s
    depth: float = rov.sensors["depth"].read() + 1.0
    stamp: float = rov.sensors["dvl"].sample().stamp_s
    locked: bool = rov.sensors["dvl"].read().bottom_lock > 0.5
    sim.set_optics(jerlov="5C", sun_elevation_deg=2)
    nearest: float = float(rov.sonar.ping().ranges_m.min())
    rov.cameras["front"].capture().save("front.png")
    print(speed, rates, depth, stamp, locked, nearest, uwsim.scenarios())
"""


@pytest.mark.parametrize(
    ("checker", "folder"),
    [(("mypy", "--strict"), ROOT), (("basedpyright", "--level", "error", "--pythonpath", sys.executable), None)],
    ids=["mypy", "basedpyright"],
)
def test_a_users_script_passes_strict_type_checkers(
    checker: tuple[str, ...], folder: Path | None, tmp_path: Path
) -> None:
    """Mypy runs in the project's folder, where the cache of tools/lint has the types of 2000 imported modules."""
    assert Path(uwsim.__file__).with_name("py.typed").exists()
    script = tmp_path / "dive.py"
    script.write_text(textwrap.dedent(USER_SCRIPT))
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import uwsim\nx: str = uwsim.Simulator('pool').rov.sensors['depth'].read()\n")
    command = [sys.executable, "-m", *checker, str(script), str(wrong)]
    done = subprocess.run(command, cwd=folder or tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stdout + done.stderr
    errors = [line for line in done.stdout.splitlines() if " error: " in line or " - error" in line]
    assert len(errors) == 1 and f"{wrong.name}:2:" in errors[0], done.stdout


def test_mistakes_name_what_the_user_wrote(sim: uwsim.Simulator) -> None:
    with pytest.raises(KeyError, match="did you mean 'imu'"):
        sim.rov.sensors["IMU"]
    with pytest.raises(TypeError, match=r"^imaging_sonars\['forward_looking'\].ping\(\): takes no arguments"):
        sim.rov.imaging_sonars["forward_looking"].ping(3)
    with pytest.raises(TypeError, match=r"^imaging_sonars\['profiler'\].ping\(\): takes angles_rad"):
        sim.rov.imaging_sonars["profiler"].ping()


def test_a_scenario_may_be_a_dictionary() -> None:
    terrain = {"source": "noise", "size_m": [20, 20], "spacing_m": 1, "bed_depth_m": 5}
    sim = uwsim.Simulator({"name": "mine", "terrain": terrain, "vehicles": [{"name": "rov", "model": "rov"}]}, seed=3)
    assert (sim.scenario.name, sim.seed, sim.scenario.terrain.bed_depth_m) == ("mine", 3, 5.0)
    with pytest.raises(ValueError, match=r"terrain.bed_depth_m = -1 m: must be"):
        uwsim.Simulator({"name": "mine", "terrain": {**terrain, "bed_depth_m": -1}})
