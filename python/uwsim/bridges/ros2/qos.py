"""The quality of service that ROS 2 readers and writers expect for each kind of topic."""

from __future__ import annotations

from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration

BLOCKING = duration(milliseconds=50)  # how long a write may wait for a slow reader


def writer_qos(depth: int, *, latched: bool, user_data: bytes) -> Qos:
    """Return a reliable QoS, which matches all readers. If latched, it is transient local, to serve late readers."""
    policies = [
        Policy.Reliability.Reliable(BLOCKING),
        Policy.History.KeepLast(depth),
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Userdata(user_data),
    ]
    if latched:
        policies.append(Policy.DurabilityService(0, Policy.History.KeepLast(depth), -1, -1, -1))
    return Qos(*policies)


def reader_qos(depth: int, *, reliable: bool, user_data: bytes, latched: bool = False) -> Qos:
    """Return a reader's QoS. Best effort matches all writers; reliable matches only reliable writers (the default)."""
    return Qos(
        Policy.Reliability.Reliable(BLOCKING) if reliable else Policy.Reliability.BestEffort,
        Policy.History.KeepLast(depth),
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Userdata(user_data),
    )
