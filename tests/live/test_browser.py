"""The live page in headless Chromium: state, trajectory, map, pictures and buttons."""

import io
import os
import pathlib

import pytest
from live_slam import ServedRun  # finds report_page, too
from report_page import browser, drawn_ratio, frame_drawn, pil_image, simulate_room  # noqa: F401
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

FRAMES = 160
# Folder for screenshots.
PICTURES = os.environ.get("SURFIT_SCREENSHOTS")


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return simulate_room(tmp_path_factory.mktemp("live"), FRAMES)


@pytest.fixture
def run(room, tmp_path):
    # Browsers without a graphics card render on the CPU. At --offered_fps=10 the run lasts until the
    # page is loaded and its buttons are clicked.
    served = ServedRun(room, tmp_path / "out", "--offered_fps=10")
    yield served
    served.end()


def wait_until(browser, condition):
    return WebDriverWait(browser, 60, poll_frequency=0.05).until(
        lambda _: browser.execute_script(f"return {condition}"), condition)


def text_of(browser, name):
    return browser.find_element(By.ID, name).text


def click(browser, name):
    browser.find_element(By.ID, name).click()


def keep(browser, name):
    if PICTURES:
        browser.save_screenshot(str(pathlib.Path(PICTURES) / name))


def canvas_picture(browser):
    frame_drawn(browser)
    png = browser.find_element(By.ID, "map-canvas").screenshot_as_png
    return pil_image.open(io.BytesIO(png)).convert("RGB")


def pause_after(browser, frames):
    wait_until(browser, f"surfit.live.state && surfit.live.state.frames_done > {frames}")
    click(browser, "pause")
    wait_until(browser, "surfit.live.state.paused")


def test_shows_and_controls_a_run(browser, run):
    browser.set_window_size(1200, 800)
    browser.get(run.url)
    pause_after(browser, 30)
    assert text_of(browser, "frame-state") == "paused"
    assert text_of(browser, "pause") == "resume"
    # The page has received the complete sample of the map.
    wait_until(browser, "surfit.live.state.shown > 1000 &&"
                        " surfit.live.scene.map.count() === surfit.live.state.shown")
    wait_until(browser, "surfit.live.scene.positions.length > 20")
    for picture in ["frame-picture", "model-picture"]:
        wait_until(browser, f"surfit.byId('{picture}').naturalWidth === 480")
    assert drawn_ratio(canvas_picture(browser)) > 0.15
    keep(browser, "paused.png")
    frames = browser.execute_script("return surfit.live.state.frames_done")
    assert text_of(browser, "frames") == f"{frames} of {FRAMES}"
    click(browser, "step")
    # Includes frames that were dropped during the pause.
    wait_until(browser, f"surfit.live.state.frames_done > {frames}")
    frames = browser.execute_script("return surfit.live.state.frames_done")
    assert browser.execute_script("return surfit.live.state.paused")
    click(browser, "follow")
    assert browser.find_element(By.ID, "follow").get_attribute("aria-pressed") == "true"
    browser.execute_script("const e = surfit.byId('colors'); e.value = 'normal';"
                           "e.dispatchEvent(new Event('change'))")
    click(browser, "normals")
    wait_until(browser, "surfit.live.seen.pictures > 0 &&"
                        " surfit.live.seen.pictures === surfit.live.state.numbers.normals")
    keep(browser, "following.png")
    press = browser.find_element(By.ID, "map-canvas").send_keys
    before = browser.execute_script("return surfit.live.scene.camera.position.toArray()")
    press("r")
    assert browser.find_element(By.ID, "follow").get_attribute("aria-pressed") == "false"
    press(Keys.ARROW_LEFT)
    assert browser.execute_script("return surfit.live.scene.camera.position.toArray()") != before
    assert browser.execute_script("return surfit.live.state.frames_done") == frames  # paused
    press(" ")
    wait_until(browser, f"surfit.live.state.frames_done > {frames}")
    wait_until(browser, "!surfit.live.state.paused")
    assert browser.get_log("browser") == []


def test_stops_a_run(browser, run):
    browser.set_window_size(1200, 800)
    browser.get(run.url)
    pause_after(browser, 1)
    click(browser, "stop")
    browser.switch_to.alert.accept()
    code, _ = run.finish()
    assert code == 0
    assert run.summary()["interrupted"] is True


def test_keeps_the_final_result(browser, run):
    browser.set_window_size(1200, 800)
    browser.get(run.url)
    code, _ = run.finish()
    assert code == 0
    wait_until(browser, "surfit.live.state.done && surfit.byId('link').textContent.includes('over')")
    assert text_of(browser, "frame-state") == "done"
    shown = browser.execute_script("return [surfit.live.scene.map.count(), surfit.live.state.shown]")
    assert shown[0] == shown[1] > 1000
    assert drawn_ratio(canvas_picture(browser)) > 0.15
    keep(browser, "done.png")
    # Rendered by colours and by normals, without a request to the run.
    model = browser.find_element(By.ID, "model-picture")
    colors = model.get_attribute("src")
    click(browser, "normals")
    wait_until(browser, "surfit.byId('model-picture').src !== '" + colors + "'")
    assert browser.execute_script("return surfit.byId('model-picture').naturalWidth") == 480
    keep(browser, "done_normals.png")


def test_fits_a_phone(browser, run):
    browser.set_window_size(500, 900)  # minimum window width of Chromium
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True})
    browser.get(run.url)
    pause_after(browser, 60)
    wait_until(browser, "surfit.byId('model-picture').naturalWidth === 480")
    wait_until(browser, "surfit.live.scene.map.count() === surfit.live.state.shown")
    frame_drawn(browser)
    keep(browser, "phone.png")
    overflow = browser.execute_script("return document.documentElement.scrollWidth - window.innerWidth")
    boxes = browser.execute_script("return ['pause', 'stop', 'follow', 'frame-picture'].map("
                                   "(id) => surfit.byId(id).getBoundingClientRect().right)")
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert overflow <= 0
    assert max(boxes) <= 390


@pytest.mark.parametrize("width", [1200, 800, 400])
def test_each_figure_takes_one_line(browser, run, width):
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width, "height": 850, "deviceScaleFactor": 1, "mobile": False})
    browser.get(run.url)
    pause_after(browser, 1)
    heights = browser.execute_script(
        "surfit.live.panel.showState({...surfit.live.state, frames_done: 1000, frames_total: 1000, map_points: 1234567,"
        "  shown: 131072, loops: 12, last_loop: [987, 123]});"
        "return [...document.querySelectorAll('#figures :is(dt, dd)')].map((e) => e.getBoundingClientRect().height)")
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert max(heights) < 30, heights  # one line has 21 px


def test_advice_is_large_and_remains_visible(browser, run):
    browser.set_window_size(1200, 800)
    browser.get(run.url)
    pause_after(browser, 1)
    browser.execute_script("surfit.live.panel.showAdvice([{kind: 'lost', text: 'Lost: turn back'}])")
    advice = browser.find_element(By.CSS_SELECTOR, "#advice p.lost")
    assert advice.text == "Lost: turn back"
    keep(browser, "lost.png")
    browser.execute_script("surfit.live.panel.showAdvice([])")
    assert browser.find_elements(By.CSS_SELECTOR, "#advice p")
    wait_until(browser, "(surfit.live.panel.showAdvice([]), !document.querySelector('#advice p'))")


def test_another_token_shows_nothing(browser, run):
    browser.get(run.url[:-2] + "x/")
    assert browser.find_element(By.TAG_NAME, "body").text == "Forbidden"
