"""Services for inspecting the graph (package rosapi), to the extent that roslibpy and roslibjs use them.

https://github.com/RobotWebTools/rosbridge_suite/tree/ros1/rosapi
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache, partial
from typing import Any

from uwsim.bridges.answers import outcome
from uwsim.bridges.doors.listener import post
from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.graph import LOGGER, Graph, Handler, Reply, plain_name
from uwsim.bridges.rosbridge.joining import ROSOUT, ROSOUT_TYPES, WARNING
from uwsim.bridges.rosbridge.parameters import Parameters
from uwsim.bridges.rosbridge.type_details import message_details, part_details
from uwsim.channels.calls.command_services import by_field
from uwsim.channels.names import NODE
from uwsim.channels.ros import build
from uwsim.channels.ros.message_types import message_text, shortened
from uwsim.channels.ros.messages import Ros, resolve, spelled
from uwsim.channels.ros.service_types import field_names

OWNER = "/rosapi"
MOST_TEXT = 1 << 20
"""The maximum total length of the definitions in one answer."""
DISTROS: dict[Ros, str] = {1: "noetic", 2: "jazzy"}
"""The distribution whose types and spelling are used, by the generation of ROS."""
IRREGULAR = {"action_servers": "GetActionServers", "get_ros_version": "GetROSVersion"}
STANDARD = {  # std_srvs, used by the simulator's services
    "std_srvs/Empty": ("", ""),
    "std_srvs/SetBool": ("bool data\n", "bool success\nstring message\n"),
    "std_srvs/Trigger": ("", "bool success\nstring message\n"),
}


Args = dict[str, Any]
Query = tuple[str, str, Callable[[Args], Any]]
"""A service: the fields of request and response, and the function that returns the answer or a future of it."""


def offer_rosapi(graph: Graph, parameters: Parameters, ros: Ros, time_ns: Callable[[], int]) -> None:
    """Offer the rosapi services in a graph. time_ns: returns the simulated time."""
    queries = _graph_queries(graph, ros) | _parameter_queries(parameters, ros) | _world_queries(ros, time_ns)
    queries |= _type_queries(ros, queries)
    graph.nodes[OWNER] = None
    log = graph.advertise(OWNER, ROSOUT, ROSOUT_TYPES[ros])  # as every graph of ROS has it

    def report(text: str) -> None:
        if log.sinks and log.type:
            line = build.message(log.type, level=WARNING[ros], name="uwsim", msg=text)
            graph.publish(log, Sample(line, time_ns()))

    graph.report = report
    for name, query in queries.items():
        graph.advertise_service(OWNER, f"rosapi/{name}", _type_of(name), _handler(name, query))


def _type_of(name: str) -> str:
    """Return a service's type, such as "rosapi/TopicType" for topic_type."""
    return f"rosapi/{IRREGULAR.get(name) or name.title().replace('_', '')}"


def _handler(name: str, query: Query) -> Handler:
    def handle(arguments: Any, reply: Reply, caller: str) -> None:
        if isinstance(arguments, list):
            arguments = by_field(f"rosapi/{name}", field_names(query[0]), arguments)
        if not isinstance(arguments, dict):
            raise ValueError(f"{_type_of(name)}: args must be an object or a list")
        answer = query[2](arguments)
        if isinstance(answer, Future):  # the result of a command to the simulator
            loop = asyncio.get_running_loop()
            answer.add_done_callback(lambda done: post(loop, _reply_done, done, reply))
        else:
            reply(True, answer)

    return handle


def _reply_done(done: Future[Any], reply: Reply) -> None:
    succeeded, reason = outcome(done.result, LOGGER)
    reply(succeeded, {} if succeeded else reason)


def _text(arguments: Args, key: str) -> str:
    value = arguments.get(key)
    if not isinstance(value, str):
        raise ValueError(f"args.{key} = {shortened(value)}: must be a string")
    return value


def _graph_queries(graph: Graph, ros: Ros) -> dict[str, Query]:
    topics, services = graph.topics, graph.services

    def topic_of(args: Args) -> Any:
        return topics.get(plain_name(_text(args, "topic")))

    def service_of(args: Args) -> Any:
        return services.get(plain_name(_text(args, "service"), "service"))

    def typed_topics(args: Args) -> Args:
        typed = [(topic.name, topic.type) for topic in topics.values() if topic.type]
        return {"topics": [f"/{name}" for name, _ in typed], "types": [spelled(kind, ros) for _, kind in typed]}

    def raw_types(args: Args) -> Args:
        found = typed_topics(args)
        return found | {"typedefs_full_text": _full_texts(found["types"], ros)}

    def topics_for_type(args: Args) -> Args:
        wanted = resolve(_text(args, "type"))[0]
        return {"topics": [f"/{topic.name}" for topic in topics.values() if topic.type == wanted]}

    def topic_type(args: Args) -> Args:
        topic = topic_of(args)
        return {"type": spelled(topic.type, ros) if topic is not None and topic.type else ""}

    def services_for_type(args: Args) -> Args:
        wanted = _text(args, "type").replace("/srv/", "/")
        found = [service.name for service in services.values() if service.type.replace("/srv/", "/") == wanted]
        return {"services": [f"/{name}" for name in found]}

    def action_servers(args: Args) -> Args:
        return {"action_servers": [f"/{name}" for name in graph.actions]}

    def node_details(args: Args) -> Args:
        node = _text(args, "node")
        return {
            "subscribing": [f"/{topic.name}" for topic in topics.values() if node in subscribers(topic)],
            "publishing": [f"/{topic.name}" for topic in topics.values() if node in topic.publishers],
            "services": [f"/{service.name}" for service in services.values() if service.owner == node],
        }

    def subscribers(topic: Any) -> list[str]:
        return [] if topic is None else list(dict.fromkeys(owner for owner, _ in topic.sinks))

    def interfaces(args: Args) -> Args:
        types = {spelled(topic.type, ros) for topic in topics.values() if topic.type}
        return {"interfaces": sorted(types | {service.type for service in services.values() if service.type})}

    def providers(args: Args) -> Args:
        wanted = _text(args, "service")  # rosapi's own takes the name of a type; its description speaks of a service
        named = {f"/{service.name}" for service in services.values()}
        found = [
            service.owner for service in services.values()
            if wanted in (f"/{service.name}", service.name)
            or (wanted not in named and service.type.replace("/srv/", "/") == wanted.replace("/srv/", "/"))
        ]  # fmt: skip
        return {"providers": list(dict.fromkeys(found))}

    names = "string[] topics\nstring[] types\n"
    return {
        "topics": ("", names, typed_topics),
        "topics_and_raw_types": ("", names + "string[] typedefs_full_text\n", raw_types),
        "topics_for_type": ("string type\n", "string[] topics\n", topics_for_type),
        "topic_type": ("string topic\n", "string type\n", topic_type),
        "publishers": (
            "string topic\n",
            "string[] publishers\n",
            lambda args: {"publishers": list(getattr(topic_of(args), "publishers", ()))},
        ),
        "subscribers": (
            "string topic\n", "string[] subscribers\n", lambda args: {"subscribers": subscribers(topic_of(args))}
        ),
        "services": ("", "string[] services\n", lambda args: {"services": [f"/{name}" for name in services]}),
        "services_for_type": ("string type\n", "string[] services\n", services_for_type),
        "service_type": (
            "string service\n", "string type\n", lambda args: {"type": getattr(service_of(args), "type", "")}
        ),
        "service_providers": ("string service\n", "string[] providers\n", providers),
        "interfaces": ("", "string[] interfaces\n", interfaces),
        "service_node": (
            "string service\n", "string node\n", lambda args: {"node": getattr(service_of(args), "owner", "")}
        ),
        "nodes": ("", "string[] nodes\n", lambda args: {"nodes": list(graph.nodes)}),
        "node_details": (
            "string node\n", "string[] subscribing\nstring[] publishing\nstring[] services\n", node_details
        ),
        "action_servers": ("", "string[] action_servers\n", action_servers),
    }  # fmt: skip


def _full_texts(types: list[str], ros: Ros) -> list[str]:
    texts, room = [], MOST_TEXT
    for type_name in types:
        texts.append(_full_text(type_name, ros))
        room -= len(texts[-1])
        if room < 0:
            raise ValueError(
                f"the definitions of {len(types)} topics have more than {MOST_TEXT} characters: request them by type"
            )
    return texts


@cache
def _full_text(type_name: str, ros: Ros) -> str:
    return message_text(resolve(type_name)[0], ros)


def _parameter_queries(parameters: Parameters, ros: Ros) -> dict[str, Query]:
    def name_of(args: Args) -> str:
        node, colon, rest = _text(args, "name").partition(":")  # in ROS 2, /NODE:NAME
        is_ours = colon and node.strip("/").rpartition("/")[2] == NODE
        return plain_name(rest if is_ours else _text(args, "name"), "parameter")

    def get(args: Args) -> Args:
        default = args.get("default_value" if "default_value" in args else "default")  # in ROS 2, and in ROS 1
        default = default if isinstance(default, str) and default else "null"
        return {"value": parameters.get_json(name_of(args), default)}

    def set_(args: Args) -> Args | Future[Any]:
        return parameters.set_json(name_of(args), args.get("value")) or {}

    def delete(args: Args) -> Args:
        parameters.delete(name_of(args))
        return {}

    def search(args: Args) -> Args:
        return {"global_name": f"/{name_of(args)}" if parameters.has(name_of(args)) else ""}

    def has(args: Args) -> Args:
        return {"exists": parameters.has(name_of(args))}

    def all_names(args: Args) -> Args:
        names = parameters.names()
        return {"names": [f"/{name}" if ros == 1 else f"/{NODE}:{name.replace('/', '.')}" for name in names]}

    return {
        "get_param": (f"string name\nstring {'default' if ros == 1 else 'default_value'}\n", "string value\n", get),
        "set_param": ("string name\nstring value\n", "", set_),
        "has_param": ("string name\n", "bool exists\n", has),
        "search_param": ("string name\n", "string global_name\n", search),
        "delete_param": ("string name\n", "", delete),
        "get_param_names": ("", "string[] names\n", all_names),
    }


def _world_queries(ros: Ros, time_ns: Callable[[], int]) -> dict[str, Query]:
    keys = ("secs", "nsecs") if ros == 1 else ("sec", "nanosec")

    def get_time(args: Args) -> Args:
        return {"time": dict(zip(keys, divmod(time_ns(), 10**9), strict=True))}

    version = {"version": ros, "distro": DISTROS[ros]}
    return {
        "get_time": ("", "builtin_interfaces/Time time\n", get_time),
        "get_ros_version": ("", "uint8 version\nstring distro\n", lambda args: version),
    }


def _type_queries(ros: Ros, queries: dict[str, Query]) -> dict[str, Query]:
    texts = STANDARD | {_type_of(name): query[:2] for name, query in queries.items()}

    def of_message(args: Args) -> Args:
        return {"typedefs": message_details(_text(args, "type"), ros)}

    def of_service(half: int, args: Args) -> Args:
        name = _text(args, "type").replace("/srv/", "/")
        if name not in texts:
            raise ValueError(f"type = '{name:.80}': unknown service type")
        return {"typedefs": part_details(name + ("Request", "Response")[half], texts[name][half], ros)}

    request, response = "string type\n", ""  # rosapi/TypeDef[], which only rosapi defines
    return {
        "message_details": (request, response, of_message),
        "service_request_details": (request, response, partial(of_service, 0)),
        "service_response_details": (request, response, partial(of_service, 1)),
    }
