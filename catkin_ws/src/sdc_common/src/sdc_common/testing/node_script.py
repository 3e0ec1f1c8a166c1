"""Import the script of a node in a test, without starting the node."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
from types import ModuleType


def load_script(path: str) -> ModuleType:
    """Return a script as a new module.

    Args:
        path: of the script
    """
    name = os.path.basename(path).partition(".")[0] + "_script"
    loader = importlib.machinery.SourceFileLoader(name, path)
    spec = importlib.util.spec_from_loader(name, loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module
