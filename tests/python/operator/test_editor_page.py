"""The scene editor in a real browser: by mouse and by keys, saved, started, and put into a paused simulator."""

import base64
from typing import Annotated

import numpy as np
import pytest
import trimesh

from browser import desk, judge, shows, until, when
from uwsim.operator.station.editor.forms import OTHER_SCHEMAS, forms
from uwsim.scenario import load
from uwsim.scenario.spec.fields import InRange
from uwsim.scenario.spec.water_parts import Wind

SENT = "station.editor.state?.parts?.find(({{ name }}) => name === '{0}')?.values.{1}"


def chart_pixel(page, place):
    x, y = page.evaluate("(place) => station.editor.chart.frame.at(place)", list(place))
    box = page.locator(".editor-canvas").bounding_box()
    return box["x"] + x, box["y"] + y


def scene_pixel(page, place):
    return page.evaluate(
        """(place) => {
            const { camera, canvas } = station.editor.scene;
            const at = camera.position.clone().fromArray(place).project(camera);
            const { x, y, width, height } = canvas.getBoundingClientRect();
            return [x + ((at.x + 1) / 2) * width, y + ((1 - at.y) / 2) * height];
        }""",
        list(place),
    )


def sent(page, name, value):
    return page.evaluate(SENT.format(name, value))


@pytest.fixture(scope="module")
def here(browser, tmp_path_factory):
    with desk(browser, tmp_path_factory.mktemp("editor")) as found:
        yield found
    assert not found.complaints


@pytest.fixture(scope="module")
def start_page(here):
    page = here.open(viewport={"width": 1280, "height": 720})
    page.wait_for_selector(".preview:not([hidden])")
    return page


@pytest.fixture
def page(start_page):
    """The page with the editor opened: the scenario as it is kept, the whole chart, nothing chosen."""
    page = start_page  # closed and opened again in the same frame
    page.evaluate("document.querySelector('#editor-dialog').close(), document.querySelector('button.edit').click()")
    when(page, "document.querySelector('#editor-dialog').open && station.editor.state?.is_open")
    when(page, "station.editor.selected === -1")
    page.evaluate("station.editor.state.is_saved || station.editor.acts.revert()")
    when(page, "station.editor.state.is_saved")
    page.evaluate("station.editor.view === station.editor.chart || station.editor.acts.turn()")
    page.evaluate("station.editor.acts.fit()")
    for section in ("lamps", "obstacles"):  # with its first kind
        page.locator(".editor-bar select").first.select_option(section)
    when(page, "station.editor.chart.frame.scale > 5")
    return page


def add(page, section="", kind=""):
    for label, value in (("What to add", section), ("Kind", kind)):
        if value:
            page.get_by_label(label).select_option(value)
    page.click(".editor-bar >> text=Add")


def dragged(page, start, end):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=8)
    page.mouse.up()


def test_a_new_scene_is_built_saved_and_chosen_on_the_start_screen(start_page, here):
    page = start_page
    page.evaluate("document.querySelector('#editor-dialog').close()")
    page.click("[data-task=build]")
    page.click("button.new-scene")
    when(page, "document.querySelector('#editor-dialog').open && station.editor.state?.name === 'scene'")
    add(page, "life")
    when(page, SENT.format("school", "position_m[2] === -1"))
    page.get_by_label("Save as").fill("bay")
    page.keyboard.press("Control+s")
    when(page, "station.editor.state.is_saved")
    page.keyboard.press("Escape")
    when(page, "document.querySelector('#field-scenario').value === 'bay.yaml'")
    assert load(here.station.sessions.folder / "bay.yaml").life[0].name == "school"
    page.select_option("#field-scenario", "pool")
    page.click("[data-task=fly]")


def test_an_exercise_is_made_by_keys_alone_and_flown_from_the_start_screen(page, here):
    def add(kind):
        for label, word in (("What to add", "Goals"), ("Kind", kind)):
            choice = page.get_by_label(label, exact=True)
            choice.press("Home")
            words = choice.locator("option").all_inner_texts()
            for _ in words[: words.index(word)]:
                choice.press("ArrowDown")  # letters choose by the pace at which they are typed, too
        page.locator(".editor-canvas").press("a")
        when(page, f"station.editor.part?.section === 'goals' && station.editor.part.kind === '{kind}'")

    add("reach")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("PageDown")
    when(page, SENT.format("reach", "position_m.join() === '1,0,-1.5'"))
    page.evaluate("station.editor.pick(station.editor.state.parts.findIndex(({ name }) => name === 'box'))")
    add("hold")  # where the chosen body is
    assert sent(page, "hold", "position_m") == [3, 0, -1]
    assert sent(page, "hold", "after") == "reach"
    page.keyboard.press("q")
    when(page, SENT.format("hold", "heading_deg === 5"))
    assert page.locator("select[aria-label=after] option").all_inner_texts()[1:] == ["reach"]
    page.keyboard.press(",")
    when(page, "station.editor.state.parts.filter(({ section }) => section === 'goals')[0].kind === 'hold'")
    assert sent(page, "reach", "after") == "hold"
    page.keyboard.press("Control+z")
    when(page, SENT.format("hold", "after === 'reach'"))
    shows(page, ".editor-message", "Its exercise can be flown")
    judge(page, "goals")
    page.get_by_label("Save as").fill("drill")
    page.keyboard.press("Control+s")
    when(page, "station.editor.state.is_saved")
    page.keyboard.press("Escape")
    page.locator("[data-task=train]").press("Enter")
    own = page.locator("[data-exercise='drill.exercise.yaml']")
    assert "New exercise" in own.inner_text()
    judge(page, "an exercise of one's own")
    own.get_by_role("button").press("Enter")
    when(page, "station.station.isPilot && station.telemetry.message && station.station.awaitsBegin")
    page.keyboard.press("Enter")
    until(lambda: here.station.present().judged.course.has_begun, "an attempt")
    assert [goal.kind for goal in here.station.present().judged.course.exercise.goals] == ["reach", "hold"]
    beds = "performance.getEntriesByType('resource').filter(({ name }) => name.endsWith('/scene/terrain.f32'))"
    when(page, f"{beds}.length > 1")
    when(page, "[...station.scene.vessels.values()].every(({ group }) => group.children.length > 1)")
    here.station.sessions.quit()
    until((here.station.sessions.folder / "sheet-1/score.json").is_file, "a score sheet")
    page.wait_for_selector(".preview:not([hidden])", state="attached")
    page.locator("[data-task=fly]").press("Enter")
    page.select_option("#field-scenario", "pool")


def test_hills_and_trenches_are_drawn_on_the_bed_by_a_brush_and_by_keys(page):
    depth = """([x, y]) => {
        const { rows, columns, west_m, south_m, spacing_m: [dx, dy] } = station.editor.state.grid;
        const at = [Math.round((y - south_m) / dy), Math.round((x - west_m) / dx)];
        return station.editor.heights[at[0] * columns + at[1]];
    }"""
    view = page.evaluate("station.editor.view.frame.scale")
    before = page.evaluate(depth, [-5, 5])
    page.locator(".editor-canvas").press("b")
    page.get_by_label("Height of a stroke").fill("3")
    dragged(page, chart_pixel(page, (-5, 2)), chart_pixel(page, (-5, 8)))
    when(page, "station.editor.part?.section === 'strokes'")
    strokes = "station.editor.state.parts.filter(({ section }) => section === 'strokes')"
    line = page.evaluate(f"{strokes}[0].values.line_m")
    np.testing.assert_allclose([line[0], line[-1]], [[-5, 2], [-5, 8]], atol=2.6)
    when(page, f"Math.abs(({depth})([-5, 5]) - {before} - 3) < 0.3")
    assert page.evaluate("station.editor.view.frame.scale") == view  # the view of a person who draws stays
    judge(page, "the brush")
    page.locator(".editor-canvas").press("b")  # lower
    page.locator(".editor-canvas").press("]")
    page.locator(".editor-canvas").press("a")  # at the mark or in the middle
    when(page, f"{strokes}.length === 2")
    assert page.evaluate(f"{strokes}[1].values") == {
        "line_m": [page.evaluate("station.editor.view.middle.map((each) => Math.round(10 * each) / 10)")],
        "width_m": 12.5, "height_m": -3,
    }  # fmt: skip
    page.locator(".editor-canvas").press("ArrowLeft")
    when(page, f"{strokes}[1].values.line_m[0][0] <= -0.9")
    for _ in range(3):
        page.keyboard.press("Control+z")
    when(page, f"{strokes}.length === 0 && Math.abs(({depth})([-5, 5]) - {before}) < 1e-4")
    page.evaluate("while (station.editor.brush.isOn) station.editor.brush.next()")


def test_in_3d_the_same_parts_are_moved_turned_added_and_undone_and_a_reload_keeps_them(page):
    page.locator(".editor-canvas").press("v")
    when(page, "station.editor.scene.gate.frames > 0 && station.editor.scene.isWhole")
    page.evaluate("station.editor.scene.fit()")
    height = "station.editor.scene.canvas.clientHeight"
    tall = page.evaluate(height)
    page.mouse.move(*scene_pixel(page, (3, 0, -4)))
    page.mouse.down()
    shows(page, ".editor-message", "No mistakes")  # beside the pointer that holds a part: nothing moves
    assert page.evaluate(height) == tall
    page.mouse.move(*scene_pixel(page, (4, 2, -4)), steps=3)
    page.mouse.up()
    when(page, SENT.format("box", "position_m[1] > 1.8"))
    np.testing.assert_allclose(sent(page, "box", "position_m"), [4, 2, -4.5], atol=0.2)
    when(page, "station.editor.scene.isWhole")
    page.mouse.wheel(0, -100)
    when(page, SENT.format("box", "yaw_pitch_roll_deg?.[0] === 5"))
    page.keyboard.press("Control+z")
    when(page, "!(" + SENT.format("box", "yaw_pitch_roll_deg") + ")")
    page.mouse.click(*scene_pixel(page, (-3, -4, -5)))
    when(page, "station.editor.parts.mark")
    add(page, kind="cylinder")
    when(page, SENT.format("cylinder", "position_m"))
    np.testing.assert_allclose(sent(page, "cylinder", "position_m"), [-3, -4, 0], atol=0.2)
    page.locator(".editor-scene").press("PageUp")
    when(page, SENT.format("cylinder", "position_m[2] === 0.5"))
    page.keyboard.press("F2")
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type("buoy")
    page.keyboard.press("Enter")
    when(page, SENT.format("buoy", "radius_m"))
    judge(page, "the editor in 3D")
    page.click(".editor-bar >> text=Delete")
    when(page, "!(" + SENT.format("buoy", "radius_m") + ")")

    page.reload()
    page.wait_for_selector(".preview:not([hidden])")
    page.click("text=Edit this scenario")
    shows(page, ".editor-message", "not saved")
    assert sent(page, "box", "position_m[1]") > 1.8 and page.evaluate("station.editor.state.can_undo")
    page.evaluate("station.station.bridge.drop()")  # a lost connection
    when(page, "station.station.id && station.editor.state.by")
    page.locator(".editor-canvas").press("Control+z")
    when(page, SENT.format("buoy", "radius_m"))
    page.click("text=Revert")
    when(page, "station.editor.state.is_saved && " + SENT.format("box", "position_m[1] === 0"))


def test_a_prop_is_added_where_one_looks_stands_on_the_bed_and_is_seen_itself(page):
    page.get_by_label("What to add").select_option("props")
    page.locator(".editor-canvas").press("v")
    when(page, "station.editor.scene?.gate.frames > 0")
    page.mouse.click(*scene_pixel(page, (-3, -4, -5)))
    when(page, "station.editor.parts.mark")
    page.click(".editor-bar >> text=Add")
    when(page, "station.editor.part?.section === 'props' && station.editor.scene.isWhole")
    np.testing.assert_allclose(sent(page, "drum", "position_m"), [-3, -4, -5], atol=0.2)
    shows(page, ".editor-message", "No mistakes")
    page.evaluate("station.editor.change({ colour: [0.02, 0.2, 0.5] })")
    when(page, SENT.format("drum", "colour") + " && station.editor.scene.isWhole")
    points, colours = page.evaluate(
        """() => {
            const solids = [];
            station.editor.scene.scene.traverse(({ material, geometry: { attributes } = {} }) => {
                if (material?.type === 'MeshLambertMaterial' && attributes.color) solids.push(attributes);
            });
            return [Array.from(solids.at(-1).position.array), Array.from(solids.at(-1).color.array)];
        }"""
    )
    points, colours = np.reshape(points, (-1, 3)), np.reshape(colours, (len(points) // 3, -1))[:, :3]
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.6, 0.6, 0.3], atol=0.03)  # a drum, no mark
    assert points[:, 2].min() == pytest.approx(-5, abs=0.01) and np.unique(colours, axis=0).tolist() == [[5, 51, 128]]


def test_a_mesh_is_dropped_on_the_chart_and_another_chosen_by_its_still(page, here, tmp_path):
    content = base64.b64encode(trimesh.creation.box((2, 1, 1)).export(file_type="glb")).decode()
    at = chart_pixel(page, (-3, 4))
    page.evaluate(
        """([content, x, y]) => {
            const bytes = Uint8Array.from(atob(content), (each) => each.charCodeAt(0));
            const dataTransfer = new DataTransfer();
            dataTransfer.items.add(new File([bytes], 'crate.glb'));
            const more = { bubbles: true, cancelable: true, clientX: x, clientY: y, dataTransfer };
            document.elementFromPoint(x, y).dispatchEvent(new DragEvent('drop', more));
        }""",
        [content, *at],
    )
    when(page, SENT.format("mesh", "file === 'meshes/crate.glb'"))
    np.testing.assert_allclose(sent(page, "mesh", "position_m"), [-3, 4, 0], atol=0.2)
    assert (here.station.sessions.folder / "meshes/crate.glb").is_file()
    still = ".editor-stills img[alt='{}']"
    page.wait_for_selector(still.format("crate.glb"))
    when(page, "[...document.querySelectorAll('.editor-stills img')].slice(0, 4).every((each) => each.naturalWidth)")
    judge(page, "the list of meshes")
    page.click(still.format("bluerov2.glb"))
    when(page, SENT.format("mesh", "file === 'meshes/bluerov2.glb'"))
    path = tmp_path / "broken.stl"
    path.write_bytes(b"solid a\nendsolid a\n")
    page.set_input_files(".editor-upload input", path)
    page.wait_for_selector(".editor-field[data-wrong] .wrong:has-text('broken.stl')")


def test_a_loose_body_is_added_moved_and_named_as_an_obstacle_is(page):
    page.get_by_label("What to add").select_option("objects")
    page.get_by_label("Kind").select_option("sphere")
    page.locator(".editor-canvas").press("a")
    body = "station.editor.part?.section === 'objects' && station.editor.part.values"
    when(page, f"({body})['shape.name'] === 'sphere'")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("PageUp")
    when(page, f"JSON.stringify(({body})['shape.position_m']) === '[-1,0,0.5]'")
    page.keyboard.press("F2")
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type("ball")
    page.keyboard.press("Enter")
    when(page, "station.editor.state.parts.some(({ section, name }) => section === 'objects' && name === 'ball')")
    judge(page, "a loose body")


def test_with_nothing_chosen_the_chart_pans_and_marks_and_add_lands_where_one_looks(page):
    def added(kind: str) -> list[float]:
        add(page, kind=kind)
        when(page, SENT.format(kind, "position_m"))
        return sent(page, kind, "position_m")[:2]

    before = np.array(page.evaluate("station.editor.chart.frame.middle"))
    dragged(page, start := chart_pixel(page, (-3, 3)), np.add(start, (60, -30)).tolist())  # in the survey
    middle = np.array(page.evaluate("station.editor.chart.frame.middle"))
    scale = page.evaluate("station.editor.chart.frame.scale")
    np.testing.assert_allclose(middle - before, [-60 / scale, -30 / scale], atol=0.01)
    np.testing.assert_allclose(added("sphere"), middle, atol=0.06)
    for place in ((-3, 3), (-3, -3)):  # a part is chosen, then none
        page.mouse.click(*chart_pixel(page, place))
        when(page, "station.editor.selected === -1 && station.editor.parts.mark")
        np.testing.assert_allclose(page.evaluate("station.editor.parts.mark"), place, atol=0.1)
    np.testing.assert_allclose(added("cylinder"), (-3, -3), atol=0.1)
    page.mouse.click(*chart_pixel(page, (-4, 1)))
    when(page, "station.editor.part?.section === 'survey'")
    page.mouse.click(*chart_pixel(page, (-3, 3)))
    when(page, "station.editor.selected === -1 && station.editor.parts.mark")
    for _ in range(8):
        page.locator(".editor-canvas").press("+")
    assert not page.evaluate("station.editor.chart.sees(station.editor.parts.mark)")
    np.testing.assert_allclose(added("ring"), page.evaluate("station.editor.chart.frame.middle"), atol=0.06)

    page.locator(".editor-canvas").press("Escape")
    page.wait_for_selector("#editor-dialog", state="hidden")
    page.click("text=Edit this scenario")
    when(page, "document.querySelector('#editor-dialog').open && station.editor.selected === -1")
    page.locator(".editor-canvas").press("v")
    when(page, "station.editor.scene?.gate.frames > 0")
    page.mouse.click(*scene_pixel(page, (3, -4, -5)))
    when(page, "station.editor.selected === -1 && station.editor.parts.mark")
    np.testing.assert_allclose(page.evaluate("station.editor.parts.mark"), (3, -4), atol=0.3)
    page.evaluate("station.editor.parts.markAt(null)")
    camera, target = page.evaluate(
        """() => {
          const { camera, controls } = station.editor.scene;
          controls.target.z += 3;
          controls.update();
          return [camera.position.toArray(), controls.target.toArray()];
        }"""
    )
    share = (-5 - camera[2]) / (target[2] - camera[2])
    seen = np.array(camera) + share * (np.array(target) - camera)
    assert np.hypot(*(seen - target)[:2]) > 1.0
    np.testing.assert_allclose(added("net"), seen[:2], atol=0.3)


def test_a_new_field_of_a_model_is_in_the_form_without_a_line_of_the_page(page, monkeypatch):
    class Gusty(Wind):
        gust_m_s: Annotated[float, InRange(0, 50, "m/s")] = 2.0

    monkeypatch.setitem(OTHER_SCHEMAS, "wind", Gusty)
    forms.cache_clear()
    page.reload()
    page.wait_for_selector(".preview:not([hidden])")
    page.click("text=Edit this scenario")
    page.get_by_label("What to add").select_option("wind")
    page.locator(".editor-canvas").press("a")
    field = page.locator("[data-field=gust_m_s]")
    assert "m/s" in field.inner_text() and field.locator("input").get_attribute("placeholder") == "2"
    forms.cache_clear()


def test_a_current_on_a_grid_asks_for_its_file(page, here):
    add(page, "currents", "grid")
    shows(page, ".editor-message", "file: must be named first")
    cells = [f"{x},{y},{z},0.1,0,0" for x in (-9, 9) for y in (-9, 9) for z in (-5, 0)]
    here.station.sessions.folder.mkdir(exist_ok=True)
    (here.station.sessions.folder / "tide.csv").write_text("\n".join(["x_m,y_m,z_m,u_m_s,v_m_s,w_m_s", *cells]))
    judge(page, "a file that is asked for")
    page.get_by_label("File", exact=True).fill("tide.csv")
    page.click(".editor-bar >> text=Add")
    when(page, "station.editor.part?.kind === 'grid' && station.editor.part.values.file === 'tide.csv'")


def test_ctrl_z_undoes_a_field_that_was_sent_and_a_text_that_was_not(page):
    page.click(".editor-table >> text=box")
    field = page.get_by_label("size_m 1")
    for value, key in (("2", "Enter"), ("3", "Tab")):
        field.fill(value)
        page.keyboard.press(key)
        when(page, SENT.format("box", f"size_m[0] === {value}"))
    for value in (2, 1):
        page.keyboard.press("Control+z")
        when(page, SENT.format("box", f"size_m[0] === {value}"))
    page.keyboard.press("Control+y")
    when(page, SENT.format("box", "size_m[0] === 2"))
    field.focus()
    page.keyboard.press("End")
    page.keyboard.type("5")
    page.keyboard.press("Control+z")
    assert field.input_value() == "2" and sent(page, "box", "size_m[0]") == 2, "its own text"
    page.locator(".editor-canvas").press("ArrowUp")
    page.keyboard.press("Control+z")  # at once: what is not yet sent is the change that is undone
    when(page, "station.editor.state.can_redo && " + SENT.format("box", "position_m[1] === 0"))
    assert sent(page, "box", "size_m[0]") == 2
    add(page, kind="sphere")
    when(page, SENT.format("sphere", "radius_m"))
    page.get_by_label("radius_m").fill("0.7")
    page.keyboard.press("Enter")
    when(page, SENT.format("sphere", "radius_m === 0.7"))
    page.keyboard.press("Control+z")
    when(page, SENT.format("sphere", "radius_m !== 0.7"))
    page.keyboard.press("Control+z")  # removes the part, and with it the field that has the focus
    when(page, "!(" + SENT.format("sphere", "radius_m") + ")")
    page.keyboard.press("Control+y")
    when(page, SENT.format("sphere", "radius_m"))


def test_parts_of_the_vehicle_its_start_the_survey_and_currents_are_edited_by_keys_alone(page):
    ground = page.locator(".editor-canvas")
    section = page.locator(".editor-bar select").first

    def edited(name: str) -> dict:
        return page.evaluate(
            f"station.editor.state.parts.find(({{name, section}}) => [name, section].includes('{name}'))?.values"
        )

    def changes(name: str, *keys: str) -> None:
        for key in keys:
            before = edited(name)
            ground.press(key)
            until(lambda before=before: edited(name) != before, f"{name}, {key}")

    for name, added in (("sensors", "imu_2"), ("cameras", "camera"), ("lamps", "lamp")):
        section.select_option(name)
        ground.press("a")
        until(lambda added=added: edited(added) is not None, added)
        first = edited(added)
        changes(added, "ArrowRight", "q", "PageUp")
        for _ in range(3):
            page.keyboard.press("Control+z")
        until(lambda added=added, first=first: edited(added) == first, f"{added}, undone")
        ground.press("Delete")
        until(lambda added=added: edited(added) is None, f"{added}, deleted")
    section.select_option("currents")
    page.get_by_label("Kind").select_option("layers")
    ground.press("a")
    until(lambda: edited("currents") is not None, "a current in layers")
    ground.press("Enter")
    assert page.evaluate("document.activeElement.closest('.editor-form') !== null")
    ground.press("Delete")
    until(lambda: edited("currents") is None, "no current")
    for name, keys in (("starts", ("ArrowRight", "q", "PageDown")), ("survey", ("ArrowUp", "e"))):
        while page.evaluate("station.editor.part?.section") != name:
            chosen = page.evaluate("station.editor.selected")
            ground.press("n")
            until(lambda chosen=chosen: page.evaluate("station.editor.selected") != chosen, "the next part")
        changes(name, *keys)


def test_a_scenario_is_edited_by_mouse_and_by_keys_saved_and_started(here, page):
    dragged(page, chart_pixel(page, (3, 0)), chart_pixel(page, (4, 2)))
    when(page, SENT.format("box", "position_m[1] > 1.9"))
    np.testing.assert_allclose(sent(page, "box", "position_m"), [4, 2, -4.5], atol=0.1)
    page.mouse.wheel(0, -100)
    when(page, SENT.format("box", "yaw_pitch_roll_deg?.[0] === 5"))
    page.keyboard.press("Control+z")
    when(page, "!(" + SENT.format("box", "yaw_pitch_roll_deg") + ")")

    page.get_by_label("Kind").press("s")  # by keys alone from here
    page.locator(".editor-canvas").press("a")
    when(page, SENT.format("sphere", "on_bed"))
    page.keyboard.press("Shift+ArrowUp")
    page.keyboard.press("Shift+ArrowUp")
    shows(page, ".editor-message", "terrain")  # which ends before
    for _ in range(3):
        page.keyboard.press("ArrowUp")
    page.keyboard.press("PageUp")
    when(page, SENT.format("sphere", "position_m[1] === 3"))
    assert sent(page, "sphere", "position_m") == [0, 3, 0.5]
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    page.locator("[aria-label=radius_m]").press("ControlOrMeta+a")
    page.keyboard.type("-1")
    page.keyboard.press("Enter")
    shows(page, "[data-field=radius_m] .wrong", "radius_m = -1 m: must be in [0.01, 10000] m")
    assert page.input_value("[aria-label=radius_m]") == "-1"  # as typed, to be corrected
    judge(page, "the editor")
    page.fill("[aria-label=radius_m]", "0.5")
    page.keyboard.press("Enter")
    when(page, SENT.format("sphere", "radius_m === 0.5"))
    page.get_by_label("Save as").fill("mine")
    page.keyboard.press("Control+s")
    shows(page, ".editor-message", "saved as")
    path = here.station.sessions.folder / "mine.yaml"
    scenario = load(path)
    assert scenario.obstacles[1].radius_m == 0.5 and path.read_text().startswith("# A small basin")

    page.keyboard.press("Escape")
    when(page, "document.querySelector('#field-scenario').value === 'mine.yaml'")
    page.click("button[type=submit]")
    when(page, "station.station.isPilot && station.telemetry.message")
    assert [each.name for each in here.station.present().live.simulator.scenario.obstacles] == ["box", "sphere"]


def test_a_paused_world_is_rebuilt_around_the_vehicle(here, start_page):
    page = start_page
    page.evaluate("document.querySelector('#editor-dialog').close()")
    if here.station.sessions.running is None:  # another process may have started it in the test before
        here.station.start({"scenario": "pool", "seed": 7})
        when(page, "station.station.isPilot && station.telemetry.message")
    running = here.station.present()
    before = running.live
    page.keyboard.press("Escape")
    page.click("text=Edit the scene")
    when(page, "station.editor.state?.is_of_running && document.querySelector('#editor-dialog[open]')")
    until(lambda: before.paused, "a paused simulator")
    page.click(".editor-table >> text=box")
    page.locator(".editor-canvas").press("ArrowUp")
    when(page, "station.editor.state.can_undo")
    page.click("text=Rebuild the world")
    until(lambda: here.station.sessions.running not in (None, running), "another world")
    after = here.station.present().live
    y_before, y_after = (live.simulator.scenario.obstacles[0].position_m[1] for live in (before, after))
    assert y_after == pytest.approx(y_before + 1.0) and after.paused and after.tick == before.tick > 0
