"""The connection that bridges keep up: bounds of what is read and of what waits."""

import socket

import pytest

from uwsim.bridges.aboard.kept_connection import DATAGRAMS_MAX, UNSENT_BYTES, Datagrams, Stream


def test_datagrams_are_read_in_turns_with_what_is_sent() -> None:
    wake, woken = socket.socketpair()
    with wake, woken, socket.socket(type=socket.SOCK_DGRAM) as here, socket.socket(type=socket.SOCK_DGRAM) as there:
        here.bind(("127.0.0.1", 0))
        for number in range(2 * DATAGRAMS_MAX + 1):
            there.sendto(bytes([number]), here.getsockname())
        with Datagrams(here, woken) as link:
            turns = [link.received() for _ in range(4)]
    assert [len(each) for each in turns] == [DATAGRAMS_MAX, DATAGRAMS_MAX, 1, 0]
    assert b"".join(each for turn in turns for each in turn) == bytes(range(2 * DATAGRAMS_MAX + 1))


def test_a_peer_that_does_not_read_is_given_up_and_one_that_reads_late_gets_all() -> None:
    here, there = socket.socketpair()
    wake, woken = socket.socketpair()
    with here, there, wake, woken, Stream(here, woken) as link:
        packet = bytes(range(256)) * 256
        count = UNSENT_BYTES // len(packet)
        for _ in range(count):
            link.send([packet])
        got = bytearray()
        while len(got) < count * len(packet):
            got += there.recv(1 << 20)
            link.send([])
        assert got == packet * count
        with pytest.raises(OSError, match="does not read"):
            for _ in range(10 * count):
                link.send([packet])
