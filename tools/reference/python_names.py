"""The Python reference: the public names, from their docstrings."""

PUBLIC = {
    "The simulator": [
        "uwsim.simulator.Simulator",
        "uwsim.vehicle.Vehicle",
        "uwsim.motion.Pose",
        "uwsim.motion.Velocity",
    ],
    "Sensors": ["uwsim.sensors.Sensor", "uwsim.sensors.Sample", "uwsim.sample_stream"],
    "Scenarios": ["uwsim.scenario_check"],
    "Missions and surveys": [
        "uwsim.missions",
        "uwsim.flight.fly.fly()",
        "uwsim.flight.record.FlightRecord",
        "uwsim.flight.remote.fly_remote()",
        "uwsim.flight.survey.run_survey()",
    ],
    "Planners": [
        f"uwsim.missions.planners.{name}()"
        for name in (
            "boustrophedon.mow_area",
            "unknown_water.mow_unknown_water",
            "frontier.explore",
            "pipeline.follow_pipeline",
            "gate.pass_gate",
            "wall.scan_wall",
            "map_way.go_by_map",
            "curves.fly_through",
            "twin.make_twin",
        )
    ],
    "Control": ["uwsim.control.Controller", "uwsim.control.PathFollower"],
    "Estimation": ["uwsim.estimation.Navigator"],
    "Readings": ["uwsim.readings"],
    "Sonar": ["uwsim.sonars.multibeam.Sonar", "uwsim._core.Ping", "uwsim.sonars.imaging", "uwsim.ranging"],
    "Cameras": ["uwsim.cameras.camera.Camera", "uwsim.cameras.frame.Frame", "uwsim.cameras.lamp.Lamp"],
    "Maps": ["uwsim.mapping.occupancy_map.OccupancyMap", "uwsim.mapping.changes.map_changes()"],
    "Parameters": ["uwsim.parameters.Parameters"],
    "Faults": ["uwsim.failures.faults.Faults", "uwsim.failures.events.EventLog"],
    "Link": ["uwsim.network.Network"],
    "Many at once": [
        "uwsim.batch.Batch",
        "uwsim.batch.BatchMotion",
        "uwsim.batch.BatchSamples",
        "uwsim.batch.BatchPings",
        "uwsim.batch.BatchPhysicsPings",
        "uwsim.batch.MemberAboard",
    ],
    "Learning": [
        "uwsim.learning.lone_env.LoneEnv",
        "uwsim.learning.vector_env.BatchEnv",
        "uwsim.learning.options.EpisodeOptions",
        "uwsim.learning.task.Task",
        "uwsim.learning.tasks",
        "uwsim.learning.policy.LinearPolicy",
    ],
    "Sweeps and fleets": ["uwsim.sweeps", "uwsim.fleet"],
    "On the wall clock": ["uwsim.live.LiveSimulator", "uwsim.live.replay()", "uwsim.bridges.RosbridgeServer"],
    "Recordings": ["uwsim.recording.Recorder", "uwsim.recording.open()"],
}

HEAD = """# Python

**Public**: the names on this page, and what `import uwsim` gives (`uwsim.Simulator`, `uwsim.Batch`, `uwsim.fly`,
`uwsim.run_survey`, `uwsim.scenarios`). A change of them is in the changelog, and comes with a new minor version.

**Internal**: everything else, `uwsim._core` and what begins with an underscore above all. It may change in any release.
"""


def python_page() -> str:
    """Return the page: directives by which the site reads the docstrings."""
    text = HEAD
    for title, names in PUBLIC.items():
        text += f"\n## {title}\n\n```{{eval-rst}}\n"
        for name in names:
            text += _directive(name)
        text += "```\n"
    return text


def _directive(name: str) -> str:
    if name.endswith("()"):
        return f".. autofunction:: {name.removesuffix('()')}\n\n"
    kind = "automodule" if name.rpartition(".")[2][0].islower() else "autoclass"
    return f".. {kind}:: {name}\n   :members:\n\n"
