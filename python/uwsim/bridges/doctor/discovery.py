"""Finds the participants in a ROS 2 domain, by joining it for a while and listening."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant, BuiltinTopicDcpsPublication
from cyclonedds.qos import Policy

from uwsim.bridges.doctor import Finding
from uwsim.bridges.ros2.dds import Participant, RawReader
from uwsim.bridges.ros2.graph import ENTITIES, ENTITIES_TOPIC
from uwsim.bridges.ros2.qos import reader_qos
from uwsim.bridges.ros2.settings import PARTICIPANTS_MAX, SAFE_DOMAIN_MAX, Ros2Settings, unicast_port
from uwsim.channels.ros.cdr import Distro, store_of

LOOK_S = 0.05
LOCALHOST_ADVICE = "export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST (Humble: ROS_LOCALHOST_ONLY=1) on the side of ROS"


def discovery(settings: Ros2Settings, listen_s: float) -> list[Finding]:
    """Join the domain for listen_s; return findings about its participants and their ROS 2 distributions."""
    domain, ports = settings.domain_id, udp_ports()
    here = participants_here(domain, ports)
    others = {number: participants_here(number, ports) for number in range(SAFE_DOMAIN_MAX + 1) if number != domain}
    elsewhere = [str(number) for number, count in others.items() if count]
    try:
        heard, nodes, hashed = _listen(settings, listen_s)
    except OSError as error:
        return [Finding(f"domain {domain}", str(error), "wrong", "look at the interface and at CYCLONEDDS_URI")]
    what = f"domain {domain}"
    found = [_presence(what, settings, here, heard, elsewhere)]
    if nodes:
        named = ", ".join(f"{name} ({distro})" for name, distro in sorted(nodes.items()))
        found.append(_speech("nodes", named, settings, set(nodes.values())))
    elif heard:
        theirs: set[Distro] = {"jazzy"} if hashed else {"humble"}
        found.append(_speech("nodes", "none report their names", settings, theirs))
    return found


def _presence(what: str, settings: Ros2Settings, here: int, heard: int, elsewhere: list[str]) -> Finding:
    found = f"{heard} participants answer, {here} are on this machine"
    if here > heard and settings.reach == "localhost":
        return Finding(what, found, "wrong", f"the others do not answer: {LOCALHOST_ADVICE}; or --ros-reach subnet")
    if here > heard:
        return Finding(what, found, "wrong", "they may be set to localhost: --ros-reach localhost here")
    if not heard and elsewhere:
        where = ", ".join(elsewhere[:8])
        advice = "give both sides the same ROS_DOMAIN_ID"
        return Finding(what, f"none; but there are participants in {where}", "wrong", advice)
    if not heard:
        return Finding(what, "no other participant", "note", "start a node of ROS and look again")
    return Finding(what, found)


def _speech(what: str, found: str, settings: Ros2Settings, theirs: set[Distro]) -> Finding:
    if settings.distro in theirs:
        return Finding(what, found)
    return Finding(what, found, "wrong", f"uwsim serve --ros2 --ros-distro {min(theirs)}")


def _listen(settings: Ros2Settings, listen_s: float) -> tuple[int, dict[str, Distro], bool]:
    """Return the number of other participants, their nodes by name, and whether any use type hashes (Jazzy)."""
    participants = {distro: Participant(replace(settings, distro=distro), b"") for distro in get_args(Distro)}
    try:
        ours = {participant.guid for participant in participants.values()}
        latched = reader_qos(100, reliable=True, user_data=b"", latched=True)
        graphs = {distro: p.reader(ENTITIES_TOPIC, ENTITIES, latched) for distro, p in participants.items()}
        present = BuiltinDataReader(participants["jazzy"].entity, BuiltinTopicDcpsParticipant)
        writers = BuiltinDataReader(participants["jazzy"].entity, BuiltinTopicDcpsPublication)
        nodes: dict[str, Distro] = {}
        end = time.monotonic() + listen_s
        while time.monotonic() < end:
            for distro, reader in graphs.items():
                nodes |= dict.fromkeys(_names(reader, distro), distro)
            time.sleep(LOOK_S)
        others = {sample.key.bytes for sample in present.read(1000) if hasattr(sample, "key")} - ours
        hashed = any(b"typehash=" in _user_data(sample) for sample in writers.read(1000) if hasattr(sample, "qos"))
        return len(others), nodes, hashed
    finally:
        for participant in participants.values():
            participant.close()


def _names(reader: RawReader, distro: Distro) -> list[str]:
    found = []
    for data in reader.take(100):
        info: Any = store_of(distro).deserialize_cdr(data, ENTITIES)
        found += [f"{node.node_namespace.rstrip('/')}/{node.node_name}" for node in info.node_entities_info_seq]
    return found


def _user_data(sample: Any) -> bytes:
    return bytes(sample.qos[Policy.Userdata].data) if Policy.Userdata in sample.qos else b""


def udp_ports() -> set[int]:
    """Return the UDP ports in use on this machine."""
    found = set()
    for name in ("udp", "udp6"):
        try:
            lines = Path(f"/proc/net/{name}").read_text().splitlines()[1:]
        except OSError:
            continue
        found |= {int(line.split()[1].rpartition(":")[2], 16) for line in lines}
    return found


def participants_here(domain_id: int, ports: set[int]) -> int:
    """Return the number of a domain's participants on this machine, as inferred from the ports in use."""
    return sum(unicast_port(domain_id, number) in ports for number in range(PARTICIPANTS_MAX))
