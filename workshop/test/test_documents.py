"""Links and pictures of the guide's pages."""

import re

import pytest

from sdc_workshop.pictures import PICTURES, main
from sdc_workshop.workspace import PROJECT

WORKSHOP = PROJECT / "workshop"
PAGES = sorted(WORKSHOP.glob("*.md"))


def headings(page):
    """Return the anchors of a page's headings."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_a_page_have_targets(page):
    links = re.findall(r"\]\(([^)]+)\)", page.read_text())
    for link in links:
        if not link.startswith("http"):
            name, _, anchor = link.partition("#")
            target = (page.parent / name) if name else page
            assert target.exists(), link
            assert not anchor or anchor in headings(target), link


def test_each_picture_is_drawn_and_shown(tmp_path):
    main(tmp_path)
    drawn = {path.name for path in tmp_path.iterdir()}
    assert drawn == {f"{picture.__name__}.png" for picture in PICTURES}
    assert drawn == {path.name for path in (WORKSHOP / "pictures").iterdir()}
    shown = set(
        re.findall(r"\]\(pictures/(\w+\.png)\)", "".join(page.read_text() for page in PAGES))
    )
    assert shown == drawn
