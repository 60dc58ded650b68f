"""The page's module is made from one description of the station's messages; page, server and docs match it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest
from pydantic import ValidationError

from station_pages import require_described
from uwsim.base.axes import AXES
from uwsim.base.commands import COMMANDS, HOLDS
from uwsim.channels.authority.rights import AidKind
from uwsim.channels.ros.own_types import OWN_TYPES, STATION_STATE
from uwsim.operator.station import Station
from uwsim.operator.station.site.answers import PAGE
from uwsim.operator.station.wire import messages
from uwsim.operator.station.wire.calls import CALLS, Call
from uwsim.scenario.spec.battery import Behaviour
from uwsim.simulator.failures.alarms import FAILSAFE_CAUSES

DOCS = (Path(__file__).parents[3] / "docs/connections/station-wire.md").read_text()


def test_the_page_names_services_and_types_of_the_station_nowhere_else() -> None:
    sources = [path for path in PAGE.rglob("*.js") if "vendor" not in path.parts]
    assert sources
    for path in sources:
        code = re.sub(r"//.*", "", path.read_text())
        assert not re.search(r"'/station/(?!state)|uwsim_msgs/|'surge', 'sway'", code), path


def test_the_page_has_a_text_for_each_name_of_python_s_tables() -> None:
    tables = {
        "panel/exercise.js": get_args(AidKind), "panel/failsafe.js": (*FAILSAFE_CAUSES, *get_args(Behaviour)),
        "drive/holds.js": HOLDS,
    }  # fmt: skip
    for path, names in tables.items():
        source = (PAGE / path).read_text()
        assert [name for name in names if not re.search(rf"\b{name}: ['{{]", source)] == [], path


def test_the_server_offers_what_is_described_and_nothing_else() -> None:
    offered = {service.name: service for service in Station().services}
    assert set(offered) == {f"station/{name}" for name in CALLS}
    for call in CALLS.values():
        service = offered[f"station/{call.name}"]
        assert (service.type, service.description, service.is_brief) == (call.ros_type, call.description, call.is_brief)
    fixed = {service.name for service in Station(is_fixed=True).services}
    assert set(offered) - fixed == {f"station/{name}" for name, call in CALLS.items() if call.is_start_screen}


def test_every_field_and_message_is_explained() -> None:
    for call in CALLS.values():
        assert f"`/station/{call.name}`" in DOCS
        for field in (*call.request.model_fields, *call.answer.model_fields):
            assert re.search(rf"\b{field}\b", DOCS), f"{call.name}: {field}"


def test_the_docs_list_the_fields_of_the_state() -> None:
    table = DOCS.split("## The state of the station")[1].split("\n\n`/station/describe`")[0]
    rows = [row.split("|")[1] for row in table.splitlines() if row.startswith("| `")]
    listed = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert listed == [line.split()[1] for line in OWN_TYPES[STATION_STATE].splitlines()]


def test_efforts_of_a_request_are_the_axes_of_the_command() -> None:
    fields = set(messages.Drive.model_fields)
    assert fields == {"vehicle", "stamp_ms", *AXES}
    assert [argument.name for argument in COMMANDS["set_effort"].arguments] == list(AXES)


def test_an_answer_of_other_fields_fails() -> None:
    require_described(Call("x", ""), {"success": True, "message": ""})
    for values in ({"success": True}, {"success": True, "message": "", "more": 1}, {"success": True, "message": 5}):
        with pytest.raises(ValidationError):
            require_described(Call("x", ""), values)
