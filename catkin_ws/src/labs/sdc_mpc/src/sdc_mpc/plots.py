"""The picture of docs/labs/mpc.md: python3 -m sdc_mpc.plots [FOLDER]."""

from __future__ import annotations

import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from sdc_mpc.drives import VARIANTS, drive_bends  # noqa: E402

_STYLE = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 10, "savefig.dpi": 110}
_COLOURS = {"nervous": "#e0a59d", "lazy": "#3a8a4d", "default": "#2a6fb0"}
_SEED = 2


def draw(path: str) -> None:
    """Draw cross-track errors and wheel angles of three drivers on one road into a file."""
    with plt.rc_context(_STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 3.6), constrained_layout=True)
        for name, colour in _COLOURS.items():
            rows = drive_bends(_SEED, VARIANTS[name]).rows
            left.plot(rows[:, 1], 100.0 * rows[:, 2], color=colour, lw=1.0, label=name)
            right.plot(rows[:, 1], rows[:, 4], color=colour, lw=1.0, label=name)
        left.set(xlabel="along the road [m]", ylabel="cross-track error [cm]", ylim=(-50, 50))
        right.set(xlabel="along the road [m]", ylabel="wheel angle [rad]", ylim=(-0.2, 0.2))
        left.legend(frameon=False)
        figure.savefig(path)


if __name__ == "__main__":
    draw(os.path.join(sys.argv[1] if len(sys.argv) > 1 else "docs/labs", "mpc_drive.png"))
