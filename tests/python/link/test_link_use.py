"""A modem from the start screen, what fits into its time, and the report of a flight over it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from uwsim import Simulator, fly
from uwsim.channels import channels
from uwsim.link.carried import carried_channels
from uwsim.link.rates import airtime_s, airtime_share, send_rates
from uwsim.missions import wait
from uwsim.operator.station.start.choice import ChoiceError, catalog, chosen
from uwsim.scenario import load
from uwsim.scenario.spec.link import load_modem


def test_the_start_screen_offers_every_modem() -> None:
    assert next(iter(catalog()["links"]))["name"] == "none"
    scenario, _ = chosen({"scenario": "pool", "link": "micromodem"})
    assert scenario.link is not None
    assert scenario.link.modem.name == "micromodem"
    with pytest.raises(ChoiceError, match="must be one of none"):
        chosen({"link": "string"})


def test_what_is_sent_fits_into_the_modem_s_time() -> None:
    sim = Simulator("pool", link="s2cm_hs", threads=1)
    said = [one for one in carried_channels(channels(sim), sim) if one.channel.direction == "out"]
    sizes = {one.channel.name: 40 for one in said}
    for name in ("s2cm_hs", "micromodem"):
        modem = load_modem(name)
        rates = send_rates(said, sizes, modem, "tdma", 2)
        pictures = {one.channel.name for one in said if one.priority == 4}
        busy = sum(rate * airtime_s(modem, "tdma", 40) for name, rate in rates.items() if name not in pictures)
        assert busy <= airtime_share(modem, "tdma", 2)
        assert "stateData" in rates


def test_a_flight_over_a_link_reports_it_by_channel(tmp_path: Path, blank_figures: None) -> None:
    def mission(vehicle):
        vehicle.release()
        yield wait(4.0)

    scenario = load("pool").with_changes(modem="s2cm_hs")
    fly(mission, scenario, tmp_path)
    rows = json.loads((tmp_path / "summary.json").read_text())["link"]
    (state,) = [row for row in rows if row["topic"] == "stateData"]
    assert state["delivered"] >= 3
    page = (tmp_path / "report.html").read_text()
    assert "The link" in page and "stateData" in page
