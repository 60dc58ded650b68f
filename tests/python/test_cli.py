"""The command as a user meets it: results on disk, one clear line on a mistake."""

import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from uwsim.mapping import OccupancyMap
from uwsim.scenario.paths import assets_folder

POOL_TERRAIN = "source: noise\n  size_m: [20, 20]\n  spacing_m: 0.5\n  bed_depth_m: 5"
LONG_WAY = "[[-90, -90], [90, -90], [90, 90], [-90, 90]]"
UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]


def uwsim(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*UWSIM, *arguments], capture_output=True, text=True, timeout=120, check=False, **options)


def refused(result: subprocess.CompletedProcess[str]) -> str:
    """The one line on stderr."""
    assert result.returncode != 0
    assert "Traceback" not in result.stderr
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    return lines[0]


def test_a_survey_leaves_a_map_a_report_and_pictures(tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = uwsim("survey", "pool", "--out", str(out), "--seed", "5", "--sonar-model", "1")
    assert result.returncode == 0, result.stderr
    for words in ("simulated time", "real-time factor", "pings", "echoes", "occupied voxels", "coverage", "95th"):
        assert words in result.stdout
    assert len(OccupancyMap.read(out / "map.bt").occupied_voxels()) > 100
    scored = uwsim("map", "score", str(out / "map.bt"), "--scenario", "pool")
    assert scored.returncode == 0, scored.stderr
    coverage = next(line for line in result.stdout.splitlines() if "coverage" in line)
    assert coverage.split("│")[2].strip() in scored.stdout, "the map alone scores as it did when it was flown"
    report = (out / "report.html").read_text()
    assert "data:image/png;base64," in report
    assert "seed" in report
    assert {path.suffix for path in out.iterdir()} == {".bt", ".html", ".npz", ".png"}


def test_sigint_ends_the_command_with_a_valid_map(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    text = text.replace("size_m: [20, 20]", "size_m: [200, 200]").replace(
        "[[-4, -4], [4, -4], [4, 4], [-4, 4]]", LONG_WAY
    )
    scenario = tmp_path / "wide.yaml"
    scenario.write_text(text)
    process = subprocess.Popen(
        [*UWSIM, "survey", str(scenario), "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (tmp_path / "out").exists():  # made when the flight begins
        assert process.poll() is None
        time.sleep(0.05)
    time.sleep(1.0)  # it takes ten times as long to its end
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=90)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted" in output
    assert len(OccupancyMap.read(tmp_path / "out" / "map.bt").occupied_voxels()) > 0
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["survey", "lakee"], "did you mean 'lake'"),
        (["survey", "no/such.yaml"], "no such file"),
        (["survey", "pool", "--sonar-model", "7"], "sonar.model"),
        (["sonar", "pool", "--sonar-model", "em2040-9"], "unknown sonar 'em2040-9'"),
        (["sonar", "pool", "--sonar-model", "em2040-07"], "frequency_khz: missing"),
        (["survey", "pool", "--frequency", "310"], "frequency_khz = 310 kHz"),
        (["survey", "pool", "--mission-time", "-5"], "mission_time_s"),
        (["survey", "pool", "--voxel", "0"], "voxel_m = 0"),
        (["survey", "pool", "--threads", "0"], "threads"),
        (["survey", "pool", "--seed", "-1"], "seed"),
        (["bench", "surveyy"], "unknown"),
        (["surveyy"], "No such command"),
        (["survey", "--voxl", "1"], "--voxl"),
        (["map", "score"], "source"),
        (["bench", "survey", "--voxl", "1"], "--voxl"),
    ],
)
def test_a_mistake_is_one_line(arguments: list[str], expected: str, tmp_path: Path) -> None:
    assert expected in refused(uwsim(*arguments, cwd=tmp_path))
    assert not any(tmp_path.iterdir()), "nothing half-written"


@pytest.mark.parametrize("command", [["survey"], ["camera"], ["map", "slice"], ["bench", "map_memory"]])
def test_help_shows_units(command: list[str]) -> None:
    assert "[m]" in uwsim(*command, "--help").stdout


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("sonar:", "sonr:", "did you mean 'sonar'"),
        ("bed_depth_m: 5", "bed_depth_m: deep", "bed_depth_m"),
        ("bed_depth_m: 5", "bed_depth_m: .nan", "bed_depth_m"),
        (POOL_TERRAIN, "source: raster\n  file: missing.tif\n  water_level_m: 0", "missing.tif"),
        ("mission_time_s: 600", "mission_time_s: -600", "mission_time_s = -600"),
        ("model: rov", "model: submarine", "submarine"),
    ],
)
def test_a_mistake_in_the_yaml_is_named_with_its_line(old: str, new: str, expected: str, tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    assert old in text
    scenario = tmp_path / "mine.yaml"
    scenario.write_text(text.replace(old, new, 1))
    line = refused(uwsim("survey", str(scenario), "--out", str(tmp_path / "out")))
    assert expected in line
    assert "mine.yaml:" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("after_s", [0.05, 0.2, 0.4, 0.6, 0.8])
def test_ctrl_c_before_the_flight_ends_the_program_at_once(after_s: float, tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*UWSIM, "survey", "lake", "--out", str(tmp_path / "out")], stderr=subprocess.PIPE, text=True
    )
    time.sleep(after_s)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode in (130, -signal.SIGINT), "the latter before Python is up"
    assert process.returncode < 0 or "Traceback" not in errors


def test_a_reader_that_goes_away_does_not_cost_the_report(tmp_path: Path) -> None:
    command = f"{sys.executable} -c 'from uwsim.cli import main; main()' survey pool --out {tmp_path} --mission-time 5"
    subprocess.run(f"{command} | true", shell=True, timeout=120, check=True)
    assert {"map.bt", "report.html"} <= {path.name for path in tmp_path.iterdir()}


def test_a_vehicle_that_diverges_in_flight_leaves_the_map_so_far(tmp_path: Path) -> None:
    vehicle = (assets_folder() / "vehicles" / "rov.yaml").read_text()
    start = vehicle.index("linear_damping:")
    end = vehicle.index("\n", start)
    (tmp_path / "stiff.yaml").write_text(
        vehicle[:start] + "linear_damping: [1.0e6, 1.0e6, 1.0e6, 1.0e6, 1.0e6, 1.0e6]" + vehicle[end:]
    )
    scenario = (assets_folder() / "scenarios" / "pool.yaml").read_text().replace("model: rov", "model: stiff.yaml")
    (tmp_path / "stiff_pool.yaml").write_text(scenario)
    line = refused(uwsim("survey", str(tmp_path / "stiff_pool.yaml"), "--out", str(tmp_path / "out")))
    assert "diverged" in line
    assert (tmp_path / "out" / "map.bt").is_file()


def test_an_output_folder_that_cannot_be_written_is_refused_before_anything_is_flown(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    assert "cannot write there" in refused(uwsim("survey", "pool", "--out", str(tmp_path / "file")))
    assert "cannot write there" in refused(uwsim("survey", "pool", "--out", "/proc/uwsim"))


def test_a_full_disk_is_one_line_and_leaves_no_half_file(tmp_path: Path) -> None:
    def small_files_only() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    line = refused(uwsim("survey", "pool", "--out", str(tmp_path), "--mission-time", "5", preexec_fn=small_files_only))
    assert "map.bt" in line
    assert not any(tmp_path.iterdir())


def test_a_disk_that_is_full_after_the_map_says_so_and_shows_the_table(tmp_path: Path) -> None:
    def small_files_only() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    result = uwsim("survey", "pool", "--out", str(tmp_path), "--mission-time", "5", preexec_fn=small_files_only)
    assert "is complete" in refused(result)
    assert "coverage" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"map.bt", "track.npz", "checkpoint"}
    assert "--resume makes the report" in result.stderr


def test_scenarios_are_listed_and_described() -> None:
    listed = uwsim("scenario")
    assert listed.returncode == 0
    assert all(f"{name}:" in listed.stdout for name in ("lake", "valley", "pool"))
    assert "pool:" in uwsim("scenario", "pool").stdout


def test_a_benchmarks_own_options_are_listed() -> None:
    assert "survey" in uwsim("bench").stdout
    shown = uwsim("bench", "survey", "--help").stdout
    assert "--runs" in shown
    assert "uwsim bench survey" in shown


def test_the_bench_prints_where_the_time_goes(tmp_path: Path) -> None:
    figures = tmp_path / "figures.json"
    result = uwsim("bench", "survey", "pool", "--runs", "1", "--mission-time", "3", "--json", str(figures))
    assert result.returncode == 0, result.stderr
    for stage in ("physics", "rays", "codec", "conversion", "map"):
        assert stage in result.stdout
        assert f"{stage}_s" in figures.read_text()
