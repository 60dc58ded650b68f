"""Others' libraries and data agree: sea water, rigid body, camera, thrust, noise, a surveyed sea floor."""

import runpy
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from uwsim.base.texts.json_text import read_json
from uwsim.cli.program import app
from uwsim.evidence.validate import peers, run_suite
from uwsim.evidence.validate.peers import added_mass, focused_light, lamp_light
from uwsim.evidence.validate.reality import arm_tilts, glides
from uwsim.scenario import load_vehicle


@pytest.mark.parametrize("peer", peers.PEERS)
def test_a_peer_agrees(peer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    hulls = {"cone": added_mass.HULLS["cone"]}
    monkeypatch.setattr(added_mass, "HULLS", hulls)  # of ten, which take 30 s
    package, distribution = peers.PEERS[peer]
    pytest.importorskip(package, reason=f"pip install {distribution}")
    checks = import_module(f"uwsim.evidence.validate.peers.{peer}").checks()
    assert checks and [check for check in checks if not check.passed] == []


def test_capytaine_recomputes_its_stored_results() -> None:
    pytest.importorskip("capytaine", reason="pip install capytaine")
    make = runpy.run_path(str(Path(__file__).parents[1] / "data/make_capytaine_added_mass.py"))
    for name in ("sphere", "cross"):
        kept = read_json(added_mass.RESULTS)["added_mass"][name][0]
        found = make["added_mass"](*added_mass.HULLS[name](added_mass.LEVELS[0]))
        np.testing.assert_allclose(found, kept, rtol=1e-4)


def test_mitsuba_recomputes_its_stored_results() -> None:
    pytest.importorskip("mitsuba", reason="pip install mitsuba")
    make = runpy.run_path(str(Path(__file__).parents[1] / "data/make_mitsuba_radiance.py"))
    name, scene = next(iter(lamp_light.SCENES.items()))
    kept = read_json(lamp_light.RESULTS)["single"][name]["II"][0][1]
    found, error = make["radiance"](scene, 0.0, make["medium"]("II", 1), 2, 1 << 12)
    assert abs(found / kept - 1.0) < 4.0 * error / kept + 0.02


def test_mitsuba_recomputes_the_light_that_waves_focus(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba", reason="pip install mitsuba")
    try:
        make = runpy.run_path(str(Path(__file__).parents[1] / "data/make_mitsuba_caustics.py"))
    except ImportError as error:
        pytest.skip(f"Mitsuba has no LLVM 15 or newer: {error}")
    name = "8 m, I, wind 5 m/s, sun overhead"
    few = make["computed"].__globals__
    monkeypatch.setitem(few, "RAYS", 1 << 18)
    monkeypatch.setitem(few, "BATCHES", 4)
    both = make["particles"](), few["mi"].load_dict({"type": "rayleigh"})
    found, error, _ = make["computed"](focused_light.CASES[name], both)
    assert abs(found.all - read_json(focused_light.RESULTS)["cases"][name]["all"]) < 4.0 * error.all + 0.002


def test_noise_adds_nothing_to_the_spread_of_several_patterns() -> None:
    random = np.random.default_rng(1)
    across = 1.0 + 0.3 * np.sqrt(2.0) * np.cos(2.0 * np.pi * np.arange(64) / 64)[:, None] * np.ones(64)
    noisy = [across + random.normal(0.0, 1.0, across.shape) for _ in range(4)]
    spread = focused_light.spread_of(noisy)
    assert spread.long == pytest.approx(0.3, abs=0.02) and focused_light.spread_of(noisy[:1]).all > 0.4


def test_a_missing_peer_is_reported_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "PEERS", {"absent": ("no_such_package", "no-such-distribution")})
    refused = pytest.raises(ValueError, match="no peer is installed; pip install no-such-distribution")
    with pytest.warns(UserWarning, match="absent is left out: pip install no-such-distribution"), refused:
        peers.run()


DATA = Path(__file__).parents[4] / "shared/reality"


def test_what_others_measured_is_met_within_the_stated_tolerances(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every fifth of the trials with an arm is flown; `uwsim validate reality` flies all."""
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}: docs/inside/reality.md lists the sources of the files")
    monkeypatch.setattr(arm_tilts, "FLOWN", slice(0, None, 5))
    has_glides = (DATA / glides.FILE).is_file() and find_spec("dbdreader") is not None
    checks = run_suite("reality", tmp_path, DATA)
    groups = list(dict.fromkeys(check.group for check in checks))
    assert groups == [
        "predicted: T200 bench test",
        "predicted: RiverPro, DVL",
        "predicted: Workhorse Navigator, DVL",
        "predicted: EM 302",
        "predicted: Hinsdale, arm and tilt",
        "predicted: Hinsdale, arm and motion",
        *(["predicted: Slocum, glides"] if has_glides else []),
        "as measured: T200 bench test",
        "as measured: Workhorse Navigator, DVL",
        "as measured: Ping1D, echosounder",
        "as measured: Underwater GPS",
        "as measured: NOAA F00788",
    ]
    assert [check.name for check in checks if not check.passed] == []
    drawn = {check.group for check in checks if check.curve is not None}
    assert len(list(tmp_path.glob("reality-*.png"))) == len(drawn) == 6 + has_glides


def test_missing_data_is_reported_with_its_path_and_source(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["validate", "reality"])
    assert result.exit_code != 0 and "needs --data FOLDER" in str(result.exception)
    refused = pytest.raises(ValueError, match=f"no data in {tmp_path}")
    with pytest.warns(UserWarning, match="thrust is left out: no .*t200_10_14_16_20V.csv"), refused:
        run_suite("reality", data=tmp_path)


def test_glides_are_split_where_the_pump_turns_and_their_speeds_are_those_of_the_record() -> None:
    times_s = np.arange(0.0, 1600.0, 4.0)
    down = times_s % 800.0 < 400.0
    depth_m = np.where(down, times_s % 400.0, 400.0 - times_s % 400.0) * 0.1
    bar = depth_m * glides.WATER_KG_M3 * glides.GRAVITY_M_S2 / glides.PA_PER_BAR
    windows = glides.split(times_s, bar, np.where(down, -0.4, 0.4), np.where(down, -230.0, 230.0))
    assert set(windows.glide) == {0, 1, 2, 3}
    np.testing.assert_allclose(windows.rises_m_s, 0.1 * np.sign(windows.pumped_cm3), rtol=1e-6)
    half = glides.split(times_s, bar, np.zeros(400), np.where(down, -100.0, 230.0))
    assert (half.pumped_cm3 == 230.0).all()  # a pump that is not full is no glide


def test_a_simulated_glider_falls_by_the_root_of_its_net_weight() -> None:
    slocum = load_vehicle("slocum")
    pitches, speeds, full_n = glides.simulated_glides(slocum)
    assert (np.diff(pitches) > 0).all() and np.radians(24.0) < pitches[-1] and full_n == 2.514
    pump = slocum.thrusters["pump"]
    half = [(share, 0.5 * thrust_n) for share, thrust_n in pump.model.thrust_n]
    weaker = pump.model_copy(update={"model": pump.model.model_copy(update={"thrust_n": tuple(half)})})
    found = glides.simulated_glides(slocum.model_copy(update={"thrusters": slocum.thrusters | {"pump": weaker}}))
    at = np.radians(22.0)
    assert np.interp(at, *found[:2]) == pytest.approx(np.sqrt(0.5) * np.interp(at, pitches, speeds), rel=0.02)
