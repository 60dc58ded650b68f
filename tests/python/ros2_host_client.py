"""A client of ROS 2 on a host of its own: `ros2_host_client.py dds|zenoh DOMAIN` prints whether a call succeeded."""

import json
import struct
import sys
import time

from uwsim.bridges.ros2 import Ros2Settings
from uwsim.bridges.ros2.zenoh_names import Entity
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes
from uwsim.channels.ros.service_types import load_service_types

NAME, TYPE = "lights/front", "std_srvs/srv/SetBool"
LOOK_S, PATIENCE_S = 0.2, 30.0


def by_dds(domain: int) -> bool:
    """Call as rmw_cyclonedds does."""
    from ros2_tools import peer

    with peer(Ros2Settings(domain_id=domain, reach="subnet")) as other:
        return bool(other.call(NAME, TYPE, data=True).success)


def by_zenoh(domain: int) -> bool:
    """Call as rmw_zenoh does, through a router on this host."""
    import zenoh

    def session(**values: object) -> zenoh.Session:
        config = zenoh.Config()
        for key, value in {"scouting/multicast/enabled": False, "timestamping/enabled": True, **values}.items():
            config.insert_json5(key, json.dumps(value))
        return zenoh.open(config)

    key = Entity("SC", Ros2Settings(domain_id=domain, rmw="zenoh"), "", 0, "", NAME, TYPE).key
    asked = bytes(encode(build.message(f"{TYPE}_Request", data=True)))
    attached = struct.pack("<qqB16s", 1, 0, 16, bytes(range(16)))
    own = {"connect/endpoints": ["tcp/127.0.0.1:7447"], "listen/endpoints": ["tcp/127.0.0.1:0"]}
    with (
        session(mode="router", **{"listen/endpoints": ["tcp/0.0.0.0:7447"]}),
        session(mode="peer", **own) as peer,
    ):
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            for reply in peer.get(key, payload=asked, attachment=attached, target=zenoh.QueryTarget.ALL_COMPLETE):
                return bool(from_bytes(reply.ok.payload.to_bytes(), f"{TYPE}_Response").success)
            time.sleep(LOOK_S)
    return False


if __name__ == "__main__":
    load_service_types()
    sys.stdout.write(f"{ {'dds': by_dds, 'zenoh': by_zenoh}[sys.argv[1]](int(sys.argv[2])) }\n")
