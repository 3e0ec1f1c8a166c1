"""Look-up of boxes near a place of the map."""

from __future__ import annotations

import numpy as np

from sdc_sim.road.spatial_index import COLUMN_STRIDE, cell_keys, cells_of


class CellIndex:
    """Boxes in square cells, for finding those near a place.

    A SciPy KD-tree finds points, not boxes; Shapely's STRtree has different interfaces in versions
    1.8 and 2.0.
    """

    def __init__(self, lower_m: np.ndarray, upper_m: np.ndarray, cell_m: float):
        """Put boxes into cells.

        Args:
            lower_m: (N, 2) lower corners of the boxes [m]
            upper_m: (N, 2) upper corners, at most `2 * cell_m` from the lower ones in x and y [m]
            cell_m: side of a cell [m]
        """
        self.cell_m = float(cell_m)
        lower, upper = cells_of(lower_m, cell_m), cells_of(upper_m, cell_m)
        keys, owners = [], []
        for dx in range(3):
            for dy in range(3):
                inside = (lower[:, 0] + dx <= upper[:, 0]) & (lower[:, 1] + dy <= upper[:, 1])
                keys.append(cell_keys(lower[inside] + (dx, dy)))
                owners.append(np.flatnonzero(inside))
        all_keys, all_owners = np.concatenate(keys), np.concatenate(owners)
        order = np.lexsort((all_owners, all_keys))
        owners_by_cell = all_owners[order]
        found, starts = np.unique(all_keys[order], return_index=True)
        self._owners = {
            int(key): part for key, part in zip(found, np.split(owners_by_cell, starts[1:]))
        }

    def near(self, lower_m: np.ndarray, upper_m: np.ndarray) -> np.ndarray:
        """Return the sorted numbers of the boxes in all cells that a rectangle touches.

        Args:
            lower_m: (2,) lower corner of the rectangle [m]
            upper_m: (2,) upper corner of the rectangle [m]
        """
        first, last = cells_of(lower_m, self.cell_m), cells_of(upper_m, self.cell_m)
        found = []
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                owners = self._owners.get(i * COLUMN_STRIDE + j)
                if owners is not None:
                    found.append(owners)
        if not found:
            return np.zeros(0, np.int64)
        return found[0] if len(found) == 1 else np.unique(np.concatenate(found))
