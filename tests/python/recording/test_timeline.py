"""A timeline reaches any moment of a recorded run, and refuses a run that cannot be repeated."""

from pathlib import Path

import numpy as np
import pytest

from flown import FLOWN_S, fly
from uwsim import Simulator
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder, Recording
from uwsim.recording.replay import execute
from uwsim.recording.timeline import Timeline


class Forger(Recorder):
    """Writes a sound file with other commands than were issued."""

    def _record_command(self, name, arguments):
        if name == "set_effort" and self._sim.tick == 100:
            arguments = {**arguments, "surge": 0.41}
        super()._record_command(name, arguments)


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fly(tmp_path_factory.mktemp("timeline") / "run.mcap")


@pytest.fixture(scope="module")
def line(flown: Path) -> Timeline:
    return Timeline(Recording(flown))


def test_every_route_to_a_moment_leads_to_the_same_state(line: Timeline) -> None:
    sim = line.simulator()
    place, states = 0, {}
    ticks = [0, 1, 99, 100, 101, 199, 500, 733, line.end_tick]
    for tick in ticks:  # in one go, without saved states
        while (due := line.next_command_tick(place)) is not None and due < tick:
            sim.step(due - sim.tick)
            execute(sim, None, line.commands[place])
            place += 1
        sim.step(tick - sim.tick)
        states[tick] = sim.save_state()
    other = line.simulator()
    for tick in np.random.default_rng(34).permutation(ticks):
        line.go_to(other, int(tick))
        assert other.tick == tick and other.save_state() == states[int(tick)], tick


def test_events_and_track_are_those_of_the_flight(line: Timeline) -> None:
    texts = [event.text for event in line.events]
    assert texts[0] == "undock rov" and any("front" in text for text in texts)
    assert not any("effort" in text for text in texts)
    times_s, poses = line.track.arrays()
    assert times_s[0] == 0.0 and times_s[-1] == FLOWN_S and np.all(np.diff(times_s) > 0.0)
    sim = line.simulator()
    line.go_to(sim, round(times_s[7] / line.step_s))
    assert np.array_equal(poses[7, :3], sim.rov.pose.position_world_m)


def test_a_timeline_ends_at_the_first_reset_and_still_compares_the_end(tmp_path: Path) -> None:
    path = tmp_path / "reset.mcap"
    with LiveSimulator(Simulator("pool", seed=3), paused=True) as live, Recorder(live, path, is_light=True):
        live.command("undock", vehicle="rov").result()
        live.step(400)
        live.reset()
        live.command("undock", vehicle="rov").result()
        live.step(100)
    line = Timeline(Recording(path))
    assert 390 <= line.end_tick <= 400  # that of the last message before the reset
    assert [event.text for event in line.events] == ["undock rov"]


def test_faults_holds_and_changed_water_are_repeated(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    sim = Simulator("pool", seed=3)
    with Recorder(sim, path, is_light=True):
        sim.rov.undock()
        sim.advance(0.5)
        sim.faults.inject("sensor", sensor="depth", mode="stuck", for_s=1.0)
        sim.rov.command("hold", heading=True)
        sim.advance(0.5)
        sim.parameters["water.current_world_m_s.x"] = 0.2
        sim.rov.all_stop(True)
        sim.advance(1.5)
    assert {"alarm", "command"} <= {event.kind for event in Timeline(Recording(path)).events}


def test_a_recording_that_was_cut_off_leads_to_its_last_whole_chunk(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("uwsim.recording.sink.FLUSH_S", 0.0)  # many chunks
    whole = fly(tmp_path / "whole.mcap", end_s=3.0)
    cut = tmp_path / "cut.mcap"
    content = whole.read_bytes()
    cut.write_bytes(content[: len(content) * 2 // 3])
    recording, complete = Recording(cut), Timeline(Recording(whole))
    line = Timeline(recording)
    assert not recording.complete and 0 < line.end_tick == recording.end_tick < complete.end_tick
    here, there = line.simulator(), complete.simulator()
    line.go_to(here, line.end_tick), complete.go_to(there, line.end_tick)
    assert here.save_state() == there.save_state()
    assert line.events == complete.events[: len(line.events)]

    forged = fly(tmp_path / "forged.mcap", recorder=Forger, end_s=3.0)
    cut.write_bytes(forged.read_bytes()[: forged.stat().st_size * 2 // 3])
    with pytest.raises(ValueError, match="was edited, or made on another kind of machine: tick"):
        Timeline(Recording(cut))


def test_only_the_values_of_one_argument_are_one_event_and_switches_are_events_each(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    sim = Simulator("pool", seed=3)
    with Recorder(sim, path, is_light=True):
        sim.rov.undock()
        sim.rov.all_stop(True)
        sim.advance(0.5)
        sim.rov.all_stop(False)
        sim.advance(0.5)
        for name in ("front", "down"):
            for on in (True, False, False):
                sim.rov.lamps[name].on = on
                sim.advance(0.1)
        for k in range(5):
            sim.rov.sonar.aim(0.1 + 0.1 * k)
            sim.advance(0.1)
    events = Timeline(Recording(path)).events
    assert [event.name for event in events].count("all_stop") == 2, "not again as what the vehicle did"
    commands = [event for event in events if event.kind == "command"]
    lamps = [f"set lamp rov: lamp {name}, {on}" for name in ("front", "down") for on in ("on", "off", "off")]
    expected = ["undock rov", "all stop rov: on", "all stop rov: off", *lamps]
    assert [event.text for event in commands[:-1]] == expected
    assert [event.time_s for event in commands[:-1]] == pytest.approx(
        [0.0, 0.0, 0.5, *(1.0 + 0.1 * k for k in range(6))]
    )
    assert commands[-1].text.startswith("aim rov") and "5.73 to 28.6 deg" in commands[-1].text
    assert commands[-1].time_s == pytest.approx(1.6)


def test_an_event_hides_no_value_and_no_second_fault(tmp_path: Path) -> None:
    """Law: of an event of several commands, the first and the last value are the least and the greatest."""
    path = tmp_path / "run.mcap"
    sim = Simulator("pool", seed=3)
    with Recorder(sim, path, is_light=True):
        for value in (0.0, 0.5, 1.0, 0.5, 0.0):  # a switch that is a number goes on and off
            sim.rov.sonar.aim(value)
            sim.advance(0.1)
        for _ in range(2):
            sim.faults.inject("current", velocity_world_m_s=(0.1, 0.0, 0.0))
        sim.advance(0.1)
    events = [event.text for event in Timeline(Recording(path)).events if event.kind == "command"]
    assert [text.split("elevation ")[-1].split(",")[0] for text in events[:2]] == ["0 to 57.3 deg", "28.6 to 0 deg"]
    faults = [f"inject fault: kind current, {name}velocity (0.1, 0, 0) m/s" for name in ("", "name current_2, ")]
    assert events[2:] == faults


def test_a_run_that_cannot_be_repeated_is_refused(flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(flown.read_bytes()[:50_000])
    with pytest.raises(ValueError, match=r"cut\.mcap': is cut off before its first message"):
        Timeline(Recording(cut))

    forged = fly(tmp_path / "forged.mcap", recorder=Forger, end_s=1.5)
    with pytest.raises(ValueError, match="was edited, or made on another kind of machine"):
        Timeline(Recording(forged))
    with monkeypatch.context() as patch:
        patch.setattr("uwsim.recording.timeline.build_fingerprint", lambda: "0123456789abcdef")
        with pytest.raises(ValueError, match="another build"):
            Timeline(Recording(flown))
        patch.undo()
        patch.setattr("uwsim.recording.timeline.LONGEST_S", 5.0)
        with pytest.raises(ValueError, match="lasts 6 s: must last 0 to 5 s"):
            Timeline(Recording(flown))
    with pytest.raises(RuntimeError, match="not wanted"):
        Timeline(Recording(flown), go_on=lambda: False)
