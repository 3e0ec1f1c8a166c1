"""The steering network: a small convolutional network from the view of the road to an answer.

Reference: Bojarski et al., "End to End Learning for Self-Driving Cars", arXiv:1604.07316, 2016.
"""

from __future__ import annotations

import zipfile

import numpy as np

from sdc_perception.imitation_samples import Answer

try:
    import torch
    from torch import nn
except ImportError as error:
    raise ImportError(
        "torch is not installed; run docker/prepare imitation in the folder of the project"
    ) from error

# The network computes answers in these units, so that both are about as large.
UNITS = np.array([0.05, 2.0], np.float32)
_MIDDLE = np.array([0.0, 6.0], np.float32)
_LIMITS = np.array([[-0.25, 2.0], [0.25, 10.0]], np.float32)
_FORMAT = "sdc steering network 1"
_FIX = "train one with python3 -m sdc_perception.imitation.train"


def build_network() -> nn.Sequential:
    """Return an untrained network: views (N, 3, 40, 128) of 0..1 to answers (N, 2) in UNITS."""
    return nn.Sequential(
        nn.Conv2d(3, 16, 5, stride=2),
        nn.ReLU(),
        nn.Conv2d(16, 32, 5, stride=2),
        nn.ReLU(),
        nn.Conv2d(32, 48, 3, stride=2),
        nn.ReLU(),
        nn.Conv2d(48, 48, 3),
        nn.ReLU(),
        nn.Flatten(),
        nn.Linear(48 * 12, 64),
        nn.ReLU(),
        nn.Linear(64, 2),
    )


def to_units(answers: np.ndarray) -> np.ndarray:
    """Return answers (N, 2) of curvature [1/m] and speed [m/s] in the units of the network."""
    return ((answers - _MIDDLE) / UNITS).astype(np.float32)


def network_input(views: np.ndarray) -> torch.Tensor:
    """Return views (N, 40, 128, 3) uint8 as the input (N, 3, 40, 128) of the network."""
    return torch.from_numpy(np.ascontiguousarray(views)).permute(0, 3, 1, 2).float() / 255.0


class SteeringNetwork:
    """A trained network.

    Attributes:
        layers: the layers, see build_network
    """

    def __init__(self, layers: nn.Sequential):
        self.layers = layers.eval()

    def answer(self, view: np.ndarray) -> Answer:
        """Return the answer to a view of the road (40, 128, 3), limited to what a car can do."""
        with torch.no_grad():
            output = self.layers(network_input(view[None]))[0].numpy()
        return Answer(*np.clip(_MIDDLE + UNITS * output, *_LIMITS).tolist())

    def save(self, path: str) -> None:
        """Write the weights to a file of NumPy's format npz, which holds no code."""
        weights = {name: value.numpy() for name, value in self.layers.state_dict().items()}
        with open(path, "wb") as file:
            np.savez(file, format=_FORMAT, **weights)

    @classmethod
    def load(cls, path: str) -> SteeringNetwork:
        """Read a network.

        Raises:
            ValueError: the file is missing or is not the file of a network; the message is one line
                that names it
        """
        # One picture is too small for several threads.
        torch.set_num_threads(1)
        layers = build_network()
        wanted = layers.state_dict()
        try:
            with np.load(path, allow_pickle=False) as file:
                if "format" not in file or str(file["format"]) != _FORMAT:
                    raise ValueError(f"it has no entry 'format' of '{_FORMAT}'")
                weights = {name: file[name] for name in wanted if name in file}
        except FileNotFoundError as error:
            raise ValueError(f"{path}: there is no such file; {_FIX}") from error
        except (OSError, ValueError, EOFError, AttributeError, zipfile.BadZipFile) as error:
            raise ValueError(f"{path}: is not a steering network: {error}; {_FIX}") from error
        for name, value in wanted.items():
            found = weights.get(name)
            good = found is not None and found.dtype == np.float32 and found.shape == value.shape
            if not good or not np.isfinite(found).all():
                raise ValueError(
                    f"{path}: the weights '{name}' are missing, of another size or not finite; "
                    f"{_FIX}"
                )
        layers.load_state_dict({name: torch.from_numpy(value) for name, value in weights.items()})
        return cls(layers)
