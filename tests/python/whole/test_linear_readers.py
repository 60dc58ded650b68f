"""A law of linearity: a reader of files that is given twice as many of one element does twice the work.

Work is the number of bytecodes that uwsim's own functions execute, which does not depend on the machine. What libraries
in C do is not counted.
"""

import io
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import uwsim
from uwsim.base.texts.csv_table import read_csv
from uwsim.exchange import soundings
from uwsim.exchange.robots import stonefish_text
from uwsim.recording.contents import read_contents
from uwsim.scenario import load
from uwsim.scenario.read import cast_file
from uwsim.scenario.terrains.elevations import GRID_NUMBER

OWN = str(Path(uwsim.__file__).parent)
K = 20


def work(read: Callable[[Path], object], path: Path) -> int:
    """The number of bytecodes, whether the file is refused or not."""
    count = 0

    def step(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal count
        count += event == "opcode"
        return step

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        if not frame.f_code.co_filename.startswith(OWN):
            return None
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        return step

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        with suppress(ValueError):
            read(path)
    finally:
        sys.settrace(before)
    return count


def scenario(lines: list[str]) -> bytes:
    return "\n".join(["name: x", *lines]).encode()


def unknown_keys(count: int) -> bytes:
    return scenario([f"key_{k}: 1" for k in range(count)])


def wrong_items(count: int) -> bytes:
    return scenario(["obstacles:", *("  - {kind: box, size_m: [1, -2]}" for _ in range(count))])


def nested_unknown_keys(count: int) -> bytes:
    return scenario(["water:", *(f"  key_{k}: 1" for k in range(count)), "survey: {area_m: 1}"])


def rows(count: int) -> bytes:
    return ("time_s,x_m\n" + "".join(f"{k},1\n" for k in range(count))).encode()


def chain(count: int) -> bytes:
    links = "".join(f'<link name="l{k}"/>' for k in range(count + 1))
    joints = "".join(
        f'<joint name="j{k}" type="fixed"><parent link="l{k}"/><child link="l{k + 1}"/></joint>' for k in range(count)
    )
    return f'<robot name="r">{links}{joints}</robot>'.encode()


def star(count: int) -> bytes:
    links = "".join(f'<link name="l{k}"><unknown_{k}/></link>' for k in range(count + 1))
    joints = "".join(
        f'<joint name="j{k}" type="fixed"><parent link="l0"/><child link="l{k + 1}"/></joint>' for k in range(count)
    )
    return f'<robot name="r">{links}{joints}</robot>'.encode()


def read_urdf(path: Path) -> object:
    from uwsim.exchange.robots.urdf import read_urdf

    return read_urdf(path)


def read_sdf(path: Path) -> object:
    from uwsim.exchange.robots.sdf import read_sdf

    return read_sdf(path)


def models(count: int) -> bytes:
    links = "".join(f'<model name="m{k}"><link name="l"/></model>' for k in range(count))
    return f'<sdf version="1.9"><world name="w">{links}</world></sdf>'.encode()


def model_links(count: int) -> bytes:
    links = "".join(f'<link name="l{k}"><inertial><mass>1</mass></inertial></link>' for k in range(count))
    joints = "".join(
        f'<joint name="j{k}" type="fixed"><parent>l0</parent><child>l{k}</child></joint>' for k in range(1, count)
    )
    return f'<sdf version="1.9"><model name="m">{links}{joints}</model></sdf>'.encode()


def recorded(count: int) -> bytes:
    from mcap.writer import Writer

    out = io.BytesIO()
    writer = Writer(out, chunk_size=1000)
    writer.start()
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
    for k in range(count):
        channel = writer.register_channel(f"/topic_{k}", "cdr", schema)
        for message in range(3):
            writer.add_message(channel, message, b"\0\1\0\0" + bytes(8), message)
    writer.finish()  # type: ignore[no-untyped-call]
    return out.getvalue()


READERS: dict[str, tuple[str, Callable[[int], bytes], Callable[[Path], object]]] = {
    "unknown keys": ("s.yaml", unknown_keys, load),
    "unknown keys below one": ("s.yaml", nested_unknown_keys, load),
    "wrong items": ("s.yaml", wrong_items, load),
    "rows of a table": ("t.csv", rows, lambda path: read_csv(path).numbers("x_m")),
    "links in a row": ("r.urdf", chain, read_urdf),
    "links side by side": ("r.urdf", star, read_urdf),
    "models of a world": ("w.sdf", models, read_sdf),
    "links of a model": ("m.sdf", model_links, read_sdf),
    "topics of a recording": ("r.mcap", recorded, read_contents),
}


@pytest.mark.parametrize("name", READERS)
def test_twice_as_much_is_twice_the_work(tmp_path: Path, name: str) -> None:
    file, made, read = READERS[name]
    counts: list[int] = []
    for times in (1, 1, 2, 4):  # the first one also imports, and fills caches
        (tmp_path / str(len(counts))).mkdir()
        path = tmp_path / str(len(counts)) / file
        path.write_bytes(made(K * times))
        counts.append(work(read, path))
    _, one, two, four = counts
    assert four - two < 2.5 * (two - one), counts


NUMBERS = (GRID_NUMBER, cast_file.NUMBER, soundings.NUMBER, stonefish_text.WORD)


@pytest.mark.parametrize("pattern", NUMBERS, ids=lambda pattern: str(pattern.pattern))
def test_a_number_of_a_million_digits_is_read_once(pattern: re.Pattern[Any]) -> None:
    """Read again from each digit, it would take hours, and a test is ended after minutes."""
    word = b"1" * 1_000_000 + b"x!"
    assert not pattern.fullmatch(word if isinstance(pattern.pattern, bytes) else word.decode())
