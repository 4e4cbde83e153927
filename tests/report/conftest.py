"""All tests share one browser, because its start takes longer than most tests."""

from report_page import browser  # noqa: F401
