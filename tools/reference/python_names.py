"""The Python reference: the public names, from their docstrings."""

PUBLIC = {
    "The simulator": [
        "uwsim.simulator.Simulator",
        "uwsim.vehicle.Vehicle",
        "uwsim.motion.Pose",
        "uwsim.motion.Velocity",
    ],
    "Sensors": ["uwsim.sensors.Sensor", "uwsim.sensors.Sample", "uwsim.sample_stream"],
    "Missions": ["uwsim.missions"],
    "Estimation": ["uwsim.estimation.Navigator"],
    "Readings": ["uwsim.readings"],
    "Sonar": ["uwsim.sonars.multibeam.Sonar", "uwsim._core.Ping", "uwsim.ranging"],
    "Cameras": ["uwsim.cameras.camera.Camera", "uwsim.cameras.frame.Frame", "uwsim.cameras.lamp.Lamp"],
    "Maps": ["uwsim.mapping.occupancy_map.OccupancyMap"],
    "Parameters": ["uwsim.parameters.Parameters"],
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


def python_page() -> str:
    """Return the page: directives by which the site reads the docstrings."""
    text = "# Python\n\nNames that are not here are internal: they may change in any release.\n"
    for title, names in PUBLIC.items():
        text += f"\n## {title}\n\n```{{eval-rst}}\n"
        for name in names:
            directive = "automodule" if name.rpartition(".")[2][0].islower() else "autoclass"
            text += f".. {directive}:: {name}\n   :members:\n\n"
        text += "```\n"
    return text
