"""IMC's wire against LSTS's own code, imcpy, and packets that it wrote; the parser against damaged bytes."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from counted_work import assert_linear
from uwsim.bridges.imc.crc import after_zeros, crc16, sums
from uwsim.bridges.imc.wire import FORMATS, NO_SYSTEM, SYNC, ImcError, Message, PacketReader, decoded, encoded


def some(kind: str, rng: np.random.Generator) -> Any:
    """Return a value of a kind of field."""
    if kind in "fd":
        return float(np.float32(rng.normal()))
    if kind in "sr":
        text = "".join(rng.choice([*"abc;=1"], 5))
        return text if kind == "s" else text.encode()
    if kind == "l":
        return []
    return int(rng.integers(0, {"B": 255, "H": 65535, "I": 2**31, "h": 32767, "i": 2**31}[kind]))


def examples() -> Iterator[Message]:
    rng = np.random.default_rng(1)
    for name, (_, fields) in FORMATS.items():
        content = {field: some(kind, rng) for field, kind in fields}
        if name == "SonarData":
            content["beam_config"] = [("BeamConfig", {"beam_width": 0.5, "beam_height": -1.0})]
        yield Message(name, content, 0x001E, 3, 1234.5, 0x4101, 7)


def test_the_check_sum_is_the_published_one() -> None:
    assert crc16(b"123456789") == 0xBB3D  # CRC-16/ARC in the catalogue of Cook


def test_messages_are_read_as_they_were_written() -> None:
    for message in examples():
        assert decoded(encoded(message)) == message


def test_lstss_own_code_reads_and_writes_the_same_bytes() -> None:
    imcpy = pytest.importorskip("imcpy", reason="needs imcpy, LSTS's C++ code of IMC for Python")
    for message in examples():
        theirs = imcpy.Packet.deserialize(encoded(message))
        assert type(theirs).__name__ == message.name
        for field, value in message.content.items():
            if not isinstance(value, list):
                assert getattr(theirs, field) == value
        assert decoded(bytes(imcpy.Packet.serialize(theirs))) == message


def test_packets_written_by_lstss_own_code_are_read_and_written_alike() -> None:
    """The packets are imcpy 1.1.2's."""
    packets = json.loads((Path(__file__).parents[1] / "data/imc/packets.json").read_text())
    assert {each["name"] for each in packets} == FORMATS.keys()
    for each in packets:
        packet = bytes.fromhex(each["bytes"])
        found = decoded(packet)
        plain = {name: value for name, value in found.content.items() if not isinstance(value, (list, bytes))}
        assert (found.name, plain) == (each["name"], each["content"])
        assert encoded(found) == packet
    (sonar,) = (decoded(bytes.fromhex(each["bytes"])) for each in packets if each["name"] == "SonarData")
    assert sonar.content["beam_config"] == [("BeamConfig", {"beam_width": 0.5, "beam_height": -1.0})]


def test_a_sender_with_the_other_byte_order_is_understood() -> None:
    packet = bytes.fromhex("fe54 012d 0005 409348a000000000 00d1 09 ffff ff 00 3f000000")
    found = decoded(packet + crc16(packet).to_bytes(2, "big"))
    assert found == Message("SetThrusterActuation", {"id": 0, "value": 0.5}, 0xD1, 9, 1234.15625, NO_SYSTEM, 255)


def test_packets_are_found_however_the_bytes_are_divided_and_behind_damaged_ones() -> None:
    sent = list(examples())
    damaged = bytearray(encoded(sent[0]))
    damaged[-1] ^= 1
    data = b"\x54junk" + bytes(damaged) + b"".join(map(encoded, sent))
    for size in (1, 7, 100, len(data)):
        reader = PacketReader()
        assert [m for k in range(0, len(data), size) for m in reader.read(data[k : k + size])] == sent
    with pytest.raises(ImcError, match="is it IMC"):
        list(PacketReader().read(b"x" * 200_000))


def nested(count: int, *, is_valid: bool) -> bytes:
    """Return so many beginnings of packets, all of which end at the last one's end, with valid check sums or without.

    A valid packet is damaged by its content alone: an EntityList whose text is longer than the packet.
    """
    head, data = 10, b"\xff" * 40
    for _ in range(count):
        packet = SYNC + (5).to_bytes(2, "little") + (len(data) + head - 20).to_bytes(2, "little") + b"\xff" * 4 + data
        data = packet + (crc16(packet).to_bytes(2, "little") if is_valid else b"")
    return data


@pytest.mark.parametrize("is_valid", [False, True])
@pytest.mark.parametrize("part", [7, 1 << 20])
def test_the_work_is_in_proportion_to_the_bytes_whatever_they_are(is_valid: bool, part: int) -> None:
    def read(data: bytes) -> None:
        reader = PacketReader()
        found = [m for k in range(0, len(data), part) for m in reader.read(data[k : k + part])]
        assert [each.name for each in found] == ["Heartbeat"]

    end = encoded(Message("Heartbeat", {}))
    assert_linear(read, lambda count: nested(count, is_valid=is_valid) + end, 40)


def test_the_check_sum_of_a_stretch_follows_from_those_of_its_ends() -> None:
    data = bytes(np.random.default_rng(1).integers(0, 256, 70_000, np.uint8))
    before = [0, *sums(data, 0)]
    for begin, end in ((0, 70_000), (1, 69_999), (20_000, 20_000), (313, 65_868)):
        assert before[end] ^ after_zeros(before[begin], end - begin) == crc16(data[begin:end])


def test_damaged_packets_are_refused_and_never_raise_anything_else() -> None:
    rng = np.random.default_rng(1)
    whole = encoded(next(each for each in examples() if each.name == "SonarData"))
    refused = 0
    for _ in range(3000):
        damaged = bytearray(whole[:-2])
        for at in rng.integers(4, len(damaged), 3):
            damaged[at] = rng.integers(0, 256)
        try:
            decoded(bytes(damaged) + crc16(bytes(damaged)).to_bytes(2, "little"))
        except ImcError:
            refused += 1
    assert 500 < refused < 3000


def test_a_message_that_does_not_fit_is_refused() -> None:
    for name, content in (("Depth", {"depth": 1.0}), ("Depths", {}), ("Rpm", {"value": 70000}),
                          ("EntityList", {"list": "x" * 70000})):  # fmt: skip
        with pytest.raises(ImcError, match=name):
            encoded(Message(name, content))
