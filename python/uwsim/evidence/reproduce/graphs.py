"""The transform tree (Fig. 10) and the node map (Fig. 11): the simulator's channels, and what the paper's nodes use."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import networkx as nx

from uwsim.channels import channels
from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.style import FAINT_INK, INK, new_figure, save_figure
from uwsim.simulator.simulator import Simulator

FRAMES = "odom", "base_footprint", "base_scan"
POSES = "propPos", "scanPos"
"""Topics of the poses between FRAMES, which tf2_broadcaster.py and scantfbroadcaster.py send on as transforms."""
NODES = {
    "stringDecoder": (("depthArray", "modelTrigger"), "decodedDepth"),
    "Laser_Scan_Publisher": (("decodedDepth", "modelTrigger", "hFOV"), "scan"),
    "laser2PointCloud": (("scan",), "laserPointCloud"),
    "AUV_Pose_Broadcaster": (("propPos",), "tf"),
    "SCAN_Pose_Broadcaster": (("scanPos",), "tf"),
    "paraPublisher": (("stateData",), "rovParameters"),
    "octomap_server": (("laserPointCloud", "tf"), "octomap_binary"),
    "LawnMower": (("propPos", "decodedDepth", "proximitySensor"), "key"),
}
"""The published nodes, in the folder ROS of their project: the topics that each reads, and what it publishes."""


def transform_tree(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 10, the transform tree."""
    sent = {c.name: c for c in channels(sim, wire="published")}
    rows: list[tuple[Any, ...]] = [
        ("published", *link, sent[topic].rate_hz) for link, topic in zip(pairwise(FRAMES), POSES, strict=True)
    ]
    for channel in channels(sim):
        if channel.name in ("tf", "tf_static"):
            links = [(each.header.frame_id, each.child_frame_id) for each in channel.read(sim).transforms]
            rows += [("standard", *link, channel.rate_hz or "static") for link in links]
    _draw([(row[1], row[2]) for row in rows if row[0] == "standard"], path, (13.0, 6.5))
    return Figure(
        10, "The transform tree", "The frames of the standard topics. The table also has those of the published nodes, "
        "from the poses that the simulator sends them, with the rate of each moving transform.",
        "Theirs has the published tree; ours has the standard topics' tree, too.",
        columns=("wire", "parent", "child", "rate [Hz]"), rows=rows,
    )  # fmt: skip


def node_map(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 11, the node map."""
    topics = channels(sim, wire="published")
    readers = [(name, reader) for reader, (names, _) in NODES.items() for name in names]
    rows = [("simulator", c.name, reader) for c in topics if c.direction == "out"
            for reader in [reader for name, reader in readers if name == c.name] or ["none"]]  # fmt: skip
    taken = {c.name for c in topics if c.direction == "in"}
    for node, (_, topic) in NODES.items():
        to = ["simulator"] if topic in taken else [reader for name, reader in readers if name == topic] or ["none"]
        rows += [(node, topic, reader) for reader in to]
    edges = [edge for sender, topic, reader in rows if reader not in ("none", "simulator")
             for edge in ((sender, topic), (topic, reader))]  # fmt: skip
    _draw([*edges, *((sender, topic) for sender, topic, reader in rows if reader in ("none", "simulator"))], path,
          (15.0, 6.5))  # fmt: skip
    return Figure(
        11, "The node map", "The simulator's topics, and the published nodes that read them, by their sources. Those "
        "on the right have no reader among the nodes, apart from key, which the simulator reads.",
        "Theirs was drawn from a running graph. Their nodes run with our simulator over rosbridge or as ROS 1 nodes.",
        columns=("publisher", "topic", "subscriber"), rows=rows,
    )  # fmt: skip


def _draw(edges: Iterable[tuple[str, str]], path: Path, size_in: tuple[float, float]) -> None:
    """Draw a graph without loops from left to right."""
    graph = nx.DiGraph(edges)
    places: dict[str, tuple[float, float]] = {}
    for layer, names in enumerate(nx.topological_generations(graph)):
        heights = {name: [places[each][1] for each in graph.predecessors(name)] or [0.0] for name in names}
        for slot, name in enumerate(sorted(names, key=lambda name: (-sum(heights[name]) / len(heights[name]), name))):
            places[name] = layer, 0.5 * (len(names) - 1) - slot
    figure = new_figure(*size_in)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    box = {"boxstyle": "round,pad=0.3", "facecolor": "#eef4f8", "edgecolor": INK}
    nx.draw_networkx(
        graph, places, ax=axes, font_size=8, bbox=box, node_size=1200,
        node_color="none", edge_color=FAINT_INK, connectionstyle="arc3,rad=0.08", min_target_margin=30,
    )  # fmt: skip
    axes.margins(0.08)
    axes.set_axis_off()
    save_figure(figure, path)
