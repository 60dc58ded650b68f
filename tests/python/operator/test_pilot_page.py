"""Holds, display, warnings and parameters as the pilot sees them, in a real browser: one page for all of it."""

from browser import judge, shows, until, when


def test_keys_and_buttons_hold_and_a_lost_sensor_is_shown(here, page):
    live, holds = here.station.present().live, here.rov.holds
    page.keyboard.press("h")
    page.keyboard.press("z")
    until(lambda: set(holds.targets) == {"heading", "depth"} and all(holds.targets.values()), "two holds")
    page.wait_for_selector("#hold-heading[aria-pressed=true]")
    judge(page, "holds")
    page.evaluate("station.pilot.answers_ms = []")
    page.click("#hold-speed")
    until(lambda: "speed" in holds.targets, "a speed hold")
    when(page, "station.pilot.answers_ms.length > 2 && !station.pilot.isHeld")  # it sends zeros, by which it is known
    page.click("#help")
    until(lambda: set(holds.targets) == {"heading", "depth"}, "the end of the speed hold behind a dialog")
    page.keyboard.press("Escape")
    live.command("inject_fault", kind="sensor", sensor="depth", mode="off", name="no_depth").result()
    when(page, "station.telemetry.message.hold_note.includes('depth hold ended')")
    page.wait_for_selector("#hold-depth[aria-pressed=false]")
    live.command("end_fault", name="no_depth").result()
    page.click("#hold-heading")
    until(lambda: not holds.targets, "no hold")


PAD = """(changes) => {
  window.pad = {connected: true, index: 0, id: 'pad', mapping: '', axes: [0, 0, 0, 0],
                buttons: Array.from({length: 17}, () => ({pressed: false, value: 0})), ...window.pad, ...changes};
  navigator.getGamepads = () => [window.pad];
}"""


def test_a_gamepad_drives_when_it_is_known_and_has_been_centred(here, page):
    def axes(*values: float) -> None:
        page.evaluate(PAD, {"axes": values})

    axes(0.5, 0, 0, -1)  # at rest, of a pad whose layout is unknown
    when(page, "document.querySelector('#toast').textContent.includes('layout is unknown')")
    assert not here.rov.effort.any()
    page.evaluate(PAD, {"mapping": "standard", "id": "usual"})
    when(page, "document.querySelector('#toast').textContent.includes('release its sticks')")
    assert not here.rov.effort.any()
    axes(0, 0, 0, 0)
    when(page, "station.pilot.gamepads.stateOf(window.pad) === 'armed'")
    axes(0, 0, 0, -1)
    until(lambda: here.effort("surge") == 0.5, "the right stick, ahead")
    axes(1, 0, 0, 0)
    until(lambda: here.effort("surge") == 0.0 and here.effort("yaw") == -0.5, "the left stick, to starboard")
    axes(0.05, 0, 0, 0)
    until(lambda: here.effort("yaw") == 0.0, "a stick at rest, which is never quite 0")

    page.evaluate(PAD, {"mapping": "", "id": "odd", "axes": [0.5, -1]})
    page.keyboard.press("Escape")
    page.click("#menu-dialog >> text=Gamepad")
    page.click("[aria-label='Assign: Up']")
    axes(0.5, 1)  # a trigger as an axis, which rests at its end
    page.wait_for_selector("text=Up: axis 1")
    axes(0.5, -1)
    page.click("#gamepad-dialog button:text-is('Calibrate')")
    page.wait_for_timeout(100)
    axes(0.5, 1)
    page.wait_for_timeout(200)
    axes(0.5, -1)
    page.click("#gamepad-dialog button:text-is('Done')")
    judge(page, "gamepad")
    page.click("#gamepad-dialog [aria-label=Close]")
    when(page, "station.pilot.gamepads.stateOf(window.pad) === 'armed'")
    assert not here.rov.effort.any()
    axes(0.5, 1)
    until(lambda: here.effort("heave") == 0.5, "the trigger, up")
    axes(0.5, -1)
    until(lambda: not here.rov.effort.any(), "rest")
    page.evaluate("navigator.getGamepads = () => []")


def test_the_display_follows_the_camera_and_stays_off_fixed_ones(here, page):
    page.keyboard.press("1")
    shown = "station.views.largeView.hud.shown"
    when(page, f"{shown}?.axis && Math.abs({shown}.axis.up_deg + 8) < 2")  # as the camera is mounted, and a little roll
    page.keyboard.down("ArrowDown")
    when(page, f"{shown}.axis.down_deg > 20")
    page.keyboard.up("ArrowDown")
    until(lambda: abs(here.rov.cameras["front"].aim_rad[1]) > 0.2, "the motor")
    page.wait_for_timeout(300)
    kinds = page.evaluate("station.views.names.map((name) => [name, Boolean(station.views.hudOf(name))])")
    assert {name for name, has in kinds if has} == {"front", "down"}
    page.evaluate("station.station.setView({ name: 'front', width: 320 })")  # as if the machine were too slow for more
    shows(page, ".view.is-large .over", "the machine is busy")
    page.evaluate("station.station.setView({ name: 'front', width: 0 })")
    when(page, "document.querySelector('.view.is-large .over').hidden")


def test_a_collision_stays_until_it_is_acknowledged_and_lengths_and_colours_change(here, page):
    live = here.station.present().live
    live.command("place", vehicle="rov", position_world_m=[1.2, 0.0, -4.4]).result()
    page.keyboard.down("w")
    when(page, "document.querySelector('#lamp-collision').dataset.on === 'alarm'")
    page.keyboard.up("w")
    live.command("place", vehicle="rov", position_world_m=[-4.0, 0.0, -2.5]).result()
    when(page, "station.telemetry.message.collision_warning === false")
    assert page.get_attribute("#lamp-collision", "data-on") == "alarm"
    page.click("#alarm-log summary")
    shows(page, "#alarm-log", "Collision")
    page.keyboard.press("Escape")
    page.click("text=feet")
    page.click("text=night")
    page.click("text=Resume")
    when(page, "document.querySelector('.big-values').textContent.includes('ft')")
    tape = "station.views.largeView.hud.shown.tapes.DEPTH"
    when(page, f"Math.abs({tape} * 0.3048 - station.telemetry.message.depth) < 0.05")
    judge(page, "night, flying")
    page.click("#acknowledge")
    when(page, "document.querySelector('#lamp-collision').dataset.on === 'off'")


def test_the_inspector_finds_changes_and_resets_parameters(here, page):
    name = "rov.drag.linear.surge"
    own = here.station.present().live.simulator.parameters
    page.click("#inspect")
    page.fill("[aria-label='Search parameters']", "drag linear surge")
    box = page.locator(f"[aria-label='{name}, N s/m']")
    box.fill("40")
    box.press("Enter")
    until(lambda: own[name] == 40.0, "the change")
    when(page, "document.querySelectorAll('.parameter[data-changed]').length === 1")
    judge(page, "inspector")
    box.fill("-1")
    box.press("Enter")  # is refused, and the field returns to the value that holds
    when(page, f"document.querySelector('[aria-label=\"{name}, N s/m\"]').value === '40'")
    shows(page, "#toast", "must be in")
    assert own[name] == 40.0
    page.locator(f"[aria-label='{name}, slider']").press("ArrowRight")
    until(lambda: 40.0 < own[name] < 41.0, "the slider")
    slider = page.locator(f"[aria-label='{name}, slider']")
    slider.press("Home")  # from a tenth to ten times the scenario's value
    until(lambda: own[name] == 2.94, "the slider's left end")
    slider.press("End")
    until(lambda: own[name] == 294.0, "its right end")
    for word, found in (("turbidity", "optics.visibility_m"), ("wind", "optics.wind_m_s"), ("gravity", "rov.mass_kg")):
        page.fill("[aria-label='Search parameters']", word)
        page.wait_for_selector(f"[aria-label^='{found},']:visible")
    page.fill("[aria-label='Search parameters']", name)
    page.click(f"[aria-label='Reset {name}']")
    until(lambda: own[name] == 29.4, "the reset")
    here.station.present().live.call(lambda sim: own.update({name: 50.0})).result()  # by another client
    when(page, f"document.querySelector('[aria-label=\"{name}, N s/m\"]').value === '50'")
    here.station.present().live.command("reset_parameters", name=name).result()
    page.click("#inspect")


def test_a_message_draws_again_what_shows_it_and_nothing_around_it(page):
    drawn = page.evaluate("""async () => {
      const { panel, recorder, telemetry } = station;
      const shown = [panel.alarms, panel.arm, panel.exercise, panel.inspection, panel.link, panel.tether, recorder];
      const times = shown.map(() => 0);
      for (const [k, { constructor }] of shown.entries())
        shown[k].view = (...given) => (times[k] += 1, constructor.prototype.view.apply(shown[k], given));
      telemetry.dispatchEvent(new Event('change'));
      for (let k = 0; k < 10; k += 1) await null; // it is drawn before the next message
      for (const each of shown) delete each.view;
      return times;
    }""")
    assert drawn == [1, 1, 0, 0, 0, 0, 0]  # the recorder's buttons are in the bar
