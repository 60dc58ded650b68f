"""Quality of service: what ROS 2 readers and writers expect for each kind of topic."""

from __future__ import annotations

from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration

DEPTH = 10  # messages that a reader may lag behind; ROS 2's default
BLOCKING = duration(milliseconds=50)  # time that a write may wait for a slow reader


def writer_qos(depth: int, *, latched: bool, user_data: bytes) -> Qos:
    """Reliable, so that readers of either kind match; transient local if latched, so that late readers get the last."""
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
    """Best effort matches every writer; reliable matches only reliable writers, which ROS's are by default."""
    return Qos(
        Policy.Reliability.Reliable(BLOCKING) if reliable else Policy.Reliability.BestEffort,
        Policy.History.KeepLast(depth),
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Userdata(user_data),
    )
