"""The actions of a station's page, performed without a browser."""

import http.client
import json
import time
from contextlib import contextmanager

import cbor2
from websockets.sync.client import connect

from uwsim.bridges import RosbridgeServer
from uwsim.channels.ros.messages import typed_array
from uwsim.operator.station import Site, Station
from uwsim.operator.station.wire.calls import CALLS
from uwsim.operator.station.wire.messages import Refused

PATIENCE_S = 180.0


class Page:
    """Stand-in for a browser page: sends and receives the same messages."""

    def __init__(self, socket):
        self.socket, self.count, self.heard = socket, 0, []
        self.meanwhile = []  # messages received while waiting for the last call's response

    def send(self, op, **fields):
        self.socket.send(json.dumps({"op": op, **fields}))

    def call(self, service, **args):
        """Call a service of the station and check the response against the wire description."""
        self.count += 1
        began = len(self.heard)
        self.send("call_service", service=f"/station/{service}", args=args, id=str(self.count))
        answer = self.next(lambda o: o.get("id") == str(self.count))
        self.meanwhile = self.heard[began:]
        if service in CALLS and answer["result"]:
            require_described(CALLS[service], answer["values"])
        return answer["values"]

    def next(self, wanted):
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            frame = self.socket.recv(PATIENCE_S)
            operation = cbor2.loads(frame, tag_hook=tagged) if isinstance(frame, bytes) else json.loads(frame)
            self.heard.append(operation)
            if wanted(operation):
                return operation
        raise TimeoutError

    def subscribe(self, topic, **options):
        self.send("subscribe", topic=topic, compression="cbor", **options)

    def message(self, topic, wanted=lambda message: True):
        def is_it(operation):
            return operation.get("topic") == topic and wanted(operation["msg"])

        meanwhile, self.meanwhile = self.meanwhile, []
        return (next(filter(is_it, meanwhile), None) or self.next(is_it))["msg"]


def require_described(call, values):
    """Check that a response has exactly the fields in the wire description, with the right types."""
    described = Refused if values.get("success") is False else call.answer
    described.model_validate(values)


def tagged(*arguments):
    return typed_array(next(a for a in arguments if isinstance(a, cbor2.CBORTag)))


@contextmanager
def serving(folder=None, **options):
    station = Station(folder=folder, **options)
    with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
        yield station, server


@contextmanager
def page(server, name="Ada"):
    with connect(server.url, compression=None, max_size=None) as socket:
        found = Page(socket)
        found.id = found.call("join", name=name)["id"]
        yield found


def get(server, path, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE_S)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for key, value in headers.items():
        connection.putheader(key.replace("_", "-"), value)
    connection.endheaders()
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response.status, body, response.headers
