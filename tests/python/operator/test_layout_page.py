"""How the station's screen is divided, in a real browser: the picture first, all stop always."""

import pytest

from browser import judge, when

PICTURE = """() => {
  const canvas = document.querySelector('.view.is-large canvas');
  const { width, height } = canvas.getBoundingClientRect();
  const aspect = canvas.width / canvas.height;
  if (getComputedStyle(canvas).objectFit === 'cover') return width * height / innerWidth / innerHeight;
  return Math.min(width, height * aspect) * Math.min(height, width / aspect) / innerWidth / innerHeight;
}"""


def box(page, selector: str) -> dict[str, float]:
    return page.locator(selector).bounding_box()


def test_the_picture_has_most_of_the_screen_the_bar_one_row_and_type_the_size_that_the_browser_wants(page):
    page.evaluate("station.views.enlarge('front')")
    for width, height, least in ((1920, 1080, 0.7), (1280, 720, 0.55)):
        page.set_viewport_size({"width": width, "height": height})
        when(page, f"({PICTURE})() >= {least}")
        bar, stop = box(page, ".topbar"), box(page, "#all-stop")
        assert bar["height"] < 1.6 * stop["height"]
        assert all(box(page, f".topbar {each}")["x"] > stop["x"] for each in ("#dock", "#lease", "#menu"))
        assert box(page, "#menu")["x"] + box(page, "#menu")["width"] <= width
        large, small = box(page, ".view.is-large"), box(page, ".view:not(.is-large) >> nth=0")
        assert large["y"] + large["height"] <= small["y"] + 1
        assert large["x"] + large["width"] <= box(page, ".panel")["x"] + 1
    page.evaluate("document.documentElement.style.fontSize = '24px'")
    assert box(page, "#all-stop")["height"] == pytest.approx(1.5 * stop["height"], rel=0.05)
    page.evaluate("document.documentElement.style.fontSize = ''")


STOP_IS_ON_TOP = """() => {
  scrollTo(0, document.documentElement.scrollHeight);
  for (const each of document.querySelectorAll('.panel, .views')) each.scrollTo(0, each.scrollHeight);
  const stop = document.querySelector('#all-stop');
  const { left, top, right, bottom } = stop.getBoundingClientRect();
  const isInside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
  return isInside && document.elementFromPoint((left + right) / 2, (top + bottom) / 2) === stop;
}"""
SCREENS = {(390, 844): 0.5, (844, 390): 0.99, (1024, 768): 0.7, (820, 1180): 0.7}
"""Hand-held screens, and the least part of each that the picture has."""
PHONE_S_CHART = ("#all-stop", "#unfold", "#lease", ".lamps", ".is-large > .chart-tools", ".is-large > canvas")
IN_HANDS = ("#all-stop", "#unfold", "#lease", ".stick.left", ".stick.right", ".view.is-large .name")


def hold(here, size: tuple[int, int], **options):
    """Open a watcher's page on a hand-held screen."""
    return here.fly(viewport={"width": size[0], "height": size[1]}, has_touch=True, is_mobile=True, **options)


def turn(page, size: tuple[int, int]) -> None:
    """Resize a page; return when it has found its new layout."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")


def the_chart_s_tools_do_not_lie_over_it(held, width: int) -> None:
    held.evaluate("station.views.enlarge('chart')")
    assert nothing_overlaps(held, *(each for each in PHONE_S_CHART if held.is_visible(each)))
    seen, view = box(held, ".is-large > canvas"), box(held, ".view.is-large")
    assert seen["height"] > 0.8 * view["height"] and seen["width"] == pytest.approx(view["width"])
    last = held.locator(".chart-tools button").last
    last.scroll_into_view_if_needed()
    tools, button = box(held, ".is-large > .chart-tools"), last.bounding_box()
    assert button["x"] + button["width"] <= tools["x"] + tools["width"] + 1 <= width


def test_on_hand_held_screens_the_picture_is_the_ground_and_only_the_pilot_has_sticks(here, page):
    held = hold(here, (390, 844))
    for size, least in SCREENS.items():
        turn(held, size)
        held.evaluate("station.views.enlarge('front')")
        when(held, "station.views.largeView.picture?.drawn > 0")
        when(held, f"({PICTURE})() >= {least}")
        assert held.is_visible("#all-stop") and not held.is_visible("#dock") and not held.is_visible(".stick.left")
        if min(size) < 400:
            the_chart_s_tools_do_not_lie_over_it(held, size[0])
            judge(held, f"chart on a phone, {size}")
    held.evaluate("station.views.enlarge('front')")
    here.give(page, held)
    for size in SCREENS:
        turn(held, size)
        held.wait_for_selector(".stick.left")
        assert held.is_visible(".stick.right") and held.evaluate(STOP_IS_ON_TOP), size
        assert nothing_overlaps(held, *IN_HANDS), size
        judge(held, f"in hands, {size}")
        held.click("#unfold")
        assert held.is_visible("#dock") and held.is_visible("#menu") and not held.is_visible(".stick.left")
        judge(held, f"unfolded, {size}")
        assert held.evaluate(STOP_IS_ON_TOP), size
        held.click(".view:not(.is-large) .swap >> nth=-1")
        held.click("#inspect")
        assert held.evaluate(STOP_IS_ON_TOP), size
        held.evaluate("document.querySelector('#inspect').click()")  # over which the inspector may lie
        held.click("#unfold")
        held.evaluate("station.views.enlarge('front')")
    held.context.close()
    here.regain(page)


def nothing_overlaps(page, *selectors: str) -> bool:
    boxes = [box(page, each) for each in selectors]
    return not any(
        a["x"] < b["x"] + b["width"]
        and b["x"] < a["x"] + a["width"]
        and a["y"] < b["y"] + b["height"]
        and b["y"] < a["y"] + a["height"]
        for k, a in enumerate(boxes)
        for b in boxes[:k]
    )


def test_all_stop_is_reachable_in_windows_of_any_size(page):
    for size in ((360, 640), (520, 900), (700, 500), (900, 600), (1024, 400), (1280, 720)):
        turn(page, size)
        assert page.evaluate(STOP_IS_ON_TOP), size
        if page.is_visible("#unfold"):
            page.click("#unfold")
            assert page.evaluate(STOP_IS_ON_TOP), size
            page.click("#unfold")


def test_every_contrast_over_pictures_is_computed(page):
    turn(page, (1280, 720))
    for theme in ("dark", "light", "night"):
        page.evaluate(f"document.documentElement.dataset.theme = '{theme}', dispatchEvent(new Event('theme'))")
        for view in ("front", "chart", "scene", "fan"):
            page.evaluate(f"station.views.enlarge('{view}')")
            judge(page, f"{view}, {theme}", "#views")
    page.evaluate("document.documentElement.dataset.theme = 'dark', dispatchEvent(new Event('theme'))")
