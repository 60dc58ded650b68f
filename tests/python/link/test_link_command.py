"""`uwsim scenario link`, `uwsim validate link`, `uwsim serve --link` and the start screen's choice of modem."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uwsim import Simulator, fly
from uwsim.channels import channels
from uwsim.cli.program import app
from uwsim.link.carried import carried_channels
from uwsim.link.rates import airtime_s, airtime_share, send_rates
from uwsim.link.trial import run_trial
from uwsim.missions import wait
from uwsim.operator.station.start.choice import ChoiceError, catalog, chosen
from uwsim.scenario import load
from uwsim.scenario.spec.link import LinkFault, LinkSetup
from uwsim.scenario.spec.modem import load_modem


def test_the_command_draws_delay_delivery_and_goodput(tmp_path: Path, blank_figures: None) -> None:
    path = tmp_path / "link.png"
    result = CliRunner().invoke(app, ["scenario", "link", "pool", "--out", str(path), "--depth", "1"])
    assert result.exit_code == 0, result.output
    assert path.read_bytes().startswith(b"\x89PNG")
    assert "s2cm_hs in pool" in result.output
    result = CliRunner().invoke(app, ["scenario", "link", "pool", "--out", str(path), "--depth", "1", "--json"])
    found = json.loads(result.output)
    assert found["modem"] == "s2cm_hs" and len(found["legs"]) > 3
    assert sum(leg["sent"] for leg in found["legs"]) > 0 and found["table"]


def test_a_trial_s_delay_is_path_over_c_and_a_blackout_shows() -> None:
    fault = LinkFault(from_s=1.0, until_s=6.0)
    scenario = load("pool").model_copy(update={"link": LinkSetup(modem="s2cm_hs", faults=(fault,))})
    trial = run_trial(scenario, None, depth_m=2.0)
    speed = 1482.5  # fresh water at 20 deg C
    for leg in trial.legs:
        assert leg.delay_s == pytest.approx(leg.range_m / speed, rel=0.01)
    dark = [leg for leg in trial.legs if fault.from_s < leg.time_s < fault.until_s - 3.0]
    clear = [leg for leg in trial.legs if leg.time_s > fault.until_s]
    assert dark and clear
    assert all(leg.delivered == 0 for leg in dark)
    assert all(leg.delivered == leg.sent for leg in clear)


def test_a_scenario_without_a_link_needs_a_modem() -> None:
    with pytest.raises(ValueError, match="choose one with --modem"):
        run_trial("pool", "none")


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
