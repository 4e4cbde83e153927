"""The page of two short simulated runs: nothing missing, nothing fetched, all of it drawn."""

import json

import pytest
from report_page import (Page, differing_share, drawn_share, expect_every_mode_drawn, open_browser,
                         run_slam, run_tool, simulate_room)

FRAMES = 30


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folders of two runs over one room, the first with a report of its own."""
    folder = tmp_path_factory.mktemp("report")
    room = simulate_room(folder, FRAMES)
    run_slam(room, folder / "plane", "--residual=point_to_plane", "--report")
    run_slam(room, folder / "symmetric")
    return folder


@pytest.fixture(scope="module")
def browser():
    driver = open_browser()
    yield driver
    driver.quit()


@pytest.fixture
def page(browser, runs):
    return Page(browser, runs / "plane" / "report.html")


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


def test_every_colour_mode_is_drawn(page):
    expect_every_mode_drawn(page)
    assert page.console() == []


def test_hides_what_is_less_confident(page):
    before = page.map_picture()
    page.script("const e = document.getElementById('least-confidence'); e.value = 1;"
                "e.dispatchEvent(new Event('input'))")
    assert drawn_share(page.map_picture()) < drawn_share(before)


def test_draws_paths_and_cameras(page):
    for part in ["show-cameras", "show-truth", "show-estimate"]:  # the truth hides the estimate
        before = page.map_picture()
        page.click(part)
        # A hidden line of a pixel's width.
        assert differing_share(before, page.map_picture()) > 0, part


def count_charts(page):
    return page.script("return [surfit.charts.length, document.querySelectorAll('.chart').length]")


def test_plots_every_frame_when_seen(page):
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
    assert f"frame {FRAMES - 1}," in shown and poses["views"][-1]["why"] in shown
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


def test_two_runs_stand_side_by_side(both):
    assert both.console() == []
    picture = both.map_picture()
    width, height = picture.size
    for left in [0, width // 2]:
        assert drawn_share(picture.crop((left, 0, left + width // 2, height))) > 0.1
    marked = both.script("return [...document.querySelectorAll('#options-table tr.differs')]"
                         ".map((r) => r.cells[0].textContent)")
    assert {"residual", "output"} <= set(marked)
    assert "kept no views" in both.script("return document.getElementById('view-columns').innerText")


def test_refuses_what_is_no_run(tmp_path):
    done = run_tool("surfit_report", f"--run={tmp_path}")
    assert done.returncode == 1
    assert "error: " in done.stderr and "summary.json" in done.stderr
