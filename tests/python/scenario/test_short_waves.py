"""A vehicle that floats in waves shorter than five of its lengths is warned of: its own waves are not modelled."""

import warnings
from pathlib import Path

import pytest

from command_line import uwsim
from uwsim import Simulator, _core
from uwsim.evidence.scenario_check import check_file
from uwsim.scenario.build.wind import ShortWavesWarning, energy_share

LENGTH_M = 0.58  # of a BlueROV2 Heavy, across


def warned(tmp_path: Path, surface: str, start: str = "start: {position_m: [0, 0, 0]}", more: str = "") -> list[str]:
    path = tmp_path / "sea.yaml"
    path.write_text(
        f"name: sea\nwater: {{density_kg_m3: 1000, surface: {surface}}}\nstation: {{dock_m: [0, 0, -0.1]}}\n"
        "terrain: {source: noise, size_m: [40, 40], bed_depth_m: 20}\n"
        f"vehicles: [{{name: rov, model: bluerov2_heavy{more}, {start}}}]\n"
    )
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        Simulator(path)
    of_run = [str(one.message) for one in issued if issubclass(one.category, ShortWavesWarning)]
    assert of_run == [text for text in check_file(path).warnings if "of its lengths" in text]
    return of_run


def airy(length_m: float) -> str:
    """Return a deep-water wave of this length."""
    period_s = (2 * 3.141592653589793 * length_m / 9.80665) ** 0.5
    return f"{{kind: airy, amplitude_m: 0.01, period_s: {period_s:.6f}}}"


DIVING = "start: {position_m: [0, 0, -8]}"


def test_five_lengths_are_the_limit(tmp_path: Path) -> None:
    (text,) = warned(tmp_path, airy(4.8 * LENGTH_M))
    assert "sea.yaml:5: vehicle 'rov' starts at the surface, where 100 % of the waves' energy is in waves" in text
    assert "shorter than 5 of its lengths (0.58 m)" in text
    assert warned(tmp_path, airy(5.2 * LENGTH_M)) == []
    assert warned(tmp_path, "{kind: still}") == []
    assert warned(tmp_path, "{kind: airy, amplitude_m: 0, period_s: 1}") == []


def test_only_a_vehicle_at_the_surface_is_warned_of(tmp_path: Path) -> None:
    short, light = airy(LENGTH_M), ", trim: {net_buoyancy_n: %s}"
    assert warned(tmp_path, short, DIVING) == []
    assert warned(tmp_path, short, DIVING, light % 2) == [], "as operators leave it"
    assert "'rov' rises to the surface, where" in warned(tmp_path, short, DIVING, light % 20)[0]
    assert "'rov' is docked at the surface, where" in warned(tmp_path, short, "start: station")[0]


def test_a_sea_is_judged_by_the_energy_in_short_waves(tmp_path: Path) -> None:
    assert warned(tmp_path, "{kind: jonswap, significant_height_m: 0.2, peak_period_s: 1.5}") != []
    assert warned(tmp_path, "{kind: jonswap, significant_height_m: 0.5, peak_period_s: 5}") == []
    sea = _core.Waves.jonswap(0.5, 3.0, component_count=512)
    assert energy_share(sea, 1e9, 9.80665) == 1.0
    assert energy_share(sea, 14.05, 9.80665) == pytest.approx(0.67, abs=0.05), "above the peak, at 14.05 m"
    shallow = _core.Waves.airy(0.1, 3.0, depth_m=1.0)  # 8.7 m long; 14.1 m in deep water
    assert (energy_share(shallow, 8.8, 9.80665), energy_share(shallow, 8.5, 9.80665)) == (1.0, 0.0)


def test_a_run_prints_it_once(tmp_path: Path) -> None:
    warned(tmp_path, airy(LENGTH_M))
    (tmp_path / "wait.py").write_text("def mission(v):\n    yield from v.wait(1)\n")
    ran = uwsim(
        "run", tmp_path / "wait.py", "--scenario", tmp_path / "sea.yaml", "--out", tmp_path / "out", "--report", "none"
    )
    assert ran.stderr.count("of its lengths") == 1, ran.stderr
