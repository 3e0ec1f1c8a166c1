"""What MkDocs changes in a page: the file of a code block becomes its title."""

import re


def on_page_markdown(markdown, **_):
    """Return the page; the fences of the guide have more words than Python-Markdown reads."""
    return re.sub(r'^(\s*```\w+) +([^{\n"]+?) *$', r'\1 title="\2"', markdown, flags=re.M)
