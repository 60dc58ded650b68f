"""A damaged recording is refused, naming the damaged part; a truncated one is read up to its end."""

import shutil
import struct
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import lz4.frame
import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk

from command_line import error_line, uwsim
from uwsim import Simulator
from uwsim.recording import Recorder, mcap_file, mcap_sink
from uwsim.recording.mcap_file import BYTES_PER_BYTE, FREE_BYTES, unpacked
from uwsim.recording.reader import Recording

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
FLIPS = 150


class Record(NamedTuple):
    """A record in a file. number: counted per type, from 1; length: including the record's header."""

    kind: int
    number: int
    start: int
    length: int


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished one-second recording with a dozen chunks."""
    path = tmp_path_factory.mktemp("damage") / "run.mcap"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mcap_file, "CHUNK_BYTES", 20_000)
        sim = Simulator("pool", seed=3)
        with Recorder(sim, path, topics=["odom", "imu", "scan", "sonar_ping"]):
            sim.rov.undock()
            sim.rov.set_effort(surge=0.5)
            sim.advance(1.0)
    return path


@pytest.fixture(scope="module")
def killed(finished: Path) -> Path:
    """The same recording as left by a killed process, without the parts written at the end."""
    end = next(each for each in records(finished) if each.kind == Opcode.METADATA and each.number == 2)
    path = finished.with_name("killed.mcap")
    path.write_bytes(finished.read_bytes()[: end.start])
    assert not Recording(path).complete
    return path


def records(path: Path) -> list[Record]:
    data, found, at = path.read_bytes(), list[Record](), len(MAGIC)
    while at < len(data) - len(MAGIC):
        kind, length = HEAD.unpack_from(data, at)
        found.append(Record(kind, 1 + sum(each.kind == kind for each in found), at, HEAD.size + length))
        at += found[-1].length
    assert data[at:] == MAGIC
    return found


def chunks(path: Path) -> list[Record]:
    return [each for each in records(path) if each.kind == Opcode.CHUNK]


def content(path: Path) -> tuple[Any, ...]:
    """Return everything that a reader gets from a recording."""
    read = Recording(path)
    about = [read.metadata(name) for name in read.channels]
    return read.start, read.end, read.attachments, read.channels, about, list(read.messages())


def flipped(data: bytes, bit: int) -> bytes:
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def bits(path: Path, framed: Path) -> Iterator[int]:
    """Yield random bit positions: throughout the file, in the records' headers, and at both ends of the file."""
    draw, size = Random(1), path.stat().st_size
    frames = [at for each in records(framed) for at in range(each.start, each.start + 40) if at < size]
    yield from (draw.randrange(8 * size) for _ in range(FLIPS))
    yield from (8 * at + draw.randrange(8) for at in draw.sample(frames, FLIPS // 2))
    yield from (8 * at + draw.randrange(8) for at in (*range(16), *range(size - 40, size)))


def refusal(data: bytes, path: Path) -> str:
    path.write_bytes(data)
    with pytest.raises(ValueError) as refused:
        content(path)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_every_wrong_bit_of_a_finished_recording_is_found(finished: Path, tmp_path: Path) -> None:
    whole = finished.read_bytes()
    for bit in bits(finished, finished):
        assert "run.mcap': " in refusal(flipped(whole, bit), tmp_path / "run.mcap"), bit


def test_every_wrong_bit_in_a_chunk_is_found_and_the_chunk_named(finished: Path, tmp_path: Path) -> None:
    whole, draw = finished.read_bytes(), Random(2)
    for chunk in chunks(finished):
        bit = 8 * (chunk.start + chunk.length - 1) - draw.randrange(chunk.length * 4)
        assert f"damaged: chunk {chunk.number} (bytes " in refusal(flipped(whole, bit), tmp_path / "run.mcap")


def test_of_a_killed_run_a_wrong_bit_is_found_or_what_is_read_is_a_beginning(
    finished: Path, killed: Path, tmp_path: Path
) -> None:
    """A wrong length is as a cut; an index is not used; compressed data may have two equivalent encodings."""
    data, path = killed.read_bytes(), tmp_path / "killed.mcap"
    start, _, attachments, _, _, messages = content(killed)
    for bit in bits(killed, finished):
        path.write_bytes(flipped(data, bit))
        try:
            read = content(path)
        except ValueError:
            continue
        assert read[0] == start and read[2].items() <= attachments.items(), bit
        assert read[-1] == messages[: len(read[-1])], bit


def test_a_recording_that_is_cut_off_is_a_beginning_and_says_so(finished: Path, tmp_path: Path) -> None:
    whole, messages = finished.read_bytes(), list(Recording(finished).messages())
    path, sizes = tmp_path / "cut.mcap", Random(3).sample(range(finished.stat().st_size), 40)
    read = 0
    for size in sorted([*sizes, len(whole) - 8, len(whole) - 1]):
        path.write_bytes(whole[:size])
        try:
            cut = Recording(path)
        except ValueError as error:
            assert "or is still empty" in str(error)  # its first metadata are not there
            assert size < chunks(finished)[0].start
            continue
        assert not cut.complete
        found = list(cut.messages())
        assert found == messages[: len(found)]
        assert len(found) >= read
        read = len(found)
    assert read == len(messages)


@pytest.mark.parametrize("of", ["finished", "killed"])
def test_a_block_that_is_doubled_missing_zeroed_or_elsewhere_is_found(
    of: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    original: Path = request.getfixturevalue(of)
    data, messages, draw = original.read_bytes(), list(Recording(original).messages()), Random(4)
    path = tmp_path / "run.mcap"
    for _ in range(40):
        size = 2 ** draw.randrange(4, 16)
        at, other = sorted(draw.sample(range(len(data) - size), 2))
        block = data[at : at + size]
        for damaged in (
            data[: at + size] + data[at:],
            data[:at] + data[at + size :],
            data[:at] + bytes(size) + data[at + size :],
            data[:at] + data[at + size : other + size] + block + data[other + size :],
        ):
            path.write_bytes(damaged)
            try:
                cut = Recording(path)
            except ValueError:
                continue
            read = list(cut.messages())
            if damaged == data:
                continue  # a block of zeros
            assert not cut.complete
            assert read == messages[: len(read)]
            if of == "finished":
                assert data.startswith(damaged), "it is as if cut off"


def test_a_whole_chunk_that_is_there_twice_or_not_at_all_is_found(finished: Path, tmp_path: Path) -> None:
    data, found = finished.read_bytes(), chunks(finished)
    first, second = found[0], found[1]
    end = next(each for each in records(finished) if each.kind == Opcode.METADATA and each.number == 2).start
    block = data[first.start : second.start]
    twice = data[: second.start] + block + data[second.start : end]
    assert "occurs twice, or out of order" in refusal(twice, tmp_path / "run.mcap")
    without = data[: first.start] + data[second.start : end]
    assert "damaged: chunk 1 " in refusal(without, tmp_path / "run.mcap")  # its channels are declared there


def test_a_recording_that_changes_while_it_is_read_is_refused(finished: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    shutil.copy(finished, path)
    opened = Recording(path)
    last = chunks(path)[-1]
    path.write_bytes(flipped(path.read_bytes(), 8 * (last.start + last.length // 2)))
    with pytest.raises(ValueError, match=rf"chunk {last.number} .*has changed since"):
        list(opened.messages())


COMMANDS = (
    ("replay", "{}"),
    ("replay", "{}", "--as-topics", "--port", "0"),
    ("recording", "{}"),
    ("recording", "diff", "{}", "{}"),
    ("map", "from", "{}"),
)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_every_command_refuses_a_damaged_recording_in_a_line_that_names_the_chunk(
    command: tuple[str, ...], finished: Path, tmp_path: Path
) -> None:
    path, chunk = tmp_path / "bad.mcap", chunks(finished)[3]
    path.write_bytes(flipped(finished.read_bytes(), 8 * (chunk.start + chunk.length // 2)))
    done = uwsim(*(word.format(path) for word in command), cwd=tmp_path)
    assert done.returncode == 1 and not done.stdout
    assert f"recording '{path}': damaged: chunk 4 (bytes {chunk.start:,} to " in error_line(done)
    assert list(tmp_path.iterdir()) == [path]


def test_the_replay_of_what_a_kill_left_compares_it_and_ends_with_4(
    finished: Path, killed: Path, tmp_path: Path
) -> None:
    done = uwsim("replay", str(killed))
    assert done.returncode == 4
    assert done.stdout.startswith("the same bytes: 278 messages of 4 channels, 2 commands"), done.stdout
    assert done.stderr == f"{killed}: was cut off at 1 s, as by a kill; its messages up to there are compared\n"
    whole = uwsim("replay", str(finished))
    assert whole.returncode == 0 and " and the state at the end" in whole.stdout and not whole.stderr
    empty = tmp_path / "empty.mcap"
    empty.write_bytes(killed.read_bytes()[: chunks(finished)[0].start])
    done = uwsim("replay", str(empty))
    assert done.returncode == 1 and "nothing was compared" in done.stderr and not done.stdout


def test_what_a_full_disk_left_reads_as_cut_off_even_if_there_is_room_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A failed write may leave a partial record: nothing may follow it."""
    path, sim, write = tmp_path / "run.mcap", Simulator("pool"), mcap_sink.McapSink.write

    def full(self: Any, messages: Any) -> None:
        if messages.times_ns[-1] > 5e8:
            self._file.write(b"\x06" + bytes(20))
            raise OSError(28, "No space left on device")
        write(self, messages)

    monkeypatch.setattr(mcap_sink.McapSink, "write", full)
    recorder = Recorder(sim, path, topics=["odom"]).start()
    sim.advance(1.0)
    with pytest.raises(OSError, match="ends early: No space left"):
        recorder.close()
    assert not Recording(path).complete
    assert path.read_bytes()[-len(MAGIC) :] != MAGIC


SIZE = 100_000_000
PACKED = {"lz4": lz4.frame.compress(bytes(SIZE)), "zstd": zstandard.compress(bytes(SIZE)), "": bytes(1000)}


def chunk(compression: str, stated: int, data: bytes | None = None) -> Chunk:
    return Chunk(
        compression=compression, data=PACKED[compression] if data is None else data, message_end_time=0,
        message_start_time=0, uncompressed_crc=0, uncompressed_size=stated,
    )  # fmt: skip


@pytest.mark.parametrize("compression", PACKED)
def test_a_chunk_that_holds_more_than_it_states_is_not_unpacked(compression: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"not 999$"):
            unpacked(chunk(compression, 999))
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_a_size_beyond_what_its_bytes_may_hold_is_refused_before() -> None:
    data = PACKED["zstd"]
    most = FREE_BYTES + BYTES_PER_BYTE * len(data)
    with pytest.raises(ValueError, match=f"its size of {SIZE:,} bytes is too large: must be at most {most:,}"):
        unpacked(chunk("zstd", SIZE, data))


@pytest.mark.parametrize("compression", PACKED)
def test_whole_and_cut_off_chunks(compression: str) -> None:
    content = bytes(range(256)) * 40
    data = {"lz4": lz4.frame.compress, "zstd": zstandard.compress, "": bytes}[compression](content)
    assert unpacked(chunk(compression, len(content), data)) == content
    with pytest.raises(ValueError, match=r"it holds|it cannot be decompressed"):
        unpacked(chunk(compression, len(content), data[:-9]))
