"""The Python reference: the public names, from their docstrings."""

PUBLIC = {
    "The simulator": [
        "uwsim.simulator.Simulator",
        "uwsim.vehicle.Vehicle",
        "uwsim.motion.Pose",
        "uwsim.motion.Velocity",
    ],
    "Sensors": ["uwsim.sensors.Sensor", "uwsim.sensors.Sample", "uwsim.sample_stream"],
    "Missions and surveys": ["uwsim.missions", "uwsim.flight.fly.fly()", "uwsim.survey.run.run_survey()"],
    "Control": ["uwsim.control.Controller", "uwsim.control.PathFollower"],
    "Estimation": ["uwsim.estimation.Navigator"],
    "Readings": ["uwsim.readings"],
    "Sonar": ["uwsim.sonars.multibeam.Sonar", "uwsim._core.Ping", "uwsim.ranging"],
    "Cameras": ["uwsim.cameras.camera.Camera", "uwsim.cameras.frame.Frame", "uwsim.cameras.lamp.Lamp"],
    "Maps": ["uwsim.mapping.occupancy_map.OccupancyMap"],
    "Parameters": ["uwsim.parameters.Parameters"],
    "Many at once": ["uwsim.batch.Batch"],
    "Learning": [
        "uwsim.learning.lone_env.LoneEnv",
        "uwsim.learning.vector_env.BatchEnv",
        "uwsim.learning.options.EpisodeOptions",
        "uwsim.learning.task.Task",
    ],
    "Sweeps and fleets": ["uwsim.sweeps", "uwsim.fleet"],
    "On the wall clock": ["uwsim.live.LiveSimulator"],
    "Recordings": ["uwsim.recording.Recorder"],
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
