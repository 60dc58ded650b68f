"""The services by which clients ask about the graph (package rosapi): those that roslibpy and roslibjs offer.

https://github.com/RobotWebTools/rosbridge_suite/tree/ros1/rosapi
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache
from typing import Any, NamedTuple

from uwsim.bridges.rosbridge.graph import Graph, Handler, plain_name
from uwsim.bridges.rosbridge.parameters import Parameters
from uwsim.bridges.rosbridge.type_details import message_details, part_details
from uwsim.channels.message_types import message_text, shortened
from uwsim.channels.messages import Ros, resolve, spelled

OWNER = "/rosapi"
MOST_TEXT = 1 << 20
"""Characters of all definitions in one answer."""
STANDARD = {  # std_srvs, which simulators' own services have
    "std_srvs/Empty": ("", ""),
    "std_srvs/SetBool": ("bool data\n", "bool success\nstring message\n"),
    "std_srvs/Trigger": ("", "bool success\nstring message\n"),
}


class Query(NamedTuple):
    """One service of rosapi: the texts of its request and response, and what answers it, at once or by a future."""

    type: str
    request: str
    response: str
    answer: Callable[[dict[str, Any]], dict[str, Any] | Future[Any]]


def offer_rosapi(graph: Graph, parameters: Parameters, ros: Ros, time_ns: Callable[[], int]) -> None:
    """Offer rosapi's services in a graph. time_ns: the simulated time."""
    queries = _graph_queries(graph, ros) | _parameter_queries(parameters) | _time_query(ros, time_ns)
    queries |= _type_queries(ros, queries)
    graph.nodes[OWNER] = None
    for name, query in queries.items():
        graph.advertise_service(OWNER, f"rosapi/{name}", query.type, _handler(query))


def _handler(query: Query) -> Handler:
    def handle(arguments: Any, reply: Callable[[bool, Any], None], caller: str) -> None:
        if not isinstance(arguments, dict):
            raise ValueError(f"{query.type}: args must be an object")
        answer = query.answer(arguments)
        if isinstance(answer, Future):
            loop = asyncio.get_running_loop()
            answer.add_done_callback(lambda done: loop.call_soon_threadsafe(_reply_done, done, reply))
        else:
            reply(True, answer)

    return handle


def _reply_done(done: Future[Any], reply: Callable[[bool, Any], None]) -> None:
    """Answer a call that a command of the simulator was made for."""
    error = done.exception()
    if error is None:
        reply(True, {})
    else:
        reply(False, str(error))


def _text(arguments: dict[str, Any], key: str) -> str:
    value = arguments.get(key)
    if not isinstance(value, str):
        raise ValueError(f"args.{key} = {shortened(value)}: must be a string")
    return value


def _graph_queries(graph: Graph, ros: Ros) -> dict[str, Query]:
    def type_of(name: str | None) -> str:
        return "" if name is None else spelled(name, ros)

    def typed_topics() -> dict[str, str]:
        return {f"/{topic.name}": type_of(topic.type) for topic in graph.topics.values() if topic.type}

    def topics_for_type(args: dict[str, Any]) -> dict[str, Any]:
        wanted = resolve(_text(args, "type"))[0]
        return {"topics": [f"/{topic.name}" for topic in graph.topics.values() if topic.type == wanted]}

    def topic_type(args: dict[str, Any]) -> dict[str, Any]:
        topic = graph.topics.get(plain_name(_text(args, "topic")))
        return {"type": type_of(topic.type if topic else None)}

    def service_of(args: dict[str, Any]) -> Any:
        return graph.services.get(plain_name(_text(args, "service"), "service"))

    def node_details(args: dict[str, Any]) -> dict[str, Any]:
        node, topics = _text(args, "node"), graph.topics.values()
        return {
            "subscribing": [f"/{topic.name}" for topic in topics if any(key[0] == node for key in topic.sinks)],
            "publishing": [f"/{topic.name}" for topic in topics if node in topic.publishers],
            "services": [f"/{service.name}" for service in graph.services.values() if service.owner == node],
        }

    def peers(args: dict[str, Any], what: str) -> list[str]:
        topic = graph.topics.get(plain_name(_text(args, "topic")))
        if topic is None:
            return []
        return list(topic.publishers) if what == "publishers" else list(dict.fromkeys(key[0] for key in topic.sinks))

    def services_for_type(args: dict[str, Any]) -> dict[str, Any]:
        wanted = _text(args, "type")
        return {"services": [f"/{service.name}" for service in graph.services.values() if service.type == wanted]}

    names = "string[] topics\nstring[] types\n"
    return {
        "topics": Query("rosapi/Topics", "", names, lambda args: _topics(typed_topics())),
        "topics_and_raw_types": Query(
            "rosapi/TopicsAndRawTypes",
            "",
            names + "string[] typedefs_full_text\n",
            lambda args: _topics(typed_topics()) | {"typedefs_full_text": _full_texts(typed_topics(), ros)},
        ),
        "topics_for_type": Query("rosapi/TopicsForType", "string type\n", "string[] topics\n", topics_for_type),
        "topic_type": Query("rosapi/TopicType", "string topic\n", "string type\n", topic_type),
        "publishers": Query(
            "rosapi/Publishers",
            "string topic\n",
            "string[] publishers\n",
            lambda args: {"publishers": peers(args, "publishers")},
        ),
        "subscribers": Query(
            "rosapi/Subscribers",
            "string topic\n",
            "string[] subscribers\n",
            lambda args: {"subscribers": peers(args, "subscribers")},
        ),
        "services": Query(
            "rosapi/Services",
            "",
            "string[] services\n",
            lambda args: {"services": [f"/{name}" for name in graph.services]},
        ),
        "services_for_type": Query("rosapi/ServicesForType", "string type\n", "string[] services\n", services_for_type),
        "service_type": Query(
            "rosapi/ServiceType",
            "string service\n",
            "string type\n",
            lambda args: {"type": getattr(service_of(args), "type", "")},
        ),
        "service_node": Query(
            "rosapi/ServiceNode",
            "string service\n",
            "string node\n",
            lambda args: {"node": getattr(service_of(args), "owner", "")},
        ),
        "nodes": Query("rosapi/Nodes", "", "string[] nodes\n", lambda args: {"nodes": list(graph.nodes)}),
        "node_details": Query(
            "rosapi/NodeDetails",
            "string node\n",
            "string[] subscribing\nstring[] publishing\nstring[] services\n",
            node_details,
        ),
        "action_servers": Query(
            "rosapi/GetActionServers", "", "string[] action_servers\n", lambda args: {"action_servers": []}
        ),
    }


def _topics(types: dict[str, str]) -> dict[str, Any]:
    return {"topics": list(types), "types": list(types.values())}


def _full_texts(types: dict[str, str], ros: Ros) -> list[str]:
    texts = []
    room = MOST_TEXT
    for type_name in types.values():
        texts.append(_full_text(type_name, ros))
        room -= len(texts[-1])
        if room < 0:
            raise ValueError(
                f"the definitions of {len(types)} topics have more than {MOST_TEXT} characters: ask by type"
            )
    return texts


@cache
def _full_text(type_name: str, ros: Ros) -> str:
    return message_text(resolve(type_name)[0], ros)


def _parameter_queries(parameters: Parameters) -> dict[str, Query]:
    def name_of(args: dict[str, Any]) -> str:
        return plain_name(_text(args, "name"), "parameter")

    def get(args: dict[str, Any]) -> dict[str, Any]:
        default = args.get("default")
        return {
            "value": parameters.get_json(name_of(args), default if isinstance(default, str) and default else "null")
        }

    def set_(args: dict[str, Any]) -> dict[str, Any] | Future[Any]:
        return parameters.set_json(name_of(args), args.get("value")) or {}

    def delete(args: dict[str, Any]) -> dict[str, Any]:
        parameters.delete(name_of(args))
        return {}

    def search(args: dict[str, Any]) -> dict[str, Any]:
        return {"global_name": f"/{name_of(args)}" if parameters.has(name_of(args)) else ""}

    return {
        "get_param": Query("rosapi/GetParam", "string name\nstring default\n", "string value\n", get),
        "set_param": Query("rosapi/SetParam", "string name\nstring value\n", "", set_),
        "has_param": Query(
            "rosapi/HasParam", "string name\n", "bool exists\n", lambda args: {"exists": parameters.has(name_of(args))}
        ),
        "search_param": Query("rosapi/SearchParam", "string name\n", "string global_name\n", search),
        "delete_param": Query("rosapi/DeleteParam", "string name\n", "", delete),
        "get_param_names": Query(
            "rosapi/GetParamNames",
            "",
            "string[] names\n",
            lambda args: {"names": [f"/{name}" for name in parameters.names()]},
        ),
    }


def _time_query(ros: Ros, time_ns: Callable[[], int]) -> dict[str, Query]:
    keys = ("secs", "nsecs") if ros == 1 else ("sec", "nanosec")

    def get_time(args: dict[str, Any]) -> dict[str, Any]:
        return {"time": dict(zip(keys, divmod(time_ns(), 10**9), strict=True))}

    return {"get_time": Query("rosapi/GetTime", "", "builtin_interfaces/Time time\n", get_time)}


def _type_queries(ros: Ros, queries: dict[str, Query]) -> dict[str, Query]:
    texts = STANDARD | {query.type: (query.request, query.response) for query in queries.values()}

    def details(args: dict[str, Any], half: int) -> dict[str, Any]:
        name = _text(args, "type").replace("/srv/", "/")
        if name not in texts:
            raise ValueError(f"type = '{name:.80}': no such service type is known here")
        return {"typedefs": part_details(name + ("Request", "Response")[half], texts[name][half], ros)}

    request, response = "string type\n", ""  # rosapi/TypeDef[], a type of rosapi's own
    return {
        "message_details": Query(
            "rosapi/MessageDetails",
            request,
            response,
            lambda args: {"typedefs": message_details(_text(args, "type"), ros)},
        ),
        "service_request_details": Query(
            "rosapi/ServiceRequestDetails", request, response, lambda args: details(args, 0)
        ),
        "service_response_details": Query(
            "rosapi/ServiceResponseDetails", request, response, lambda args: details(args, 1)
        ),
    }
