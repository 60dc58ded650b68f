"""`uwsim serve`: a live simulator that rosbridge clients connect to."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from uwsim.base.options import flag_name, option, refuse
from uwsim.bridges.cli.graph_options import ServedGraphOptions
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.page import Pages, Serving
from uwsim.bridges.requested import Bridges
from uwsim.cli.access import Access
from uwsim.cli.autopilots import Autopilots, prepared
from uwsim.cli.groups import under
from uwsim.cli.options import SimulatorOptions
from uwsim.cli.values import one_of, scenarios, within
from uwsim.recording.flight_options import RecordOptions

if TYPE_CHECKING:
    from uwsim.channels import Table

Speed = Annotated[str, typer.Option(help="Simulated seconds per wall second, or max.")]
Wire = Annotated[
    str | None,
    typer.Option(
        help="Topics: standard (ROS's usual ones), published (those of the paper's simulator) or both. Default: the "
        "scenario's; both with the station's page, which needs them.",
        **one_of("standard", "published", "both"),
    ),
]
Origin = Annotated[
    str | None,
    typer.Option(
        help="The odom frame's origin: world, or published (that simulator's surface is at z = 75.3 m). Default: the "
        "scenario's.",
        **one_of("world", "published"),
    ),
]
Namespace = Annotated[str, typer.Option(help="Prefix of all topics and services, and of frames. Default: none.")]
FramePrefix = Annotated[
    str | None, typer.Option(help="Prefix of all frames except world. Default: the namespace and a slash.")
]
Tf = Annotated[
    str,
    typer.Option(
        "--tf",
        help="The motion on /tf and /odom: truth, odom (the vehicle's estimate) or none (left to other nodes).",
        **one_of("truth", "odom", "none"),
    ),
]
Paused = Annotated[bool, typer.Option("--paused", help="Start paused; the service /simulation/resume starts it.")]


@dataclass(frozen=True)
class ServedRecordOptions(RecordOptions):
    """The options of a recording of what is served. Raises OptionError."""

    record_all: bool = option(False, "Also record pictures and maps; prints first how much processor time that takes.")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.record_all:
            refuse("cannot be given with --record-all, which records all channels", record_topic=self.record_topic)


@under("Connect")
def serve(
    *,
    scenario: Annotated[
        str, typer.Argument(help="Name of a packaged scenario, or path of a YAML file.", autocompletion=scenarios)
    ] = "lake",
    port: Annotated[
        int, typer.Option(help="Port to listen on; 0 chooses a free one.", callback=within(0, 65535))
    ] = ROSBRIDGE_PORT,
    host: Annotated[str, typer.Option(help="Address to listen on. Warns about any that other machines can reach.")] = (
        "127.0.0.1"
    ),
    speed: Speed = "1",
    simulated: SimulatorOptions,
    wire: Wire = None,
    origin: Origin = None,
    namespace: Namespace = "",
    frame_prefix: FramePrefix = None,
    tf: Tf = "truth",
    graph: ServedGraphOptions,
    ros: Annotated[
        int,
        typer.Option(
            help="Generation of ROS for clients that name types like std_msgs/String: 1 or 2.",
            callback=within(1, 2),
        ),
    ] = 1,
    access: Access,
    paused: Paused = False,
    pages: Pages,
    bridges: Bridges,
    recorded: ServedRecordOptions,
    autopilots: Autopilots,
) -> None:
    """Run a scenario in real time for rosbridge.

    Clients such as roslibpy and roslibjs connect without ROS. Ctrl-C ends it.
    """
    from contextlib import ExitStack

    from uwsim.bridges import RosbridgeServer
    from uwsim.bridges.aboard.aboard import aboard_of
    from uwsim.bridges.actions import actions_in, actions_of
    from uwsim.bridges.plug import Context
    from uwsim.channels.delivery.feed import Feed
    from uwsim.channels.names import channels_in, node_name, services_in
    from uwsim.channels.served import default_origin, served_table
    from uwsim.cli.run_live import run_until_interrupted
    from uwsim.live import LiveSimulator

    autopilot, page = autopilots.only, pages.only
    bridges.prepare(autopilots.requested)
    prefix = prefix_of(namespace, frame_prefix)
    if page is not None and (prefix or tf != "truth" or graph.is_about_topics):
        rule = "its page needs the usual topics and frames: --tf truth, and no other option about them"
        raise ValueError(f"{flag_name(str(page.switch))}: {rule}")
    parameters = graph.parameters(node_name(namespace))
    accessible = access.settings(host)
    simulator = prepared(autopilot, scenario, **simulated.arguments)
    bridges.check(simulator)
    graph.apply(parameters, simulator)
    origin = origin or default_origin(simulator.scenario)
    live = LiveSimulator(simulator, speed=parsed_speed(speed), paused=paused)
    with ExitStack() as sinks:
        flown = [] if autopilot is None else [sinks.enter_context(autopilot.flying(live))]
        sinks.enter_context(live)
        feed = Feed(live)

        def record_from(table: Table) -> None:
            """Start recording the channels that a table's clients see, if a recording was requested."""
            if recorded.record is not None:
                from uwsim.recording import Recorder
                from uwsim.recording.moments import picture_cost_text

                recorder = Recorder(
                    live, recorded.record, topics=recorded.record_topic or None, shared=table, feed=feed,
                    is_light=not recorded.record_all,
                )  # fmt: skip
                table.channels = recorder.record_received(table.channels)
                sinks.enter_context(recorder)
                if recorded.record_all:
                    typer.echo(f"recording everything, which takes {picture_cost_text(simulator)}", err=True)
                elif not recorded.record_topic:
                    typer.echo("recording without pictures and maps, which --record-all adds", err=True)

        options: dict[str, Any] = {"port": port, "ros": ros, **accessible}
        if page is not None:
            serving = Serving(live, feed, options, wire, origin, access.token, record_from)
            address, place, shown = page.open(sinks, serving)
            places = [f"{scenario} at {address}", place]
            actions = [] if graph.no_actions else actions_of(simulator, shown)
        else:
            shown = served_table(
                live,
                wire=wire,  # type: ignore[arg-type]  # checked there
                origin=origin,
                tf=tf,  # type: ignore[arg-type]  # checked there
                frame_prefix=prefix,
                **graph.of_table,
            )
            # refuses invalid options before a file is created
            server = RosbridgeServer(live, channels=(), feed=feed, **options)
            if simulator.link is not None:
                from uwsim.link import Carrier

                carrier = sinks.enter_context(Carrier(live, shown))
                shown.channels, shown.services = carrier.channels, carrier.over(shown.services)
            record_from(shown)
            shown.channels = channels_in(namespace, shown.channels)
            shown.services = services_in(namespace, shown.services)
            actions = [] if graph.no_actions else actions_in(namespace, actions_of(simulator, shown))
            server.channels, server.services, server.actions = shown.channels, shown.services, actions
            sinks.enter_context(server)
            places = [f"{scenario} at {server.url}"]
        places += flown
        context = Context(
            shown.channels, feed, live, shown.services, actions, origin, namespace, accessible,
            aboard=aboard_of(simulator, shown),
        )  # fmt: skip
        places += bridges.open(sinks, context)
        run_until_interrupted(live, ", ".join(places))


def prefix_of(namespace: str, frame_prefix: str | None) -> str:
    """Return the prefix of frames. Raises ValueError for names that ROS does not allow."""
    from uwsim.channels.names import NAME_MAX, checked_namespace

    if frame_prefix is not None and not re.fullmatch(rf"[\w./~-]{{0,{NAME_MAX}}}", frame_prefix):
        rule = f"must be at most {NAME_MAX} letters, digits, _, -, ~, . and /"
        raise ValueError(f"--frame-prefix = '{frame_prefix[:80]}': {rule}")
    plain = checked_namespace(namespace)
    return (f"{plain}/" if plain else "") if frame_prefix is None else frame_prefix


def parsed_speed(text: str) -> float | Literal["max"]:
    """Parse "max" or a number. Raises ValueError."""
    if text == "max":
        return "max"
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"--speed = '{text}': must be a number, or max") from None
