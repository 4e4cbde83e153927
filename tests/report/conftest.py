"""All pages are opened in one browser: beginning one takes longer than most tests do."""

from report_page import browser  # noqa: F401
