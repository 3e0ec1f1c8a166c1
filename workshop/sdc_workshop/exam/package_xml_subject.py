"""Check of package.xml: what the package needs, and when."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

# (tag, package, why)
_NEEDED = (
    ("build_depend", "message_generation", "it generates the classes while the package is built"),
    ("build_export_depend", "message_runtime", "packages that build on this one need it"),
    ("exec_depend", "message_runtime", "the classes need it when a node uses them"),
)


class PackageXmlSubject(Subject):
    """package.xml, TODO 1."""

    file = f"{PACKAGE}/package.xml"
    todos = ("1",)
    needs_build = False

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        try:
            root = ElementTree.fromstring(variant.text)
        except ElementTree.ParseError as error:
            return [
                Problem(
                    "an XML file",
                    str(error),
                    "A tag is not closed, or closed with another name: "
                    "<exec_depend>message_runtime</exec_depend>.",
                    line=error.position[0],
                )
            ]
        given = {
            tag: {entry.text.strip() for entry in root.iter(tag) if entry.text}
            for tag in ("depend", "build_depend", "build_export_depend", "exec_depend")
        }
        found = []
        for tag, name, why in _NEEDED:
            if name not in given[tag] | given["depend"]:
                others = [other for other, names in given.items() if name in names]
                seen = f"{name} only as {', '.join(others)}" if others else f"no {name}"
                hint = f"{tag} {name} is missing: {why}."
                found.append(Problem(f"<{tag}>{name}</{tag}>", seen, hint, "1"))
        return found
