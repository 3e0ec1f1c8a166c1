"""Report of a drive: files, pages, comparison, status on the console."""

from pathlib import Path

# The folder of report.html.jinja, and of page.css, the style of every page of the project.
TEMPLATES = Path(__file__).with_name("templates")
