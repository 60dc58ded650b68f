"""Bounds of a dialler: of the datagrams that are read at once, and of what waits for a server."""

import asyncio
import socket

import pytest

from uwsim.bridges.doors.conversation import first_of
from uwsim.bridges.doors.datagrams import AT_ONCE, Datagrams
from uwsim.bridges.doors.streams import UNSENT_BYTES, Stream


def test_datagrams_are_read_in_turns_with_what_is_sent() -> None:
    with Datagrams(("127.0.0.1", 0)) as here, Datagrams(to=(here.host, here.port)) as there:
        for number in range(3 * AT_ONCE):
            there.send(bytes([number]))
        turns = [[data[0] for data, _ in here.received()] for _ in range(2)]
        assert turns == [list(range(AT_ONCE)), list(range(AT_ONCE, 2 * AT_ONCE))]
        spoken: list[int] = []

        async def listen() -> None:
            for number in range(2 * AT_ONCE, 3 * AT_ONCE):
                assert (await here.read())[0][0] == number

        async def speak() -> None:
            while True:
                spoken.append(await asyncio.sleep(0, 1))

        asyncio.run(first_of(listen(), speak()))
        assert len(spoken) >= AT_ONCE - 1


def test_a_server_that_does_not_read_is_given_up_and_one_that_reads_late_gets_all() -> None:
    here, there = socket.socketpair()
    packet, count = bytes(range(256)) * 256, UNSENT_BYTES >> 16

    async def send() -> None:
        stream = Stream(*await asyncio.open_connection(sock=here))
        for _ in range(count):
            stream.send(packet)
        got = bytearray()
        while len(got) < count * len(packet):
            got += await asyncio.get_running_loop().sock_recv(there, 1 << 20)
        assert got == packet * count
        with pytest.raises(OSError, match="does not read"):
            for _ in range(10 * count):
                stream.send(packet)

    with there:
        there.setblocking(False)
        asyncio.run(send())
