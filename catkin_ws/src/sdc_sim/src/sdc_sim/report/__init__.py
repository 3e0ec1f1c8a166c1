"""Report of a drive: files, pages, comparison, status on the console."""

from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

# The folder of report.html.jinja, and of page.css, the style of every page of the project.
TEMPLATES = Path(__file__).with_name("templates")


def templates(*folders: Path, **options: Any) -> Environment:
    """Return the templates in folders and in TEMPLATES; of these, all but JSON is escaped."""
    loader = FileSystemLoader([*folders, TEMPLATES])
    options.update(loader=loader, undefined=StrictUndefined)
    return Environment(autoescape=lambda name: ".json" not in str(name), **options)
