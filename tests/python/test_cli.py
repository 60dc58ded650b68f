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
    report = (out / "report.html").read_text()
    assert "data:image/png;base64," in report
    assert "seed" in report
    assert {path.suffix for path in out.iterdir()} == {".bt", ".html", ".png"}


def test_sigint_ends_the_command_with_a_valid_map(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    text = text.replace("size_m: [20, 20]", "size_m: [200, 200]").replace(
        "[[-4, -4], [4, -4], [4, 4], [-4, 4]]", LONG_WAY
    )
    scenario = tmp_path / "wide.yaml"
    scenario.write_text(text)
    process = subprocess.Popen(
        [*UWSIM, "survey", str(scenario), "--out", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(3.0)  # it takes ten times as long to its end
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=90)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted" in output
    assert len(OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()) > 0
    assert (tmp_path / "report.html").is_file()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["survey", "lakee"], "did you mean 'lake'"),
        (["survey", "no/such.yaml"], "no such file"),
        (["survey", "pool", "--sonar-model", "7"], "sonar.model"),
        (["survey", "pool", "--mission-time", "-5"], "mission_time_s"),
        (["survey", "pool", "--voxel", "0"], "map.resolution_m = 0"),
        (["survey", "pool", "--threads", "0"], "threads"),
        (["survey", "pool", "--seed", "-1"], "seed"),
        (["bench", "surveyy"], "unknown"),
    ],
)
def test_a_mistake_is_one_line(arguments: list[str], expected: str, tmp_path: Path) -> None:
    assert expected in refused(uwsim(*arguments, cwd=tmp_path))
    assert not any(tmp_path.iterdir()), "nothing half-written"


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


def test_scenarios_are_listed_and_described() -> None:
    listed = uwsim("scenario")
    assert listed.returncode == 0
    assert all(f"{name}:" in listed.stdout for name in ("lake", "valley", "pool"))


def test_the_bench_prints_where_the_time_goes(tmp_path: Path) -> None:
    figures = tmp_path / "figures.json"
    result = uwsim("bench", "survey", "pool", "--runs", "1", "--mission-time", "3", "--json", str(figures))
    assert result.returncode == 0, result.stderr
    for stage in ("physics", "rays", "codec", "conversion", "map"):
        assert stage in result.stdout
        assert f"{stage}_s" in figures.read_text()
