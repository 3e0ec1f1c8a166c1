"""Gymnasium environments: SdcTown-v0, SdcRandomRoutes-v0, SdcScenario-v0, SdcTraffic-v0.

`import sdc_experiments.learning` registers them. They need the PyPI package gymnasium, which
`docker/prepare learning` installs; docs/learning.md describes them.
"""

from __future__ import annotations

from sdc_common.configuration import how_to_install

try:
    import gymnasium
except ImportError as error:
    raise ImportError(f"gymnasium is not installed; {how_to_install('learning')}") from error

_ENVIRONMENT = "sdc_experiments.learning.environment:SdcEnvironment"
_VECTOR = "sdc_experiments.learning.vector_environment:SdcVectorEnvironment"

_TRAFFIC = "sdc_experiments.learning.traffic_environment:Traffic"

for _name, _entry_point, _vector, _arguments in (
    ("SdcTown-v0", _ENVIRONMENT, _VECTOR, {}),
    ("SdcRandomRoutes-v0", _ENVIRONMENT, _VECTOR, {"random_routes": True}),
    ("SdcScenario-v0", _ENVIRONMENT, None, {"scenario": "slalom"}),
    ("SdcTraffic-v0", _TRAFFIC + "Environment", _TRAFFIC + "VectorEnvironment", {}),
):
    if _name not in gymnasium.registry:
        gymnasium.register(
            _name, entry_point=_entry_point, vector_entry_point=_vector, kwargs=_arguments
        )
