"""Gymnasium environments: SdcTown-v0, SdcRandomRoutes-v0 and SdcScenario-v0.

`import sdc_experiments.learning` registers them. They need the PyPI package gymnasium, which
`docker/prepare learning` installs; docs/learning.md describes them.
"""

from __future__ import annotations

try:
    import gymnasium
except ImportError as error:
    raise ImportError(
        "gymnasium is not installed; run docker/prepare learning in the folder of the project and "
        "set up the terminal again"
    ) from error

_ENVIRONMENT = "sdc_experiments.learning.environment:SdcEnvironment"
_VECTOR = "sdc_experiments.learning.vector_environment:SdcVectorEnvironment"

for _name, _arguments, _vector in (
    ("SdcTown-v0", {}, _VECTOR),
    ("SdcRandomRoutes-v0", {"random_routes": True}, _VECTOR),
    ("SdcScenario-v0", {"scenario": "slalom"}, None),
):
    if _name not in gymnasium.registry:
        gymnasium.register(
            _name, entry_point=_ENVIRONMENT, vector_entry_point=_vector, kwargs=_arguments
        )
