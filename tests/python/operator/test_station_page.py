"""The station's page in a real browser: from the start screen to a map, with pilots, efforts and connections."""

import re
from pathlib import Path

import numpy as np
import pytest

from browser import desk, judge, shows, until, when
from relay import Relay
from uwsim.mapping import OccupancyMap
from uwsim.scenario.read.assets import assets_folder

HELD_S = 1.2


def docked(page):
    """Restart the simulator of a page, which keeps the controls."""
    session = page.evaluate("station.station.state.session")
    page.evaluate("station.station.control('restart')")
    when(page, f"station.station.state.session > {session} && station.telemetry.message?.released === false")
    when(page, "station.station.isPilot && station.pilot.mayAct")
    return page


def test_from_the_start_screen_to_a_map_on_disk(browser, tmp_path):
    with desk(browser, tmp_path) as here:
        page = here.open(requests=(asked := []))
        renderer = page.evaluate(
            """() => { const gl = document.createElement('canvas').getContext('webgl2');
            return gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL); }"""
        )
        assert "SwiftShader" in renderer
        page.select_option("#field-scenario", "pool")
        page.fill("#field-seed", "-1")
        when(page, "document.querySelector('#wrong-seed').textContent.includes('-1')")
        judge(page, "start screen")
        page.click("text=Start >> nth=-1")
        page.wait_for_timeout(300)
        assert page.is_visible("#start")  # an invalid seed did not start it
        page.fill("#field-seed", "3")
        when(page, "document.querySelector('#wrong-seed').textContent === ''")
        page.click("button[type=submit]")
        page.wait_for_selector("#station:not([hidden])")
        assert here.station.present().live.simulator.seed == 3

        when(page, "station.views.picture('front').drawn > 2")
        when(page, "station.station.isPilot")
        page.keyboard.press("r")
        until(lambda: here.rov.released, "the release")
        page.keyboard.down("w")
        page.keyboard.down("q")  # two keys at once
        until(lambda: here.effort("surge") == 0.5 and here.effort("yaw") == 0.5, "efforts of two keys")
        page.keyboard.up("q")
        until(lambda: here.effort("yaw") == 0.0 and here.effort("surge") == 0.5, "the effort of one")
        page.keyboard.up("w")
        until(lambda: here.effort("surge") == 0.0, "none")

        here.station.present().live.speed = 3.0
        page.keyboard.down("e")  # turns the view
        when(page, "station.scene.store.count > 300")
        page.keyboard.up("e")
        here.station.present().live.speed = 1.0
        page.keyboard.press(str(1 + page.evaluate("station.views.names.indexOf('scene')")))
        when(page, "station.scene.voxels.pointCount > 100 && station.scene.gate.frames > 2")
        with page.expect_download() as download:
            page.click("text=.bt")
        path = tmp_path / "map.bt"
        download.value.save_as(path)
        shown, known = page.evaluate("station.scene.store.count"), OccupancyMap.read(path)
        assert len(known.occupied_voxels()) == pytest.approx(shown, rel=0.2)  # the map keeps growing

        assert not here.complaints  # no errors and no content security policy violations
        host = here.url.removeprefix("http://")
        assert all(re.match(rf"(http|ws)://{host}/|blob:|data:", url) for url in asked), asked


def test_the_pilot_sees_a_failsafe_and_the_link_and_takes_the_vehicle_back(browser, tmp_path):
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    path = tmp_path / "leaky.yaml"
    path.write_text(
        text.replace("  model: rov\n", "  model: rov\n    failsafe: {leak_then: hold}\n") + "link: ideal_acoustic\n"
    )
    with desk(browser, tmp_path, str(path)) as here:
        page = here.fly()
        when(page, "station.station.isPilot")
        when(page, "document.querySelector('#link').textContent.includes('ideal_acoustic')")
        assert page.is_hidden("#failsafe")
        page.click("#dock")
        until(lambda: here.rov.released, "the release")
        here.station.present().live.command("inject_fault", kind="leak", kg_per_s=1.0, kg_max=0.2).result()
        page.wait_for_selector("#take-back:not([disabled])")
        told = page.inner_text("#failsafe")
        assert "holds its place by itself, because water is inside" in told and "water inside" in told.splitlines()
        judge(page, "failsafe")
        page.click("#take-back")
        until(lambda: here.rov.failsafe.state == "", "the end of the failsafe")
        when(page, "document.querySelector('#take-back').hidden")
        shows(page, "#failsafe", "water inside")  # the leak is still there
        assert not here.complaints


def test_everyone_can_read_it_in_the_dark_and_in_the_light_and_nothing_overflows_a_phone(page):
    def judge_both(what):
        for scheme in ("dark", "light"):
            page.emulate_media(color_scheme=scheme)
            when(page, f"document.documentElement.dataset.theme === '{scheme}'")
            judge(page, f"{what}, {scheme}")

    judge_both("main screen")
    page.keyboard.press("?")
    page.wait_for_selector("#keys-dialog[open]")
    judge_both("keys")
    page.keyboard.press("Escape")
    when(page, "station.pilot.mayAct")
    page.keyboard.press("Escape")
    page.wait_for_selector("#menu-dialog[open]")
    judge_both("menu")
    page.click("text=Resume")

    page.set_viewport_size({"width": 400, "height": 800})
    when(page, "document.documentElement.scrollWidth <= 400")
    page.click("#unfold")
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    for part in ("#dock", "#lease", "#pause", "#menu", "#lamp-collision"):
        box = page.locator(part).bounding_box()
        assert box and box["x"] >= 0 and box["x"] + box["width"] <= 400, part
    page.set_viewport_size({"width": 1280, "height": 800})


def test_scripts_are_files_of_the_page(here, page):
    policy = page.evaluate("fetch('/').then((answer) => answer.headers.get('content-security-policy'))")
    assert "script-src 'self'" in policy and "unsafe" not in policy
    assert page.evaluate("[...document.scripts].every((script) => script.src !== '')")
    page.evaluate("document.body.append(Object.assign(document.createElement('script'), {text: 'window.broken = 1'}))")
    assert page.evaluate("window.broken") is None
    here.complaints.clear()  # of the script


def test_silence_puts_efforts_to_zero_and_a_held_key_goes_on(here, page):
    page.keyboard.down("w")
    until(lambda: here.effort("surge") == 0.5, "an effort")
    ticks = []
    live = here.station.present().live
    watch = live.every(0.05, lambda sim: float(sim.rov.effort[0]), ticks.append)
    page.evaluate(f"() => {{ const end = performance.now() + {1000 * HELD_S}; while (performance.now() < end); }}")
    until(lambda: 0.0 in ticks, "zero during the silence")
    until(lambda: here.effort("surge") == 0.5, "the effort of the held key")
    watch.cancel()
    page.keyboard.up("w")


def test_one_flies_and_hands_over_and_a_silent_one_loses_the_controls(here, page, monkeypatch):
    first = docked(page)
    second = here.fly()
    shows(second, "#lease", "flies")

    def explains():  # for 1.5 s after the key, which a busy machine may exceed before the text is read
        second.keyboard.up("w")
        second.keyboard.down("w")
        return "is flying" in second.inner_text("#hint")

    until(explains, "why the key moves nothing")
    second.wait_for_timeout(400)
    assert here.effort("surge") == 0.0  # viewers cannot control the vehicle
    second.keyboard.up("w")

    first.keyboard.down("w")
    until(lambda: here.effort("surge") == 0.5, "the pilot's effort")
    shows(first, "#hint", "Docked")
    shows(first, "#hint", "(R)")
    when(first, "station.telemetry.message.efforts[0] === 0.5")
    shown = first.locator(".bars").first.locator("output").all_inner_texts()
    assert set(shown) == {"0"}  # the thrusters are off
    second.click("#lease")
    first.wait_for_selector("#offer:not([hidden])")
    judge(first, "a request")
    assert first.locator("dialog[open]").count() == 0
    until(lambda: here.effort("surge") == 0.5, "the effort of the key that is still held")
    first.keyboard.up("w")
    first.click("#offer >> text=Hand over")
    when(second, "station.station.isPilot")
    when(first, "!station.station.isPilot")

    assert first.is_hidden("#banner")
    with monkeypatch.context() as patch:
        patch.setattr(here.station.sessions.node, "silence_s", lambda client: 4.0)  # as if her network had failed
        first.wait_for_selector("#banner:not([hidden])")
        shows(first, "#banner", "has been silent for 4 s: efforts are zero")
        shows(first, "#lease", "take over")
        assert second.is_hidden("#banner")
        first.click("#lease")
        when(first, "station.station.isPilot")
        first.wait_for_selector("#banner", state="hidden")
    first.keyboard.down("w")
    until(lambda: here.effort("surge") == 0.5, "the first pilot's effort again")
    first.keyboard.up("w")
    here.give(first, second)
    second.keyboard.down("w")
    until(lambda: here.effort("surge") == 0.5, "the second pilot's effort")
    second.close()
    until(lambda: here.effort("surge") == 0.0 and not here.station.lease.pilot, "a lost pilot's end")
    here.regain(first)


def test_a_pilot_whose_network_freezes_sees_it_and_may_take_the_controls_back(here, page):
    direct = here.url
    with Relay(int(direct.rpartition(":")[2])) as relay:
        here.url = relay.url
        frozen = here.fly(is_patient=False)
        here.url = direct
        here.give(page, frozen)
        frozen.evaluate("() => { AudioContext.prototype.createOscillator = () => { window.beeped = true; throw 0; }; }")
        frozen.keyboard.down("w")
        until(lambda: here.effort("surge") == 0.5, "an effort")
        relay.is_frozen = True
        frozen.wait_for_selector("#banner:not([hidden])")
        when(frozen, "/Nothing has arrived for [2-9] s/.test(document.querySelector('#banner').innerText)")
        shows(frozen, "#lease", "Controls lost")
        assert not frozen.evaluate("station.station.isPilot || station.pilot.isHeld")
        frozen.wait_for_selector(".panel .is-stale dd")
        when(frozen, "getComputedStyle(document.querySelector('#views')).filter === 'grayscale(1)' && window.beeped")
        judge(frozen, "frozen")
        until(lambda: here.effort("surge") == 0.0, "the vehicle's own stop")
        relay.cut()
        until(lambda: not here.station.lease.pilot, "the lost connection")
        relay.is_frozen = False
        frozen.wait_for_selector("#offer:not([hidden])")
        shows(frozen, "#offer", "You had the controls")
        assert "lost the connection" in page.wait_for_selector("#lease:has-text('take')").inner_text()
        frozen.click("#offer >> text=Take them back")
        when(frozen, "station.station.isPilot && !document.querySelector('.is-blind, #offer:not([hidden])')")
        here.give(frozen, page)
        frozen.context.close()
    here.complaints.clear()  # of the lost network


def test_keys_can_be_changed(here, page):
    page.keyboard.press("?")
    page.click("text=WASD")
    page.click("[aria-label^='Ahead:']")
    page.keyboard.press("o")
    page.keyboard.press("Escape")
    when(page, "station.pilot.mayAct")
    page.keyboard.down("o")
    page.keyboard.down("a")
    until(lambda: here.effort("surge") == 0.5 and here.effort("yaw") == 0.5, "the changed keys")
    page.reload()
    when(page, "globalThis.station?.bindings.keysOf('surge+')[0] === 'KeyO'")  # the bindings persist
    here.regain(page)
    here.settle(page)


def test_published_keys_add_up_until_the_opposite_key(here, page):
    docked(page)
    page.keyboard.press("?")
    page.click("text=Published")
    page.keyboard.press("Escape")
    when(page, "station.pilot.mayAct")
    page.keyboard.press("Space")
    page.keyboard.press("Space")
    page.keyboard.press("w")
    until(lambda: here.effort("heave") == 0.5 and here.effort("surge") == 0.5, "efforts without a held key")
    page.keyboard.press("b")
    until(lambda: here.effort("heave") == 0.0 and here.effort("surge") == 0.5, "the sum of two presses")
    page.keyboard.press("x")
    until(lambda: here.effort("surge") == 0.0, "zero")
    assert not here.rov.all_stopped
    page.keyboard.press("y")
    until(lambda: here.rov.released, "undocking")
    page.keyboard.press("?")
    page.click("#keys-dialog button:text-is('Standard')")
    page.keyboard.press("Escape")


def test_buttons_act(here, page):
    docked(page)
    assert page.inner_text("#sound") == "Sound off"
    docked_m = here.rov.pose.position_world_m
    assert page.is_visible("#undock")
    page.click("#dock")
    until(lambda: here.rov.released, "the release")
    page.wait_for_selector("#undock", state="hidden")
    assert np.hypot(*(here.rov.pose.position_world_m - docked_m)[:2]) < 0.2  # it falls; undocking moves it 7 m
    page.click("[aria-label='front light']")
    until(lambda: here.rov.lamps["front"].on, "light")
    elevation = here.rov.sonar.elevation_rad
    page.focus("#tilt-up")
    page.keyboard.press("Enter")
    until(lambda: here.rov.sonar.elevation_rad > elevation + 0.01, "the sonar's nose up")
    page.keyboard.press("ArrowUp")
    until(lambda: here.rov.cameras["front"].aim_rad[1] < -0.05, "the camera up")
    page.click("#pause")
    until(lambda: here.station.present().live.paused, "a pause")
    tick = here.station.present().live.simulator.tick
    page.click("#step")
    until(lambda: here.station.present().live.simulator.tick == tick + 1, "a step")
    saved = []
    page.on("download", lambda found: saved.append(found))
    page.keyboard.press("v")
    page.wait_for_timeout(100)
    page.click("#record")
    page.wait_for_timeout(1200)  # a browser hands over what it has recorded once a second
    page.click("#record")
    until(lambda: page.evaluate("1") and len(saved) == 2, "a picture, a video")
    files = {Path(found.suggested_filename).suffix: Path(found.path()).read_bytes() for found in saved}
    assert files[".png"].startswith(b"\x89PNG")
    assert files[".webm"].startswith(b"\x1a\x45\xdf\xa3")
    session = page.evaluate("station.station.state.session")
    page.evaluate("station.scene.camera.position.set(500, 500, 500), station.scene.controls.target.set(400, 400, 400)")
    page.keyboard.press("Escape")
    page.click("text=Restart from the beginning")
    when(page, f"station.station.state.session > {session} && station.telemetry.message?.released === false")
    when(page, "!document.querySelector('.panel .is-stale')")
    when(page, "station.scene.controls.target.distanceTo(station.scene.vessels.get('rov').group.position) < 1")


ENDINGS = {  # how to undo each; the lost connection is the last, since the page itself has closed it
    "dispatchEvent(new Event('blur'))": "",
    "document.querySelector('#help').click()": "document.querySelector('#keys-dialog').close()",
    "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
    "document.dispatchEvent(new Event('visibilitychange'))": "delete document.hidden",
    "station.station.bridge.close()": "",
}


def test_controls_are_let_go_and_values_grey(here, page):
    for ending, undo in ENDINGS.items():
        when(page, "station.pilot.mayAct")
        page.keyboard.down("w")
        until(lambda: here.effort("surge") == 0.5, "an effort")
        page.evaluate(ending)
        until(lambda: here.effort("surge") == 0.0, f"zero after {ending}")
        page.evaluate(undo)
        page.wait_for_timeout(300)
        assert here.effort("surge") == 0.0, f"{ending}: a key still held must be pressed again"
        page.keyboard.up("w")
    when(page, "document.querySelector('.panel .is-stale dd')")
    shows(page, "#banner", "trying again")
    here.complaints.clear()  # of the lost connection
