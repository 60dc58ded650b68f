"""The inspector on the station's page: parameters are found, changed, refused and reset."""

from browser import judge, shows, until, when


def test_the_inspector_finds_changes_and_resets_parameters(running):
    page, name = running.fly(), "rov.drag.linear.surge"
    own = running.station.present().live.simulator.parameters
    when(page, "station.station.isPilot")
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
    running.station.present().live.call(lambda sim: own.update({name: 50.0})).result()  # by another client
    when(page, f"document.querySelector('[aria-label=\"{name}, N s/m\"]').value === '50'")
    assert not running.complaints
