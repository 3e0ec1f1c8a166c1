"""Gymnasium environments: SdcTown-v0, SdcRandomRoutes-v0, SdcScenario-v0, SdcTraffic-v0.

`import sdc_experiments.learning` registers them. They need the PyPI package gymnasium, which
`docker/prepare learning` installs; docs/learning.md describes them.
"""

from __future__ import annotations

from sdc_common.configuration import how_to_install

try:
    from gymnasium.envs import registration
except ImportError as error:
    raise ImportError(f"gymnasium is not installed; {how_to_install('learning')}") from error

_ENVIRONMENT = "sdc_experiments.learning.environment:SdcEnvironment"
_VECTOR = "sdc_experiments.learning.vector_environment:SdcVectorEnvironment"
_TRAFFIC = "sdc_experiments.learning.traffic_environment:Traffic"

# Name, environment, environment of many cars, and arguments.
_ROWS: tuple = (
    ("SdcTown-v0", _ENVIRONMENT, _VECTOR, {}),
    ("SdcRandomRoutes-v0", _ENVIRONMENT, _VECTOR, {"random_routes": True}),
    ("SdcScenario-v0", _ENVIRONMENT, None, {"scenario": "slalom"}),
    ("SdcTraffic-v0", _TRAFFIC + "Environment", _TRAFFIC + "VectorEnvironment", {}),
)


def register() -> None:
    """Register the environments, which the import of this module does, too."""
    for name, environment, vector, arguments in _ROWS:
        if name not in registration.registry:
            registration.register(
                name, entry_point=environment, vector_entry_point=vector, kwargs=arguments
            )


def list_environments(_options: object) -> int:
    """Print how each environment is made, and return the exit status."""
    for name, _, vector, _ in _ROWS:
        print(f'gymnasium.{"make_vec" if vector else "make"}("{__name__}:{name}")')
    return 0


register()
