"""Other people's libraries have the same sea water, rigid body and camera."""

import runpy
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from uwsim.base.texts.json_text import read_json
from uwsim.evidence.validate import peers
from uwsim.evidence.validate.peers import added_mass, focused_light, lamp_light


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
