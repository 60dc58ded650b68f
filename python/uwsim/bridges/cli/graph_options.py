"""Options of live commands about what the graph's other nodes see, and the file of parameters to set at the start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Options, option

if TYPE_CHECKING:
    from uwsim.simulator.simulator import Simulator

OF_A_NODE = "ros__parameters"
OF_THE_CLOCK = "use_sim_time"


@dataclass(frozen=True)
class GraphOptions(Options):
    """The transforms and topics beyond the usual ones, and the parameters to set before the start."""

    tf_rate: float | None = option(
        None, "Rate of /tf, such as 200 for the IMU's. Default: 50.", bounds=(0.1, 10_000, "Hz")
    )
    joint_frames: bool = option(
        False,
        "Also publish on /tf the frames that only /robot_description has, as robot_state_publisher would: cameras' pan "
        "and tilt, thrusters, fins. RViz needs them to draw the vehicle.",
    )
    thruster_topics: bool = option(
        False, "Also offer /thrusters/NAME/command and /thrusters/NAME/force, a Float64 without a time for each."
    )
    params_file: Path | None = option(
        None, "YAML file of parameters to set before the start, by name, also in ROS 2's form for the node /uwsim."
    )

    @property
    def is_about_topics(self) -> bool:
        """True if topics or frames differ from the usual ones."""
        return self.tf_rate is not None or self.joint_frames or self.thruster_topics

    @property
    def of_table(self) -> dict[str, Any]:
        """The arguments for a Table."""
        rate = {} if self.tf_rate is None else {"tf_rate_hz": self.tf_rate}
        return {**rate, "joint_frames": self.joint_frames, "thruster_topics": self.thruster_topics}

    def parameters(self, node: str) -> dict[str, Any]:
        """Return the file's parameters for the node with this full name; nested keys stand for names with dots.

        Raises ValueError.
        """
        if self.params_file is None:
            return {}
        from uwsim.base.texts.yaml_document import read_yaml

        values = read_yaml(self.params_file).values
        if any(isinstance(each, Mapping) and OF_A_NODE in each for each in values.values()):
            ours = {"/**", "/**/uwsim", node, f"/{node}", *(() if "/" in node else ("uwsim",))}
            parts = [each[OF_A_NODE] for name, each in values.items() if name in ours and OF_A_NODE in (each or {})]
            if not parts or not all(isinstance(part, Mapping) for part in parts):
                raise ValueError(f"--params-file {self.params_file}: must have '{OF_A_NODE}' for the node /{node}")
            values = {name: value for part in parts for name, value in part.items()}
        return {name: value for name, value in values.items() if name != OF_THE_CLOCK}

    def apply(self, parameters: Mapping[str, Any], sim: Simulator) -> None:
        """Set the file's parameters. Raises ValueError, changing nothing."""
        try:
            if parameters:  # an empty change would stand in the log
                sim.parameters.update(parameters)
        except ValueError as error:
            raise ValueError(f"--params-file {self.params_file}: {error}") from None


@dataclass(frozen=True)
class ServedGraphOptions(GraphOptions):
    """Those of a server, which may offer actions."""

    no_actions: bool = option(
        False, "Do not offer actions: /navigate_to_pose, which Nav2 has itself, /fly_path and those of arms."
    )
