"""Logs of Slocum gliders: what dbdreader returns becomes motion and commands; without it, a clear line."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from uwsim.exchange.logs import glider_log
from uwsim.recording.real_flights.motion import motion_of
from uwsim.recording.real_flights.read import read_flight
from uwsim.scenario import load_vehicle


def log_file(folder: Path) -> Path:
    path = folder / "dive.dbd"
    path.write_bytes(b"dbd_label:    DBD(dinkum_binary_data)file\n" * 3)
    return path


def standing_in(monkeypatch: pytest.MonkeyPatch, logged: dict[str, np.ndarray], times_s: np.ndarray) -> None:
    """Let a log be what is given, every 4 s, in the units of the gliders."""

    class NotLoggedError(Exception):
        pass

    class Log:
        def __init__(self, path: str, cacheDir: str) -> None:  # noqa: N803  # as the library has it
            pass

        def get(self, name: str) -> tuple[np.ndarray, np.ndarray]:
            if name not in logged:
                raise NotLoggedError
            return times_s, logged[name]

        def close(self) -> None:
            pass

    monkeypatch.setattr(glider_log, "find_spec", lambda name: name)
    monkeypatch.setattr(glider_log, "import_module", lambda name: SimpleNamespace(DBD=Log, DbdError=NotLoggedError))


def test_a_glider_that_sinks_bow_down_has_that_motion_and_its_commands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    times_s = np.arange(0.0, 100.0, 4.0)
    logged = {
        "m_roll": 0.0 * times_s, "m_pitch": np.full(25, -0.4), "m_heading": (6.2 + 0.01 * times_s) % (2 * np.pi),
        "m_depth": 0.1 * times_s, "m_ballast_pumped": np.full(25, -200.0), "m_battpos": np.full(25, 1.0),
    }  # fmt: skip
    standing_in(monkeypatch, logged, times_s)
    motion, _ = motion_of(read_flight(log_file(tmp_path)), load_vehicle("slocum"))
    assert motion.thrusters == ("pump", "battery")
    assert motion.efforts == pytest.approx(np.array([[-0.8, -25.4 / 50.0]]))  # heavy, and the mass forward
    assert np.diff(motion.times_s).max() < 1.0
    assert motion.position_m[:, 2] == pytest.approx(-0.1 * motion.times_s)
    x, y, z, w = motion.orientation_xyzw.T
    ahead = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    assert ahead[2] == pytest.approx(np.sin(-0.4))
    east, north = ahead[:2] / np.hypot(*ahead[:2])  # through north, without a turn round the compass
    assert np.hypot(east, north) == pytest.approx(1.0)
    assert east == pytest.approx(np.sin(6.2 + 0.01 * motion.times_s), abs=1e-6)


def test_a_log_without_its_library_or_quantities_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = log_file(tmp_path)
    monkeypatch.setattr(glider_log, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"dive.dbd: a glider's log .*: pip install dbdreader"):
        read_flight(path)
    standing_in(monkeypatch, {}, np.zeros(2))
    with pytest.raises(ValueError, match=r"dive.dbd: a glider's log .*: has none of m_roll"):
        read_flight(path)
