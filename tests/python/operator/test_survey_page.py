"""The start screen's task Survey: scenes that have a survey, their stills, and lanes that are planned on the chart."""

import io

import numpy as np
from PIL import Image

from browser import desk, shows, when
from uwsim import Simulator
from uwsim.operator.station.helm.plan import survey_lanes
from uwsim.scenario import load, packaged_scenarios

SCENES = "[...document.querySelector('#field-scenario').options]"


def test_a_lane_is_level_and_keeps_the_surveys_altitude_above_all_that_lies_below():
    with Simulator("lake") as sim:
        plan, survey = survey_lanes(sim), sim.scenario.survey
        ends = np.array(plan.points_world_m).reshape(-1, 2, 3)
        assert len(ends) > 3 and (ends[:, 0, 2] == ends[:, 1, 2]).all()
        for start, end in ends:
            places = np.linspace(start, end, 200)
            down = np.tile([0.0, 0.0, -1.0], (len(places), 1))
            below_m = sim.scene.cast(places, down, 200.0).ranges_m
            assert below_m.min() > survey.altitude_m - 0.3  # between two of the plan's samples


def test_a_survey_is_chosen_started_and_planned(browser, tmp_path):
    with desk(browser, tmp_path) as here:
        page = here.open(viewport={"width": 1440, "height": 1000})
        page.wait_for_selector("#field-scenario")
        page.click("[data-task=survey]")
        offered = page.evaluate(f"{SCENES}.filter(({{ disabled }}) => !disabled).map(({{ value }}) => value)")
        assert sorted(offered) == sorted(name for name in packaged_scenarios() if load(name).survey is not None)
        assert page.input_value("#field-tilt_deg") == "60"
        page.select_option("#field-scenario", "pool")
        when(page, "document.querySelector('.preview img')?.naturalWidth === 480")
        seen = page.request.get(here.url + "/preview/pool.jpg")
        assert Image.open(io.BytesIO(seen.body())).size == (480, 270)
        page.click("button[type=submit]")
        when(page, "station.views?.large === 'chart' && station.chart.points.length > 3")
        planned = np.array(page.evaluate("station.chart.points"))
        live = here.station.present().live
        origin_m = here.station.present().table.sources[0].origin_m
        wanted = live.read(survey_lanes).result()
        assert np.abs(planned - origin_m - wanted.points_world_m).max() < 1e-3
        shows(page, ".view.is-large .scene-note", "planned")
        assert not here.complaints
