"""The endpoints that options state: seven protocols read the same form, and refuse what is not theirs in one line."""

import re
from collections.abc import Callable

import pytest

from uwsim.bridges.a50.plug import A50Plug
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.imc.link import parsed
from uwsim.bridges.mavlink import endpoint as mavlink
from uwsim.bridges.moos import client as moos
from uwsim.bridges.nmea import wire as nmea
from uwsim.bridges.ping_protocol.plug import Ping1dPlug
from uwsim.bridges.video import video

PARSERS: dict[str, Callable[[str], Endpoint]] = {
    "nmea": nmea.FORM.parse, "mavlink": mavlink.FORM.parse, "video": video.FORM.parse, "moos": moos.FORM.parse,
    "imc": parsed, "dvl_a50": A50Plug.form.parse, "ping1d": Ping1dPlug.form.parse,
}  # fmt: skip
FOUND = {
    "nmea": {"udp": ("127.0.0.1", 10110, "udp", ""), "tcp:0.0.0.0:0": ("0.0.0.0", 0, "tcp", "")},
    "mavlink": {"udpin": ("127.0.0.1", 14550, "udpin", ""), "tcp:a.b:7": ("a.b", 7, "tcp", "")},
    "video": {"5600": ("127.0.0.1", 5600, "", ""), "h:1": ("h", 1, "", "")},
    "moos": {"localhost:9001": ("localhost", 9001, "", ""), "henry=host": ("host", 9000, "", "henry")},
    "imc": {"host": ("host", 6002, "tcp", ""), "a=udp:10.0.0.2:7001": ("10.0.0.2", 7001, "udp", "a")},
    "dvl_a50": {"0": ("127.0.0.1", 0, "", ""), "rov/dvl=h:7": ("h", 7, "", "rov/dvl")},
    "ping1d": {"udp": ("127.0.0.1", 9090, "udp", ""), "pty": ("127.0.0.1", 0, "pty", ""),
               "rov/altitude=udp:10.0.0.2:7": ("10.0.0.2", 7, "udp", "rov/altitude")},
}  # fmt: skip
REFUSED = {
    "nmea": ["", "127.0.0.1:10110", "udp:a:b:1", "udp:0", "tcp:99999", "a=udp"],
    "mavlink": ["", "serial", "udpin:70000", "tcp:a:b:c", "udpout:1.2.3.4:x", "udpout:0"],
    "video": ["", "0", "70000", "a:b", "127.0.0.1:", "x y:5600", "5600?pkt_size=9"],
    "moos": ["", ":9000", "=host:1", "host:0", "host:99999", "host:port", "a=b=c d:1", "x" * 300],
    "imc": ["", ":9000", "=host:1", "host:0", "host:99999", "host:port", "ftp:host:1", "a=b=c d:1", "announce:host"],
    "dvl_a50": ["", "a", "x:y:1", "70000", "=1", "a b:1"],
    "ping1d": ["tcp:9090", "udp:70000", "=udp", "pty:1", "udp:a..b:1"],
}


@pytest.mark.parametrize("option", PARSERS)
def test_an_endpoint_is_read_or_refused_with_its_form(option: str) -> None:
    for text, found in FOUND[option].items():
        assert PARSERS[option](text) == found
    for text in REFUSED[option]:
        with pytest.raises(ValueError, match=rf"^{option} = '{re.escape(text[:80])}': (must be|announce must have) \S"):
            PARSERS[option](text)
