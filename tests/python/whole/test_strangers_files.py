"""Untrusted files never run code or write elsewhere, are read completely or not at all, and never crash a reader."""

import json
import os
import signal
from contextlib import closing
from pathlib import Path
from random import Random

import pytest
from ruamel.yaml import YAML
from tests.fuzz.laws import Laws
from tests.fuzz.mutate_values import mutated
from tests.fuzz.readers import READERS, REFUSED
from tests.fuzz.seeds import seeds

from uwsim.base.texts.yaml_document import MAX_BYTES
from uwsim.recording.capsule import SCENARIO, pack, unpack
from uwsim.recording.commands import COMMANDS
from uwsim.recording.replay import replay
from uwsim.scenario import load

WITHOUT_FILES = {"upload", "mesh_upload", "notes", "commands", "cdr", "frames", "moos", "imc", "json", "ping", "a50"}
WITHOUT_FILES |= {"depth_string"}
WORKFLOWS = Path(__file__).parents[3] / ".github" / "workflows"
FOUND = sorted((Path(__file__).parents[2] / "fuzz" / "found").glob("*/*"))
MISSPELT = {b"step_s": b"stop_s", b"on_wall_clock": b"on_wall_clack", b'"name": "undock"': b'"nome": "undock"'}
MISSPELT |= {b"start.state": b"start.stale", b'"tick": 0': b'"tick": x'}
OUTSIDE = ("../up", "files/0/../../up", "files/0/..", "/tmp/up", "files/0/a/b", "files/1/absent")


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_recording_writes_its_files_only_into_its_folder(name: str, tmp_path: Path) -> None:
    contents = pack(load("pool"))
    plain = json.loads(contents[SCENARIO])
    plain["description"] = {"$file": name, "path": "/nowhere"}
    there = dict.fromkeys(OUTSIDE[:-1], b"")
    with pytest.raises(ValueError, match="names a file"):
        unpack({**contents, **there, SCENARIO: json.dumps(plain).encode()}, tmp_path / "inner")
    assert list(tmp_path.rglob("*")) == []


def test_a_scenario_that_would_take_longer_than_a_user_waits_is_refused_by_its_size(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("name: a\nx: [" + "[]," * (MAX_BYTES // 3) + "]\n")
    with pytest.raises(ValueError, match=f"must be at most {MAX_BYTES}"):
        load(path)


@pytest.mark.parametrize("was", MISSPELT, ids=str)
def test_a_recording_with_a_misspelt_word_is_refused_in_one_line(was: bytes, tmp_path: Path) -> None:
    whole, (path, misspelt) = seeds("mcap")["mcap-1"], (tmp_path / "run.mcap", MISSPELT[was])
    assert was in whole
    path.write_bytes(whole.replace(was, misspelt))
    with pytest.raises(ValueError, match=f"recording|{COMMANDS}") as refused:
        replay(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", READERS)
def test_the_fuzzers_begin_with_inputs_that_are_accepted_and_not_by_halves(name: str) -> None:
    with closing(Laws(name)) as laws:
        outcomes = [laws.hold(data) for data in seeds(name).values()]
    assert any(not outcome.said for outcome in outcomes)


@pytest.mark.parametrize("name", sorted(READERS.keys() - WITHOUT_FILES))
def test_a_pipe_in_a_file_s_place_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would be read for ever."""
    monkeypatch.setattr(Path, "write_bytes", lambda path, _: os.mkfifo(path))
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail("it waits"))
    signal.alarm(20)
    try:
        with pytest.raises(REFUSED):
            READERS[name].read(b"", tmp_path)
    finally:
        signal.alarm(0)


@pytest.mark.parametrize("name", [name for name, reader in READERS.items() if reader.values is not None])
def test_values_that_a_fuzzer_mutates_stay_readable_and_differ(name: str) -> None:
    values = READERS[name].values
    assert values is not None
    for data in sorted(seeds(name).values(), key=len):  # the shortest, since 40 parses of a long one take seconds
        if (before := mutated(data, values, Random(0))) is None:
            continue  # CBOR frames have no such values
        made = {mutated(data, values, Random(seed)) for seed in range(20)}
        assert len(made) > 10
        assert all(each is not None and values.read(each) is not None for each in made - {before, b"null"})
        return
    pytest.fail("no input was mutated")


def test_every_reader_is_attacked_for_an_hour_each_week() -> None:
    weekly = YAML(typ="safe").load(WORKFLOWS / "weekly.yml")["jobs"]["fuzz"]
    assert set(weekly["strategy"]["matrix"]["reader"]) == {*READERS, "state"}
    assert any("--seconds 3600" in step.get("run", "") for step in weekly["steps"])


@pytest.mark.parametrize("path", FOUND, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_a_fuzzer_found_is_mended(path: Path) -> None:
    with closing(Laws(path.parent.name)) as laws:
        laws.hold(path.read_bytes())
