"""The Python reference: the public names, documented by their docstrings, on a page for each subject."""

PUBLIC = {
    "The simulator": [
        "uwsim.simulator.Simulator",
        "uwsim.simulator.vehicle.Vehicle",
        "uwsim.base.motion.Pose",
        "uwsim.base.motion.Velocity",
    ],
    "Sensors": [
        "uwsim.instruments.sensors.Sensor",
        "uwsim.instruments.sensors.Sample",
        "uwsim.instruments.sample_stream",
    ],
    "Scenarios": ["uwsim.evidence.scenario_check", "uwsim.scenario.build.hull.vehicle_hull()"],
    "Missions and surveys": [
        "uwsim.missions",
        "uwsim.flight.fly.fly()",
        "uwsim.flight.record.FlightRecord",
        "uwsim.bridges.remote.flight.fly_remote()",
        "uwsim.flight.survey.run_survey()",
        "uwsim.flight.raw_places.PatchErrors",
        "uwsim.flight.terminal.Silent",
        "uwsim.mapping.files.gsf_read.read_gsf()",
        "uwsim.flight.compare",
        "uwsim.flight.benchmark",
        "uwsim.exercises.flight.fly_exercise()",
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
            "next_best_view.next_best_view",
            "place_missions.keep_place",
            "place_missions.reach_dock",
        )
    ],
    "Control": ["uwsim.navigation.control.Controller", "uwsim.navigation.control.PathFollower"],
    "Estimation": ["uwsim.navigation.estimation.Navigator"],
    "Readings": ["uwsim.instruments.readings"],
    "Sonar": [
        "uwsim.instruments.sonars.multibeam.Sonar",
        "uwsim._core.Ping",
        "uwsim.instruments.sonars.imaging",
        "uwsim.mapping.ranging",
    ],
    "Sound in water": ["uwsim.instruments.acoustics.arrivals()", "uwsim.instruments.acoustics.Arrivals"],
    "Cameras": [
        "uwsim.instruments.cameras.camera.Camera",
        "uwsim.instruments.cameras.frame.Frame",
        "uwsim.instruments.cameras.lamp.Lamp",
    ],
    "Maps": [
        "uwsim.mapping.occupancy_map.OccupancyMap",
        "uwsim.mapping.changes.map_changes()",
        "uwsim.mapping.distance_field.DistanceField",
        "uwsim.mapping.frontier.frontiers()",
        "uwsim.mapping.body.body_points()",
        "uwsim.mapping.body.poses_along()",
    ],
    "Parameters": ["uwsim.simulator.parameters.Parameters"],
    "Faults": ["uwsim.simulator.failures.faults.Faults", "uwsim.simulator.failures.events.EventLog"],
    "Link": ["uwsim.simulator.network.Network"],
    "Many at once": [
        "uwsim.batch.Batch",
        "uwsim.batch.BatchMotion",
        "uwsim.batch.BatchObject",
        "uwsim.batch.BatchJoints",
        "uwsim.batch.BatchSamples",
        "uwsim.batch.BatchPings",
        "uwsim.batch.BatchPhysicsPings",
        "uwsim.batch.BatchEstimate",
        "uwsim.batch.MemberAboard",
    ],
    "Learning": [
        "uwsim.learning.lone_env.LoneEnv",
        "uwsim.learning.vector_env.BatchEnv",
        "uwsim.learning.options.EpisodeOptions",
        "uwsim.learning.registration.register()",
        "uwsim.learning.view.View",
        "uwsim.learning.task",
        "uwsim.learning.motion.Motion",
        "uwsim.learning.tasks",
        "uwsim.learning.baselines",
        "uwsim.learning.episodes.Episodes",
    ],
    "Sweeps and fleets": ["uwsim.campaigns.sweeps", "uwsim.campaigns.fleet"],
    "On the wall clock": ["uwsim.live.LiveSimulator", "uwsim.live.replay()", "uwsim.bridges.RosbridgeServer"],
    "Recordings": ["uwsim.recording.Recorder", "uwsim.recording.open()"],
}

HEAD = """# Python

**Public**: the names on these pages, and those of `import uwsim` (`uwsim.Simulator`, `uwsim.Batch`, `uwsim.fly`,
`uwsim.run_survey`, `uwsim.scenarios`, `uwsim.view`). Changes to them are listed in the changelog and require a new
minor version.

**Internal**: everything else, in particular `uwsim._core` and names that begin with an underscore. Internal names may
change in any release.
"""

IN_PARTS = {"uwsim.simulator.Simulator", "uwsim.simulator.vehicle.Vehicle", "uwsim.batch.Batch"}
"""Classes whose public methods are written in several files, as base classes."""


def python_pages() -> dict[str, str]:
    """Return the pages by name: directives that include the docstrings when the site is built, and a page of them."""
    pages = {f"python/{title.lower().replace(' ', '-')}": title for title in PUBLIC}
    links = "\n".join(
        f"| [{title}]({name}.md) | {', '.join(f'`{_short(each)}`' for each in PUBLIC[title])} |"
        for name, title in pages.items()
    )
    tree = "\n".join(pages)
    index = f"{HEAD}\n| page | names |\n|---|---|\n{links}\n\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{tree}\n```\n"
    return {"python": index, **{name: _page(title) for name, title in pages.items()}}


def _page(title: str) -> str:
    return f"# {title}\n\n```{{eval-rst}}\n{''.join(map(_directive, PUBLIC[title]))}```\n"


def _short(name: str) -> str:
    """Return a module's name whole, and that of a class or function without its module."""
    last = name.rpartition(".")[2]
    return name if last[0].islower() and not last.endswith("()") else last


def _directive(name: str) -> str:
    if name.endswith("()"):
        return f".. autofunction:: {name.removesuffix('()')}\n\n"
    kind = "automodule" if name.rpartition(".")[2][0].islower() else "autoclass"
    inherited = "   :inherited-members:\n" if name in IN_PARTS else ""
    return f".. {kind}:: {name}\n   :members:\n{inherited}\n"
