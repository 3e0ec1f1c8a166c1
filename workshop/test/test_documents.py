"""Links and file names of all pages, the pictures of the guide, and its translations.

Translated pages and hints are of the English text of today, with the same code, else English.
"""

import re
import shutil

import pytest

from sdc_testing.project import GENERATED
from sdc_workshop import languages
from sdc_workshop.steps import hint_of
from sdc_workshop.workspace import PROJECT

WORKSHOP = PROJECT / "workshop"
FILES = [path for path in PROJECT.rglob("*") if not GENERATED & set(path.parts)]
ALL_PAGES = sorted(path for path in FILES if path.suffix == ".md")
PAGES = [path for path in ALL_PAGES if path.parent == WORKSHOP]
# Files that a drive, a command or the reader writes.
WRITTEN = re.compile(
    r"(report|replay|grades|moodle|canvas|copies|results|mine|my_\w+|tight_route|predictions|\w+_LAB|NAME|FILE|STUDY|road)\.\w+"
)
# Files of CARLA, of its own bridge, of autoware_mini, and of the projects in docs/integration.md.
FOREIGN = re.compile(
    r"carla_\w+\.launch|ros_sensors\.md|(carla|control|planning)\.yaml|waypoints_\w+_1m\.csv"
    r"|(pursuit|dbw_node|lkas|pid)\.py|raceline\.csv"
    r"|(path_smoothing|\w*_follower|carla_\w+|waypoint_loader|config)\.py|CarlaUE4\.sh"
)


def headings(page):
    """Return the anchors of a page's headings."""
    titles = languages.sections(page.read_text())
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def anchors(page):
    """Return the anchors of a page: of its headings, and those that are written."""
    return headings(page) | set(re.findall(r'<a id="(.*?)">', page.read_text()))


@pytest.mark.parametrize("page", ALL_PAGES, ids=lambda page: str(page.relative_to(PROJECT)))
def test_links_of_a_page_have_targets(page):
    links = re.findall(r"\]\(([^)]+)\)", page.read_text())
    for link in links:
        if not link.startswith("http"):
            name, _, anchor = link.partition("#")
            target = (page.parent / name) if name else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", ALL_PAGES, ids=lambda page: str(page.relative_to(PROJECT)))
def test_files_that_a_page_names_are_there(page):
    named = re.findall(r"[\w-]+\.(?:csv|launch|md|py|sh|test|yaml)\b", page.read_text())
    known = {path.name for path in FILES}
    elsewhere = (WRITTEN, FOREIGN)
    missing = {
        name
        for name in named
        if name not in known and not any(pattern.fullmatch(name) for pattern in elsewhere)
    }
    assert missing == set()


@pytest.mark.parametrize(
    "folder", [WORKSHOP, *(path.parent for path in WORKSHOP.glob("??/guide.md"))]
)
def test_old_links_to_the_guide_lead_to_the_section_on_its_page(folder):
    guide = (folder / "guide.md").read_text()
    for page in folder.glob("phase-?.md"):
        for anchor in headings(page):
            place = "" if anchor.startswith("phase-") else f"#{anchor}"
            link = rf'<a id="{anchor}"></a>\s*\**\[.*\]\({page.name}{place}\)'
            assert re.search(link, guide), anchor


def test_each_picture_is_shown():
    text = "".join(page.read_text() for page in PAGES)
    shown = set(re.findall(r"\]\(pictures/(\w+\.png)\)", text))
    assert shown == {path.name for path in (WORKSHOP / "pictures").iterdir()}


def test_translations_are_of_the_english_text_and_its_code():
    assert languages.stale() == []
    for path in (PROJECT / "workshop").glob("??/**/*.md"):
        english = languages.sections(languages.english_page(path).read_text())
        for title, (text, _) in languages.translated_sections(path.read_text()).items():
            code = [re.findall(r"^```.*?^```", one, re.M | re.S) for one in (text, english[title])]
            assert code[0] == code[1], f"{path}: {title}"


def test_stale_section_is_named_and_missing_ones_are_english(tmp_path, monkeypatch):
    monkeypatch.setattr(languages, "FOLDER", tmp_path)
    other_pages = shutil.ignore_patterns("phase-*")
    shutil.copytree(PROJECT / "workshop/de", tmp_path / "de", ignore=other_pages)
    (tmp_path / "guide.md").write_text("# One\nred\n# Two\nblue\n")
    page = tmp_path / "de" / "guide.md"
    page.write_text("# Eins\n<!-- from: One, 0 -->\nrot [x](../x.png)\n")
    assert [line.split(" was ")[0] for line in languages.stale()] == [f"{page}: 'One'"]
    languages.update(page)
    assert languages.stale() == []
    monkeypatch.setenv("LANGUAGE", "de_AT.UTF-8")
    assert languages.page("guide.md") == "# Eins\nrot [x](x.png)\n# Two\nblue\n"
    assert hint_of("messages-3").hint.startswith("Ein Name")
    assert hint_of("controller-2.4").hint.startswith("yaw =")
