"""A client of the rosbridge protocol without a transport, for tests."""

import json

import cbor2

from uwsim.bridges.rosbridge.session import Session


class Client:
    """A session and the frames it has sent."""

    def __init__(self, graph, name="/client", **options):
        self.now_s = 0.0
        self.given_up = ""
        self.session = Session(graph, name, clock=lambda: self.now_s, give_up=self.give_up, **options)

    def give_up(self, reason):
        self.given_up = reason

    def send(self, op=None, **fields):
        self.session.receive(json.dumps({"op": op, **fields}) if op else fields["frame"])
        return self

    def frames(self):
        found = []
        while (frame := self.session.outbox.take()[0]) is not None:
            found.append(frame)
        return found

    def received(self):
        return [cbor2.loads(frame) if isinstance(frame, bytes) else json.loads(frame) for frame in self.frames()]

    def texts(self):
        return [operation["msg"]["data"] for operation in self.received()]

    def complaint(self):
        (status,) = self.received()
        assert (status["op"], status["level"]) == ("status", "error")
        return status["msg"]
