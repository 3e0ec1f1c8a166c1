"""Translated pages and hints: of the English text of today, with the same code, else English."""

import re
import shutil

from sdc_workshop import languages
from sdc_workshop.steps import hint_of
from sdc_workshop.workspace import PROJECT


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
