"""Views of the road with the answers of the expert, in a file."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass

import numpy as np

from sdc_perception.imitation_samples import VIEW_SHAPE


@dataclass(frozen=True)
class Samples:
    """Views and answers, a row for each picture."""

    views: np.ndarray  # (N, 40, 128, 3) views of the road, uint8
    answers: np.ndarray  # (N, 2) curvature [1/m] and speed [m/s]
    off_line: np.ndarray  # (N,) whether the car was off the line of the expert

    def __post_init__(self):
        count = len(self.views)
        if self.views.shape != (count, *VIEW_SHAPE, 3) or self.views.dtype != np.uint8:
            raise ValueError(f"views must be (N, {VIEW_SHAPE[0]}, {VIEW_SHAPE[1]}, 3) uint8")
        if self.answers.shape != (count, 2) or not np.isfinite(self.answers).all():
            raise ValueError("answers must be (N, 2) and finite")
        if self.off_line.shape != (count,) or self.off_line.dtype != bool:
            raise ValueError("off_line must be (N,) and true or false")
        if not count:
            raise ValueError("there are no views")

    def __len__(self) -> int:
        return len(self.views)

    def only(self, kept: np.ndarray) -> Samples:
        """Return some of the rows."""
        return Samples(self.views[kept], self.answers[kept], self.off_line[kept])

    @staticmethod
    def joined(parts: list[Samples]) -> Samples:
        """Return the rows of all parts."""
        return Samples(
            np.concatenate([part.views for part in parts]),
            np.concatenate([part.answers for part in parts]),
            np.concatenate([part.off_line for part in parts]),
        )

    def save(self, path: str) -> None:
        """Write a file of NumPy's format npz."""
        with open(path, "wb") as file:
            np.savez(file, views=self.views, answers=self.answers, off_line=self.off_line)

    @staticmethod
    def load(path: str) -> Samples:
        """Read a file.

        Raises:
            ValueError: the file is missing or not valid; the message is one line that names it
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                return Samples(file["views"], file["answers"], file["off_line"])
        except FileNotFoundError as error:
            raise ValueError(
                f"{path}: there is no such file; record one with "
                "python3 -m sdc_perception.imitation.record"
            ) from error
        except (
            OSError,
            ValueError,
            KeyError,
            EOFError,
            AttributeError,
            zipfile.BadZipFile,
        ) as error:
            raise ValueError(f"{path}: is not a file of samples: {error}") from error
