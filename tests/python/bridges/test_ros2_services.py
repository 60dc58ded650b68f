"""Services and parameters of the ROS 2 node, as clients with rmw_cyclonedds call them."""

import time
from contextlib import suppress

import pytest

from ros2_tools import free_domain, peer, until
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings, rtps
from uwsim.bridges.ros2.qos import writer_qos
from uwsim.bridges.ros2.rtps_endpoints import Track
from uwsim.bridges.ros2.rtps_participant import RtpsParticipant
from uwsim.channels import Table
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import store_of
from uwsim.channels.ros.messages import typestore
from uwsim.channels.ros.service_messages import request_values, response_message
from uwsim.channels.ros.service_types import SERVICE_TYPES, load_service_types
from uwsim.channels.ros.type_hash import type_hash
from uwsim.live import LiveSimulator

SETTINGS = Ros2Settings(domain_id=free_domain())
TRIGGER, SET_BOOL = "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"
RCL = "rcl_interfaces/srv/"
NUMBER = build.message("uwsim_msgs/msg/NamedNumber", name="nothing", value=0.5)
SERVICE_WRITER = 0x03
SURGE, FOLLOWS = "rov.drag.linear.surge", "rov.sonar.range_max_m"
PUBLISHED = {  # hashes in ROS 2's own type descriptions
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "service_msgs/msg/ServiceEventInfo": "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
    "rcl_interfaces/msg/ParameterEvent": "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204",
    "std_srvs/srv/SetBool_Request": "c62fbb99d94e1b25e8ef9e109f9581956bb1b3361a45a4e5810c36a90d29932e",
    TRIGGER: "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    SET_BOOL: "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    f"{RCL}ListParameters": "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    f"{RCL}GetParameters": "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    f"{RCL}GetParameterTypes": "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
    f"{RCL}DescribeParameters": "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    f"{RCL}SetParameters": "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
    f"{RCL}SetParametersAtomically": "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
}


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("pool") as live:
        yield live


@pytest.fixture(scope="module")
def node(live):
    table = Table(live.simulator)
    with Ros2Node(live, table.channels, table.services, SETTINGS) as node:
        yield node


@pytest.fixture(scope="module")
def other(node):
    with peer(SETTINGS) as other:
        yield other


def parameter(name, **value):
    return build.message(
        "rcl_interfaces/msg/Parameter", name=name, value=build.message("rcl_interfaces/msg/ParameterValue", **value)
    )


def test_type_hashes_are_the_published_ones():
    load_service_types()
    assert {name: type_hash(typestore(), name) for name in PUBLISHED} == {
        name: f"RIHS01_{digest}" for name, digest in PUBLISHED.items()
    }


def test_every_service_has_a_type_and_its_response_a_field_for_each_value(live, node):
    for service in node.services.values():
        assert service.type in SERVICE_TYPES, service.name
    response = response_message("uwsim_msgs/srv/Pace", True, node.services["simulation/pace"].call(live, {}))
    assert response.step_s == live.simulator.step_s
    assert response_message(TRIGGER, False, "the reason").message == "the reason"


def test_optional_fields_and_numbers_by_name_become_plain_values():
    load_service_types()
    thrusters = build.message("uwsim_msgs/srv/SetThrusters_Request", commands=[NUMBER])
    assert request_values("uwsim_msgs/srv/SetThrusters", thrusters) == {"commands": {"nothing": 0.5}}
    stream = build.message("uwsim_msgs/srv/SetStream_Request", rate_hz=[2.0])
    assert request_values("uwsim_msgs/srv/SetStream", stream) == {"rate_hz": 2.0}


def test_services_respond_with_success_or_the_reason_for_a_refusal(other, live):
    assert other.call("lights/front", SET_BOOL, data=True).success
    assert live.rov.lamps["front"].on
    refused = other.call("simulation/set_speed", "uwsim_msgs/srv/SetSpeed", speed=-1.0)
    assert not refused.success and "speed = -1" in refused.message
    unknown = other.call("set_thrusters", "uwsim_msgs/srv/SetThrusters", commands=[NUMBER])
    assert not unknown.success and "nothing" in unknown.message


def test_parameters_are_listed_read_described_and_set_and_each_change_is_published(other, live):
    def call(name, **request):
        kind = "".join(part.capitalize() for part in name.split("_"))
        return other.call(f"uwsim/{name}", f"{RCL}{kind}", **request)

    other.listen("parameter_events", "rcl_interfaces/msg/ParameterEvent")
    listed = call("list_parameters").result
    assert listed.names == list(live.simulator.parameters) and "rov.drag.linear" in listed.prefixes
    drag = call("list_parameters", prefixes=["rov.drag.linear"], depth=1).result.names
    assert SURGE in drag and len(drag) == 6
    assert call("list_parameters", prefixes=["rov.dr"]).result.names == []
    known, unknown = call("get_parameters", names=[SURGE, "rov.nothing"]).values
    assert (known.type, known.double_value, unknown.type) == (3, live.simulator.parameters[SURGE], 0)
    assert call("get_parameter_types", names=[SURGE, "rov.lamps.front.on"]).types.tolist() == [3, 1]
    (described,) = call("describe_parameters", names=[SURGE]).descriptors
    assert described.floating_point_range[0].from_value == 0.0 and "[N s/m]" in described.description
    good, bad = (parameter(SURGE, type=3, double_value=value) for value in (33.0, -1.0))
    first, second = call("set_parameters", parameters=[good, bad]).results
    assert first.successful and not second.successful and f"{SURGE} = -1" in second.reason
    assert live.simulator.parameters[SURGE] == 33.0
    event = until(lambda: other.heard("parameter_events"), "an event")[0]
    assert event.node == "/uwsim" and event.changed_parameters[0].name == SURGE
    friction = parameter("rov.friction", type=3, double_value=0.7)
    assert not call("set_parameters_atomically", parameters=[friction, bad]).result.successful
    assert live.simulator.parameters["rov.friction"] != 0.7, "all or none"
    follows = call("get_parameters", names=[FOLLOWS]).values[0]  # from the sonar's model: it cannot be changed
    same = build.message("rcl_interfaces/msg/Parameter", name=FOLLOWS, value=follows)
    assert [one.successful for one in call("set_parameters", parameters=[same, bad, friction]).results] == [1, 0, 1]
    assert live.simulator.parameters["rov.friction"] == 0.7


def test_humble_s_types_have_services_too_even_if_they_were_in_use_before(live):
    store_of("humble")
    settings = Ros2Settings("humble", domain_id=free_domain())
    with Ros2Node(live, [], Table(live.simulator).services, settings), peer(settings) as other:
        assert not other.call("set_fins", "uwsim_msgs/srv/SetFins", angles_rad=[NUMBER]).success


def test_a_response_waits_for_a_client_whose_heartbeats_were_lost(node, monkeypatch):
    """A client's reader skips all responses before the first heartbeat that reaches it."""
    send, lost = RtpsParticipant._send, []

    def lossy(participant, address, prefix, submessage):
        if submessage[0] == rtps.HEARTBEAT and submessage[11] == SERVICE_WRITER and len(lost) < 3:
            lost.append(submessage)
        else:
            send(participant, address, prefix, submessage)

    monkeypatch.setattr(RtpsParticipant, "_send", lossy)
    with peer(SETTINGS) as new:
        assert new.call("lights/front", SET_BOOL, data=False).success
    assert len(lost) == 3


def test_a_participant_met_again_is_asked_for_its_endpoints(other, node):
    qos = writer_qos(1, latched=False, user_data=b"")
    client = other.participant.writer("rq/lights/frontRequest", "std_srvs/srv/SetBool_Request", qos)
    peers = node._transport._services._peers
    until(lambda: any(peer.clients for peer in list(peers.values())), "a client was not announced")
    time.sleep(0.3)  # until it has received our acknowledgement, after which it announces no more by itself
    peers.clear()  # as after an interruption longer than the lease
    until(lambda: any(peer.clients for peer in list(peers.values())), "a client was not announced again")
    assert client.readers() == 1


def test_a_new_client_is_asked_for_requests_that_came_before_its_announcement(other, node, monkeypatch):
    """Fast DDS would send them again after 3 s."""
    send, sent, ours = RtpsParticipant._send, [], bytes(12)

    def watched(participant, address, prefix, submessage):
        sent.extend(one.submessage for one in rtps.read(rtps.header(ours, bytes(2)) + submessage, ours))
        send(participant, address, prefix, submessage)

    monkeypatch.setattr(RtpsParticipant, "_send", watched)
    qos = writer_qos(1, latched=False, user_data=b"")
    client = other.participant.writer("rq/lights/downRequest", "std_srvs/srv/SetBool_Request", qos)
    asked = (client.guid[12:], (1,))
    until(lambda: asked in [(one.writer, one.numbers) for one in sent if isinstance(one, rtps.Missing)], "a request")


def test_submessages_of_several_participants_may_share_a_message():
    first, second, writer = b"\1\x10" + bytes(9) + b"\1", b"\1\x10" + bytes(9) + b"\2", b"\0\0\1\3"
    beats = [rtps.heartbeat(rtps.UNKNOWN, writer, 1, last, last) for last in (5, 6)]
    source = bytes([rtps.INFO_SRC, 1, 20, 0]) + bytes(4) + b"\2\5\1\x10" + second  # section 8.3.8.12
    found = rtps.read(rtps.header(first, b"\1\x10") + beats[0] + source + beats[1], first)
    assert [(one.prefix, one.submessage.last) for one in found] == [(first, 5), (second, 6)]


def test_a_damaged_packet_is_refused_and_a_sample_is_counted_once():
    prefix, writer = b"\1\x0f" + bytes(10), b"\0\0\1\3"
    parts = [*rtps.data(rtps.UNKNOWN, writer, 7, bytes(8), rtps.parameters([(0x83, bytes(24))]))]
    parts += [rtps.heartbeat(rtps.UNKNOWN, writer, 3, 9, 1), rtps.missing(rtps.UNKNOWN, writer, 40, [41, 90], 2)]
    packet = rtps.header(prefix, b"\1\x0f") + rtps.to_participant(bytes(12)) + b"".join(parts)
    found = rtps.read(packet, prefix)
    assert {(vendor, sender) for vendor, sender, _ in found} == {(b"\1\x0f", prefix)}
    sample, beat, wanted = (one.submessage for one in found)
    assert (sample.number, sample.payload, sample.qos) == (7, bytes(8), {0x83: bytes(24)})
    assert (beat.first, beat.last, wanted.base, wanted.numbers) == (3, 9, 40, (41, 90))
    for end in range(len(packet)):
        with suppress(ValueError):
            rtps.read(packet[:end], prefix)
    track = Track()
    track.skip_to(3)
    assert [track.add(number) for number in (5, 5, 3, 2)] == [True, False, True, False]
    assert track.base == 4 and track.missing(7) == [4, 6, 7]
