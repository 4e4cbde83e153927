"""The page of two short simulated runs: complete, without network requests, and completely drawn."""

import json
import pathlib
import shutil

import pytest
from report_page import (Page, differing_ratio, drawn_ratio, expect_every_mode_drawn, numbers, run_slam,
                         run_tool, simulate_room)
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

FRAMES = 30
# One loop of each kind, between frames of the run.
LOOPS = """source,target,reason,matches,agreeing_features,inlier_ratio,rmse_m
29,0,accepted,40,31,0.36,0.0023
25,3,contradicts_others,30,12,0.3,0.004
20,2,free_space_violation,25,10,0.2,0.005
"""


# Pieces in summary.json, as of a camera that was lost.
PIECES = [{"first_frame": 0, "last_frame": 19, "frames": 20, "ate_rmse_m": 0.00123},
          {"first_frame": 22, "last_frame": 29, "frames": 8, "ate_rmse_m": None}]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folders of two runs in one room. The first run has a separate report."""
    folder = tmp_path_factory.mktemp("report")
    room = simulate_room(folder, FRAMES)
    run_slam(room, folder / "plane", "--residual=point_to_plane", "--report")
    (folder / "plane" / "loops.csv").write_text(LOOPS)
    done = run_tool("surfit_report", f"--run={folder / 'plane'}")
    assert done.returncode == 0, done.stderr
    run_slam(room, folder / "symmetric")
    return folder


@pytest.fixture
def page(browser, runs):
    return Page(browser, runs / "plane" / "report.html")


@pytest.fixture
def in_pieces(browser, runs, tmp_path):
    folder = shutil.copytree(runs / "plane", tmp_path / "pieces")
    for name, added in (("summary", {"pieces": PIECES}), ("poses", {"largest_piece": list(range(20))})):
        path = folder / f"{name}.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **added}))
    done = run_tool("surfit_report", f"--run={folder}")
    assert done.returncode == 0, done.stderr
    return Page(browser, folder / "report.html")


@pytest.fixture
def both(browser, runs):
    output = runs / "both.html"
    done = run_tool("surfit_report", f"--run={runs / 'plane'}", f"--run={runs / 'symmetric'}",
                    f"--output={output}")
    assert done.returncode == 0, done.stderr
    return Page(browser, output)


def test_opens_from_disk_without_errors_or_network(page):
    assert page.script("return document.documentElement.dataset.readyMs")
    assert page.console() == []
    urls = page.script("return performance.getEntriesByType('resource').map((e) => e.name)")
    assert [url for url in urls if not url.startswith("data:")] == []


def test_pieces_are_listed_and_the_chart_shows_the_largest(in_pieces):
    table = in_pieces.script("return document.querySelector('#trajectory .pieces').innerText").split("\n")
    assert [row.split("\t") for row in table[1:]] == [["0", "19", "20", "1.23"], ["22", "29", "8", "unknown"]]
    in_pieces.scroll_to("trajectory")
    canvas = "document.querySelector('#trajectory canvas')"
    assert in_pieces.script(f"return Chart.getChart({canvas}).data.datasets[0].data.length") == 20


def test_single_piece_is_not_listed(page):
    assert page.script("return document.querySelectorAll('#trajectory .pieces').length") == 0


def test_every_colour_mode_is_drawn(page):
    expect_every_mode_drawn(page)
    assert page.console() == []


def test_hides_surfels_below_the_confidence(page):
    before = page.map_picture()
    page.script("const e = document.getElementById('least-confidence'); e.value = 1;"
                "e.dispatchEvent(new Event('input'))")
    assert drawn_ratio(page.map_picture()) < drawn_ratio(before)


def test_draws_paths_and_cameras(page):
    for part in ["show-cameras", "show-truth", "show-estimate"]:  # the ground truth occludes the estimate
        before = page.map_picture()
        page.click(part)
        # A line of one pixel changes.
        assert differing_ratio(before, page.map_picture()) > 0, part


def count_charts(page):
    return page.script("return [surfit.charts.length, document.querySelectorAll('.chart').length]")


def test_draws_plots_when_scrolled_into_view(page):
    made, all_charts = count_charts(page)
    assert made < all_charts
    for section in ["trajectory", "shared-charts", "run-charts"]:
        page.scroll_to(section)
    assert count_charts(page) == [all_charts, all_charts]
    assert page.console() == []
    lengths = page.script("return surfit.charts.flatMap((c) => c.data.datasets.map("
                          "(d) => [c.options.plugins.title.text, d.data.length]))")
    assert len(lengths) >= 10
    assert all(length == FRAMES for title, length in lengths), lengths


def test_shows_views_summary_and_options(page, runs):
    page.scroll_to("views")
    page.script("return Promise.all([...document.querySelectorAll('#view-columns img')].map((i) => i.decode()))")
    widths = page.script("return [...document.querySelectorAll('#view-columns img')]"
                         ".map((i) => i.naturalWidth)")
    assert widths == [160] * 4
    poses = json.loads((runs / "plane" / "poses.json").read_text())
    page.script("const e = document.querySelector('#view-columns input'); e.value = e.max;"
                "e.dispatchEvent(new Event('input'))")
    shown = page.script("return document.querySelector('#view-columns span').textContent")
    assert str(FRAMES - 1) in numbers(shown) and poses["views"][-1]["why"] in shown
    summary = json.loads((runs / "plane" / "summary.json").read_text())
    rows = page.script("return [...document.querySelectorAll('#options-table tbody tr')]"
                       ".map((r) => r.cells[0].textContent)")
    assert rows == list(summary["options"])
    assert summary["digest"] in page.script("return document.getElementById('summary-table').innerText")


def test_theme_follows_the_button(page):
    def paper():
        return page.script("return getComputedStyle(document.body).backgroundColor")
    before = paper()
    page.click("theme")
    assert paper() != before


def place_of_camera(page, frame):
    """Position of the camera of a frame on the canvas, in pixels from its centre (as in ActionChains)."""
    return page.script(
        "const view = surfit.mapView, cell = view.cells[0];"
        "const at = view.onCanvas(cell, surfit.positionOf(cell.run.poseOfFrame.get(arguments[0])));"
        "const { clientWidth, clientHeight } = view.canvas;"
        "return [Math.round(at.x - clientWidth / 2), Math.round(at.y - clientHeight / 2)]", frame)


def click_in_map(page, right, down):
    canvas = page.browser.find_element(By.ID, "map-canvas")
    ActionChains(page.browser).move_to_element_with_offset(canvas, right, down).click().perform()


def loaded_widths(page, selector):
    return page.browser.execute_async_script(
        "const [selector, done] = arguments, images = [...document.querySelectorAll(selector)];"
        "Promise.all(images.map((i) => i.decode())).then(() => done(images.map((i) => i.naturalWidth)))", selector)


def test_a_click_on_a_camera_shows_its_frame(page):
    click_in_map(page, *place_of_camera(page, FRAMES - 1))
    frame = page.script("return surfit.selected.frame")
    # The path is short, so adjacent cameras may be at the same pixel.
    assert frame > FRAMES - 6
    text = page.script("return document.getElementById('map-frame').innerText")
    assert str(frame) in numbers(text) and "tracked" in text
    assert loaded_widths(page, "#map-frame img") == [160, 160]
    sources = page.script("return [...document.querySelectorAll('#map-frame img')].map((i) => i.alt)")
    assert [numbers(source) for source in sources] == [[str(frame)], [str(frame)]]
    assert page.console() == []


def test_every_frame_of_a_short_run_has_a_thumbnail(page, runs):
    page.script("document.getElementById('frame').scrollIntoView()")
    page.wait_until("document.querySelectorAll('.thumbnail').length > 0")
    frames = page.script("return [...document.querySelectorAll('.thumbnail')].map((b) => Number(b.dataset.frame))")
    assert frames == list(range(FRAMES))
    page.script("document.querySelectorAll('.thumbnail')[7].click()")
    assert page.script("return surfit.selected.frame") == 7
    page.click("next-frame")
    assert "8" in numbers(page.script("return document.getElementById('frame-facts').textContent"))
    before = page.map_picture()
    page.click("look-from-frame")
    assert differing_ratio(before, page.map_picture()) > 0.5


def test_shows_loops_in_timeline_table_and_map(page):
    page.script("document.getElementById('loops').scrollIntoView()")
    page.wait_until("document.querySelector('.timeline svg')")

    def arcs():
        return page.script("return [...document.querySelectorAll('.arc')].map((a) => a.getAttribute('class'))")
    assert arcs() == ["arc accepted"]
    page.script("const e = document.getElementById('loop-filter'); e.value = 'all';"
                "e.dispatchEvent(new Event('change'))")
    assert sorted(arcs()) == ["arc accepted", "arc overruled", "arc refused"]
    page.script("const e = document.getElementById('loop-filter'); e.value = 'free_space_violation';"
                "e.dispatchEvent(new Event('change'))")
    assert arcs() == ["arc refused"]
    assert numbers(page.script("return document.querySelector('#loop-table tbody').innerText")) == [
        "20", "2", "10", "25", "20", "5.0"]
    page.script("document.querySelector('#loop-table button').click()")
    assert {"20", "2"} <= set(numbers(page.script("return document.getElementById('loop-facts').textContent")))
    assert page.script("return document.getElementById('show-refused').checked")
    edges = page.script("const { graph, refused } = surfit.mapView.cells[0];"
                        "return [...graph.children, refused].map((c) => c.geometry.attributes.position.count)")
    keyframes = page.script("return surfit.runs[0].poses.keyframes")
    assert keyframes[0] == [0, -1, 0] and len(keyframes) >= 2
    assert edges == [2 * (len(keyframes) - 1), len(keyframes), 2, 2, 2]
    assert page.console() == []


def test_surfels_are_discs(page):
    """A large surfel is drawn as a disc: the corners of its square are empty, its sides are not."""
    for part in ["show-estimate", "show-truth", "show-cameras", "show-graph"]:
        page.click(part)
    page.script("surfit.mapView.setUniform('leastConfidence', 0);"
                "surfit.mapView.cells[0].run.map.shown = 1; surfit.mapView.crop.reset();"
                "const { run } = surfit.mapView.cells[0], p = surfit.positionOfSurfel(run.map, 0);"
                "const n = new THREE.Vector3(...run.map.normal.slice(0, 3)).normalize();"
                "const r = surfit.growth(run.map, 1) * run.map.max_radius * run.map.radius[0] / 65535;"
                "surfit.mapView.look(p.clone().addScaledVector(n, 6 * r), p)")
    picture = page.map_picture()
    width, height = picture.size
    background = picture.getpixel((0, 0))
    # Radius in pixels of a disc with radius = distance / 6, at a field of view of 50 degrees.
    radius = height / 2 / 0.4663 / 6

    def is_drawn(right, down):
        return picture.getpixel((round(width / 2 + right * radius), round(height / 2 + down * radius))) != background
    assert is_drawn(0, 0) and is_drawn(0.9, 0) and is_drawn(0, -0.9) and is_drawn(0.6, 0.6)
    assert not is_drawn(0.8, 0.8) and not is_drawn(-0.8, 0.8) and not is_drawn(1.1, 0)


def test_measures_between_two_clicks(page):
    """Compares with the distance of the two clicked surfels."""
    canvas = page.browser.find_element(By.ID, "map-canvas")
    canvas.send_keys("m")
    assert page.script("return document.getElementById('measure').getAttribute('aria-pressed')") == "true"
    # Two visible surfels: picking along the ray to them returns a close point.
    places = page.script(
        "const view = surfit.mapView, cell = view.cells[0], { map } = cell.run, found = [];"
        "for (let i = 0; i < map.shown && found.length < 2; i += 97) {"
        "  const p = surfit.positionOfSurfel(map, i), at = view.onCanvas(cell, p);"
        "  const ray = new THREE.Ray(view.camera.position.clone(), p.clone().sub(view.camera.position).normalize());"
        "  const hit = surfit.pick(map, ray, { cull: true, leastConfidence: view.leastConfidence, isCropped: () => false });"
        "  const { clientWidth, clientHeight } = view.canvas;"
        "  const inside = at && Math.abs(at.x / clientWidth - 0.5) < 0.4 && Math.abs(at.y / clientHeight - 0.5) < 0.4;"
        "  const apart = found.length === 0 || p.distanceTo(new THREE.Vector3(...found[0].p)) > 1;"
        "  if (hit && inside && apart && hit.distanceTo(p) < 0.01) found.push({ p: p.toArray(),"
        "    at: [Math.round(at.x - clientWidth / 2), Math.round(at.y - clientHeight / 2)] });"
        "}"
        "return found")
    assert len(places) == 2
    for place in places:
        click_in_map(page, *place["at"])
    expected = sum((a - b) ** 2 for a, b in zip(places[0]["p"], places[1]["p"])) ** 0.5
    measured = page.script("return surfit.mapView.measure.metres()")
    # A pixel is up to 2 cm wide there, and surfaces are oblique.
    assert measured == pytest.approx(expected, abs=0.08)
    text = page.script("return document.getElementById('measured').textContent")
    assert text == f"Measured: {measured:.3f} m"
    page.wait_for_all_points()
    assert f"{measured:.3f} m" in page.script("return document.getElementById('map-overlay').textContent")
    canvas.send_keys(Keys.ESCAPE)
    assert page.script("return surfit.mapView.measure.metres()") is None


def test_crops_to_a_box(page):
    before = page.map_picture()
    page.script("const e = document.getElementById('crop-up-to'); e.value = Number(e.min) + 0.3 * (e.max - e.min);"
                "e.dispatchEvent(new Event('input'))")
    cropped = page.map_picture()
    assert drawn_ratio(cropped) < 0.9 * drawn_ratio(before)
    assert page.script("return surfit.mapView.cells[0].box.visible")
    page.click("reset-crop")
    assert differing_ratio(before, page.map_picture()) == 0


def test_keys_turn_the_map(page):
    canvas = page.browser.find_element(By.ID, "map-canvas")
    pictures = [page.map_picture()]
    for key in [Keys.ARROW_LEFT, Keys.ARROW_UP, "+"]:
        canvas.send_keys(key)
        pictures.append(page.map_picture())
        assert differing_ratio(pictures[-2], pictures[-1]) > 0.05, key
    canvas.send_keys("r")
    assert differing_ratio(pictures[0], page.map_picture()) < 0.01  # focus outline
    canvas.send_keys("nnp")
    assert page.script("return surfit.selected.frame") == 0
    assert not page.script("return document.getElementById('map-frame').hidden")
    facts = page.script("return document.getElementById('map-frame-facts').textContent")
    assert "0" in numbers(facts) and "first" in facts


def test_controls_have_accessible_names(page):
    for section in ["trajectory", "shared-charts", "run-charts", "loops"]:
        page.script("document.getElementById(arguments[0]).scrollIntoView()", section)
        page.wait_until("[...document.querySelectorAll(`#${arguments[0]} .chart`)].every((box) => box.firstChild)", section)
    unnamed = page.script(
        "const named = (e) => e.getAttribute('aria-label') || e.closest('label') || e.textContent.trim();"
        "return [...document.querySelectorAll('canvas, svg, button, input, select')]"
        ".filter((e) => !named(e)).map((e) => e.outerHTML)")
    assert unnamed == []


def test_shows_the_calibration(page, runs):
    summary = json.loads((runs / "plane" / "summary.json").read_text())
    assert summary["calibrations"]
    text = page.script("return document.getElementById('refinement').innerText")
    assert str(summary['calibrations'][0]['frame'] + 1) in numbers(text)


def test_fits_a_phone(browser, both):
    """390 x 844, a common size of phones: no plot is clipped, and the page does not scroll horizontally."""
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                            {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True})
    try:
        page = Page(browser, pathlib.Path(browser.current_url.removeprefix("file://")))
        for i in range(page.script("return document.querySelectorAll('.chart, .timeline, .pictures').length")):
            part = "document.querySelectorAll('.chart, .timeline, .pictures')[arguments[0]]"
            page.script(f"{part}.scrollIntoView()", i)
            page.wait_until(f"{part}.firstChild || {part}.closest('[hidden]')", i)
        assert page.script("return document.documentElement.scrollWidth") == 390
        cut = page.script(
            "return [...document.querySelectorAll('canvas, svg, img, input, select, button, section')]"
            ".filter((e) => !e.closest('#thumbnails, .table') && e.getBoundingClientRect().right > 390)"
            ".map((e) => e.outerHTML.slice(0, 100))")
        assert cut == []
        # The maps are stacked vertically.
        picture = page.map_picture()
        width, height = picture.size
        for top in [0, height // 2]:
            assert drawn_ratio(picture.crop((0, top, width, top + height // 2))) > 0.1
        assert page.console() == []
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def distances_m(page, run):
    """Distances of the shown surfels of a run to the other map, in metres."""
    return page.script("return [...surfit.runs[arguments[0]].map.distance].map((tenths) => tenths / 1e4)", run)


def test_two_runs_are_compared(both):
    """Two runs over the same frames with errors of a few millimetres."""
    for run in [0, 1]:
        distances = sorted(distances_m(both, run))
        assert 0 < distances[len(distances) // 2] < 0.01
    text = both.script("return document.getElementById('map-labels').innerText")
    assert "symmetric" in text and str(FRAMES) in numbers(text)
    before = both.map_picture()
    both.choose_mode("distance")
    assert differing_ratio(before, both.map_picture()) > 0.1
    assert "distance" in both.script("return document.getElementById('map-legend').innerText")


def test_names_runs_without_their_path(both, runs):
    assert both.script("return document.title") == "Surfit: plane, symmetric"
    names = both.script("return [...document.querySelectorAll('h3')].map((h) => h.textContent)")
    assert set(names) == {"plane", "symmetric"}


def test_aligns_a_run_with_another_world_frame(browser, runs):
    """The same room with a different first pose: both maps are aligned, and none is clipped."""
    output = runs / "moved.html"
    run_slam(runs / "room", runs / "moved", "--initial_pose=4,1,-3,0,0.6,0,0.8")
    done = run_tool("surfit_report", f"--run={runs / 'symmetric'}", f"--run={runs / 'moved'}", f"--output={output}")
    assert done.returncode == 0, done.stderr
    page = Page(browser, output)
    distances = sorted(distances_m(page, 1))
    assert distances[len(distances) // 2] < 0.01
    picture = page.map_picture()
    width, height = picture.size
    left, right = (picture.crop((x, 0, x + width // 2, height)) for x in (0, width // 2))
    assert differing_ratio(left, right) < 0.3
    assert page.console() == []


def test_shows_a_refined_run(browser, runs):
    refined = runs / "plane" / "refined"
    done = run_tool("surfit_refine", f"--run={runs / 'plane'}")
    assert done.returncode == 0, done.stderr
    done = run_tool("surfit_report", f"--run={runs / 'plane'}", f"--run={refined}", f"--output={runs / 'refined.html'}")
    assert done.returncode == 0, done.stderr
    page = Page(browser, runs / "refined.html")
    assert page.console() == []
    assert page.script("return document.title") == "Surfit: plane, refined"
    assert "plane" in page.script("return document.getElementById('map-labels').innerText")
    assert numbers(page.script("return document.getElementById('refinement').innerText"))
    page.scroll_to("refinement")
    charts = page.script("return surfit.charts.filter((c) => c.canvas.closest('#refinement')).length")
    assert charts > 0


def test_shows_two_runs_side_by_side(both):
    assert both.console() == []
    picture = both.map_picture()
    width, height = picture.size
    for left in [0, width // 2]:
        assert drawn_ratio(picture.crop((left, 0, left + width // 2, height))) > 0.1
    marked = both.script("return [...document.querySelectorAll('#options-table tr.differs')]"
                         ".map((r) => r.cells[0].textContent)")
    assert {"residual", "output"} <= set(marked)
    assert "views" in both.script("return document.getElementById('view-columns').innerText")


def test_rejects_a_folder_without_run(tmp_path):
    done = run_tool("surfit_report", f"--run={tmp_path}")
    assert done.returncode == 1
    assert "error: " in done.stderr and "summary.json" in done.stderr
