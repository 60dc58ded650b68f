"""The theme night in a real browser: one ramp of red of bounded luminance on every page, in all that is drawn there."""

import io
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from browser import desk, judge, when
from uwsim.operator import station
from uwsim.operator.map_view import MapViewer
from uwsim.operator.station.flights.flights import Bounds

LUMINANCE_MAX = 0.51  # of the alarm's colour; the pictures' bound is that of text, 0.29
HUE_DEG = 29.2
WHITEST = (0.66, 0.61)  # green and blue of the palest colour, as parts of its red
ROUNDING = 0.03
TO_LMS = np.array([
    [0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
])  # fmt: skip
TO_OKLAB = np.array([
    [0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
])  # fmt: skip


def linear(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def luminance(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the relative luminance of WCAG 2.1."""
    return linear(srgb) @ [0.2126, 0.7152, 0.0722]


def hold(page, what: str) -> None:
    """Assert that a page's picture has no other hue, no grey and no white, and stays below the bound of luminance."""
    pixels = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGBA")).view(np.uint32)
    colours = np.unique(pixels).view(np.uint8).reshape(-1, 4)[:, :3] / 255.0
    red, green, blue = colours.T
    wrong = (green > WHITEST[0] * red + ROUNDING) | (blue > WHITEST[1] * red + ROUNDING)
    assert not wrong.any(), f"{what}: {colours[wrong][:9]}"
    assert luminance(colours).max() <= LUMINANCE_MAX, f"{what}: {luminance(colours).max():.3f}"
    assert page.locator("[title]").count() == 0, f"{what}: the system's tips are white"


def at_night(url: str) -> dict[str, object]:
    """Return the options of a browser context in which the page at an address has the theme night."""
    kept = [{"name": "uwsim.theme", "value": "night"}]
    return {"storage_state": {"cookies": [], "origins": [{"origin": url.rstrip("/"), "localStorage": kept}]}}


def test_the_tokens_are_one_ramp_in_oklch_and_no_sheet_has_a_colour_beside_them():
    page = Path(station.__file__).parent / "page"
    sheets = {each.name: each.read_text() for each in page.glob("style/*.css")}
    dark, light, night = re.findall(r"(?m)^:root(?:\[data-theme='\w+'\])? \{(.*?)^\}", sheets["base.css"], re.DOTALL)
    named = [dict(re.findall(r"--([\w-]+): (#\w{6}|rgb.*);", each)) for each in (dark, light, night)]
    pictures = {name for name in named[0] if name.startswith("chart-")}  # which the night's filter covers
    assert named[1].keys() <= named[0].keys() == named[2].keys() | pictures
    assert named[2].pop("veil").startswith("rgb(0 0 0")
    colours = np.array([[int(code[k : k + 2], 16) for k in (1, 3, 5)] for code in named[2].values()]) / 255.0
    assert luminance(colours).max() == luminance(colours)[list(named[2]).index("alarm")] <= LUMINANCE_MAX
    _, a, b = TO_OKLAB @ np.cbrt(TO_LMS @ linear(colours).T)
    sure = np.hypot(a, b) > 0.06  # hues of colours near black are rounded away
    assert np.abs(np.degrees(np.arctan2(b, a)) - HUE_DEG)[sure].max() < 1.5
    sheets["base.css"] = sheets["base.css"].replace(dark, "").replace(light, "").replace(night, "")
    for name, text in sheets.items():
        for rule, body in re.findall(r"([^{}]*)\{([^{}]*)\}", text):
            own = re.findall(r"#[0-9a-f]{3,8}\b|(?:rgb|hsl|oklch)\(.*?\)|: (?:white|red);", body)
            if not re.search(r"\.preview .*\.mark|\.tether \.scale i", rule):  # which the filter covers, too
                assert all(each.startswith("rgb(0 0 0 /") for each in own), f"{name}: {rule}: {own}"
    assert all("night.css" in (page / name).read_text() for name in ("index.html", "map.html"))


def test_the_start_screen_the_editor_the_station_its_dialogs_and_a_replay(browser, tmp_path):
    with desk(browser, tmp_path, keep_flights=Bounds(3)) as here:
        page = here.open(**at_night(here.url))
        page.wait_for_selector(".preview:not([hidden])")
        when(page, "document.querySelector('.preview img').complete")
        hold(page, "start")
        judge(page, "start at night")
        page.focus("#field-scenario")
        page.keyboard.press("Space")
        page.wait_for_timeout(500)
        page.keyboard.press("ArrowDown")
        hold(page, "a list")
        page.keyboard.press("Escape")
        page.select_option("#field-scenario", "lake")
        page.wait_for_selector("img[alt*=lake]")
        page.click("button.edit")
        when(page, "document.querySelector('.editor-ground canvas') && station.editor.chart.frame.scale > 0")
        page.wait_for_timeout(500)
        hold(page, "editor")
        page.get_by_role("button", name="3D view").click()
        when(page, "station.editor.scene?.gate.frames > 1")
        page.wait_for_timeout(500)
        hold(page, "editor in 3D")
        page.locator(".editor-scene").press("Escape")
        page.wait_for_selector("#editor-dialog", state="hidden")

        page.select_option("#field-scenario", "pool")
        page.click("button[type=submit]")
        here.settle(page)
        here.station.present().live.rov.undock()
        when(page, "station.views.largeView.picture?.drawn > 0 && station.scene.gate.frames > 1")
        for view in ("chart", "scene", "fan", "front"):
            page.evaluate(f"station.views.enlarge('{view}')")
            page.wait_for_timeout(500)
            hold(page, view)
        page.click("#inspect")
        page.locator("#inspector summary", has_text="optics").click()
        page.wait_for_selector("#inspector input[type=range]:visible")
        hold(page, "parameters")
        judge(page, "parameters at night")
        page.click("#inspect")
        page.click("#menu")
        hold(page, "menu")
        page.click("text=Quit to the start screen")
        page.click("#flights li button:not(:disabled)")
        page.wait_for_selector("#timeline:not([hidden])")
        when(page, "station.telemetry.message && station.views.largeView.picture?.drawn > 0")
        page.wait_for_timeout(500)
        hold(page, "replay")
    assert not here.complaints


def test_a_map(browser, slope):
    with MapViewer(slope, "slope.bt") as viewer:
        page = browser.new_page(viewport={"width": 1000, "height": 700}, **at_night(viewer.url))
        page.goto(viewer.url)
        when(page, "globalThis.mapView?.voxels.pointCount > 0")
        page.wait_for_timeout(500)
        hold(page, "map")
        page.context.close()
