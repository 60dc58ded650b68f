"""The disk cache: it returns the stored results, and losing it costs only the time to compute them again."""

import json
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

from uwsim.base.texts import yaml_parser
from uwsim.scenario import load, load_mesh
from uwsim.scenario.read import disk_cache, mesh_file, spec_file
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.disk_cache import cached_arrays, cached_json


class Maker:
    """A function that counts its calls."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> tuple[np.ndarray, ...]:
        self.calls += 1
        return np.arange(6.0).reshape(2, 3), np.array([3], np.uint32)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("UWSIM_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def check(arrays: tuple[np.ndarray, ...]) -> None:
    expected = Maker()()
    assert len(arrays) == len(expected)
    for got, wanted in zip(arrays, expected, strict=True):
        assert got.dtype == wanted.dtype
        np.testing.assert_array_equal(got, wanted)


def test_what_was_made_is_not_made_again(folder: Path) -> None:
    make = Maker()
    for _ in range(3):
        check(cached_arrays(make, "thing", b"content", 1.0, "up", np.arange(3)))
    assert make.calls == 1
    assert len(list(folder.iterdir())) == 1


@pytest.mark.parametrize("other", [(b"other", 1.0), (b"content", 2.0), (b"content", "1.0"), (b"conten", b"t1.0")])
def test_other_inputs_are_other_things(folder: Path, other: tuple[bytes | float | str, ...]) -> None:
    make = Maker()
    cached_arrays(make, "thing", b"content", 1.0)
    cached_arrays(make, "thing", *other)
    assert make.calls == 2


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:-7],
        lambda data: data[:50] + b"X" + data[51:],
        lambda data: bytes(len(data)),  # as a loss of power may leave a file that was not flushed
        lambda data: data[: len(data) // 2] + bytes(len(data) - len(data) // 2),
    ],
)
def test_a_damaged_file_is_made_again(folder: Path, damage) -> None:
    make = Maker()
    cached_arrays(make, "thing", b"content")
    (path,) = folder.iterdir()
    path.write_bytes(damage(path.read_bytes()))
    check(cached_arrays(make, "thing", b"content"))
    assert make.calls == 2
    check(cached_arrays(make, "thing", b"content"))
    assert make.calls == 2, "and it is mended"


def test_without_a_folder_it_is_made_each_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("in the way")
    make = Maker()
    for setting in ("", str(tmp_path / "file" / "below"), "/proc/uwsim"):
        monkeypatch.setenv("UWSIM_CACHE", setting)
        check(cached_arrays(make, "thing", b"content"))
    assert make.calls == 3


def test_warnings_come_again(folder: Path) -> None:
    def make() -> tuple[np.ndarray, ...]:
        warnings.warn("repaired", UserWarning, stacklevel=1)
        return (np.zeros(1),)

    for _ in range(2):
        with pytest.warns(UserWarning, match="repaired"):
            cached_arrays(make, "thing", b"content")
    assert not folder.exists()


def test_the_oldest_files_make_room_for_new_ones(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "MAX_FOLDER_BYTES", 10_000)
    monkeypatch.setattr(disk_cache, "CHECK_EVERY_BYTES", 2_000)
    for k in range(50):
        cached_arrays(lambda k=k: (np.full(100, float(k)),), "thing", float(k))
        os.utime(max(folder.iterdir(), key=os.path.getctime), (k, k))
    left = [path.stat().st_size for path in folder.iterdir()]
    assert sum(left) <= 12_000 + max(left)
    make = Maker()
    cached_arrays(make, "thing", 49.0)
    assert make.calls == 0, "the newest is kept"
    cached_arrays(make, "thing", 0.0)
    assert make.calls == 1, "the oldest is not"


def test_json_values_return_as_they_were(folder: Path) -> None:
    value = {"b": [1, 2.5, -0.0, float("inf"), True, None, 2**70], "a": {"text": "\u00e4 \U0001f600\n"}}
    for _ in range(2):
        assert repr(cached_json(lambda: value, "value", "key")) == repr(value)
    assert len(list(folder.iterdir())) == 1


@pytest.mark.parametrize("value", [1 << 20_000, "\ud83d\ude00"], ids=["too many digits", "surrogates"])
def test_a_value_that_json_cannot_write_is_not_stored(value: int | str, folder: Path) -> None:
    assert cached_json(lambda: value, "value", "key") == value
    assert not folder.exists()


@pytest.mark.parametrize("name", ["pair", "reef", "valley"])
def test_a_stored_document_is_the_parsed_one(name: str, folder: Path) -> None:
    path = assets_folder() / "scenarios" / f"{name}.yaml"
    for _ in range(2):
        spec_file._values.cache_clear()
        document = spec_file.read_yaml(path, path.name)
        assert document.values == yaml_parser.plain_values(path.read_text(), path.name)
        line = document.line(("vehicles", 0, "model"))
        assert path.read_text().splitlines()[line - 1].strip(" -").startswith("model:")


def test_a_stored_file_with_a_mistake_is_refused_at_its_line(folder: Path, tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text() + "wire: smoke\n"
    (tmp_path / "mine.yaml").write_text(text)
    for _ in range(2):
        spec_file._values.cache_clear()
        yaml_parser.parsed.cache_clear()
        with pytest.raises(ValueError, match=rf"mine\.yaml:{text.count(chr(10))}: wire = 'smoke'"):
            load(tmp_path / "mine.yaml")
    assert any(path.name.startswith("yaml-") for path in folder.iterdir())


def write_glb(path: Path, height_m: float, buffer: str | None = None) -> None:
    """Write a box. buffer: the name of a file that holds its arrays; the default is the .glb file itself."""
    data = trimesh.creation.box(extents=(1.0, height_m, 1.0)).export(file_type="glb")
    if buffer is not None:
        end = 20 + int.from_bytes(data[12:16], "little")
        tree = json.loads(data[20:end])
        (path.parent / buffer).write_bytes(data[end + 8 :])
        tree["buffers"][0]["uri"] = buffer
        text = json.dumps(tree).encode()
        text += b" " * (-len(text) % 4)
        sizes = [2, 20 + len(text), len(text)]
        data = b"glTF" + b"".join(n.to_bytes(4, "little") for n in sizes) + b"JSON" + text
    path.write_bytes(data)


def test_a_mesh_is_read_once_unless_its_file_names_another(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def height_m(path: Path) -> float:
        return float(np.ptp(load_mesh(path)[0][:, 2]))

    whole, split = folder.parent / "whole.glb", folder.parent / "split.glb"
    for height in (2.0, 3.0):
        write_glb(whole, height)
        write_glb(split, height, "arrays.bin")
        assert (height_m(whole), height_m(split)) == (height, height), "not those of another content"
    monkeypatch.setattr(mesh_file, "_load", lambda *_: pytest.fail("read again"))
    assert height_m(whole) == 3.0
    with pytest.raises(pytest.fail.Exception, match="read again"):
        height_m(split)
