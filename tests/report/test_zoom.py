"""Zooming in the plots. Pages support it if the npm plugin was available at build time."""

import pytest
from report_page import Page, run_slam, simulate_room
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By


def shown_frames(page, canvas):
    return page.script("const { x } = Chart.getChart(arguments[0]).scales; return [x.min, x.max]", canvas)


def wait_for_frames(page, canvas, condition):
    """Waits until x.min and x.max, the first and last shown frame of a chart, satisfy a condition."""
    page.wait_until(f"((x) => {condition})(Chart.getChart(arguments[0]).scales.x)", canvas)


def drag_across_half(browser, canvas):
    quarter = canvas.size["width"] // 4
    ActionChains(browser).move_to_element_with_offset(canvas, -quarter, 0).click_and_hold() \
        .move_by_offset(2 * quarter, 0).release().perform()


def test_dragging_zooms_and_a_double_click_ends_it(browser, tmp_path):
    run_slam(simulate_room(tmp_path, 10), tmp_path / "out", "--report")
    browser.get_log("browser")  # clears messages of other pages
    page = Page(browser, tmp_path / "out" / "report.html")
    if not page.script("return Boolean(window.ChartZoom)"):
        pytest.skip("the page was built without chartjs-plugin-zoom")
    page.scroll_to("run-charts")
    canvas = browser.find_elements(By.CSS_SELECTOR, "#run-charts canvas")[-1]
    low, high = shown_frames(page, canvas)
    drag_across_half(browser, canvas)
    wait_for_frames(page, canvas, f"{low} < x.min && x.min < x.max && x.max < {high}")
    ActionChains(browser).double_click(canvas).perform()
    wait_for_frames(page, canvas, f"x.min === {low} && x.max === {high}")
    assert page.console() == []
