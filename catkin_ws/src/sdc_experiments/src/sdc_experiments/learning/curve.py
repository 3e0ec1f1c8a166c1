"""Draw the learning curve of `train`: python3 -m sdc_experiments.learning.curve [PICTURE.png]."""

from __future__ import annotations

import sys
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from sdc_experiments.learning.train import drive, train

_UNSEEN_SEEDS = range(1000, 1010)


def main() -> None:
    """Train, drive unseen routes, print the results and write the picture."""
    path = sys.argv[1] if len(sys.argv) > 1 else "learning.png"
    begin_s, begin_cpu_s = time.perf_counter(), time.process_time()
    weights, curve = train()
    wall_s, cpu_s = time.perf_counter() - begin_s, time.process_time() - begin_cpu_s
    print(f"training: {wall_s:.0f} s, {cpu_s:.0f} s of CPU time")
    for seed in _UNSEEN_SEEDS:
        status, rms_m = drive(weights, seed)
        print(f"route {seed}: {status}, cross-track error {rms_m:.3f} m RMS")
    figure, axes = plt.subplots(figsize=(7.0, 3.2), layout="constrained")
    axes.plot(range(len(curve)), curve, marker="o", color="tab:blue")
    axes.set_xlabel("generation")
    axes.set_ylabel("mean return of the best policies")
    axes.set_ylim(bottom=min(0.0, min(curve)))
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
