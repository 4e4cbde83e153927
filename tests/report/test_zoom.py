"""Zooming in the plots, which pages have where npm had the plugin when they were built."""

import pytest
from report_page import Page, open_browser, run_slam, simulate_room
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By


def shown_frames(page):
    return page.script("const x = surfit.charts.at(-1).scales.x; return [x.min, x.max]")


def test_dragging_zooms_and_a_double_click_ends_it(tmp_path):
    run_slam(simulate_room(tmp_path, 10), tmp_path / "out", "--report")
    browser = open_browser()
    try:
        page = Page(browser, tmp_path / "out" / "report.html")
        if not page.script("return Boolean(window.ChartZoom)"):
            pytest.skip("the page was built without chartjs-plugin-zoom")
        page.scroll_to("run-charts")
        chart = browser.find_elements(By.CSS_SELECTOR, "#run-charts canvas")[-1]
        low, high = shown_frames(page)
        quarter = chart.size["width"] // 4
        ActionChains(browser).move_to_element_with_offset(chart, -quarter, 0).click_and_hold() \
            .move_by_offset(2 * quarter, 0).release().perform()
        zoomed = shown_frames(page)
        assert low < zoomed[0] < zoomed[1] < high
        ActionChains(browser).double_click(chart).perform()
        assert shown_frames(page) == [low, high]
        assert page.console() == []
    finally:
        browser.quit()
