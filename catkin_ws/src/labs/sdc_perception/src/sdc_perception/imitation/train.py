"""Train the steering network.

python3 -m sdc_perception.imitation.train SAMPLES NETWORK [--on-line-only] [--lesson FILE]
"""

from __future__ import annotations

import argparse
import runpy
import sys
import time
from typing import Any

import numpy as np

from sdc_perception.imitation.samples import Samples

# This module reports in one line that PyTorch is missing.
from sdc_perception.imitation_network import (
    SteeringNetwork,
    build_network,
    network_input,
    nn,
    to_units,
    torch,
)

EPOCHS = 10
_BATCH = 64
_RATE = 1e-3
# Edges of the bins that a student balances [1/m].
CURVATURES_1PM = np.array([-0.08, -0.04, -0.01, 0.01, 0.04, 0.08])
# One picture in so many is not trained on and measures the error.
_VALIDATION_EVERY = 10


def train(
    samples: Samples, updates: int, seed: int = 0, lesson: dict[str, Any] | None = None
) -> SteeringNetwork:
    """Return a trained network; print how well it is trained after each tenth of the updates.

    Args:
        samples: the samples
        updates: number of updates of the weights, each with 64 samples
        seed: seed of the first weights and of the order of the samples
        lesson: a student's `balance` and `loss` by name; None: all samples alike, and PyTorch's
    """
    # A batch is too small for two threads, and with one the result is the same on all machines.
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    targets = torch.from_numpy(to_units(samples.answers))
    # Blocks of neighbours: the picture before and after a validation picture looks the same.
    held_out = np.arange(len(samples)) // 100 % _VALIDATION_EVERY == 1
    trained, kept = np.flatnonzero(~held_out), np.flatnonzero(held_out)
    layers = build_network()
    optimizer = torch.optim.Adam(layers.parameters(), _RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, updates)
    loss_of = lesson["loss"] if lesson else nn.functional.smooth_l1_loss
    shown = lesson["balance"](samples.answers[trained, 0], CURVATURES_1PM) if lesson else None
    losses = []
    for update in range(1, updates + 1):
        batch = random.choice(trained, _BATCH, p=shown)
        views = network_input(samples.views[batch])
        # Brighter and darker pictures: the light of another hour.
        views *= torch.from_numpy(random.uniform(0.5, 1.3, (_BATCH, 1, 1, 1)).astype(np.float32))
        loss = loss_of(layers(views), targets[batch])
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        losses.append(loss.item())
        if update % max(1, updates // 10) == 0:
            network = SteeringNetwork(layers)
            errors = validate(network, samples.only(kept)) if len(kept) else (np.nan, np.nan)
            layers.train()
            print(
                f"{update:6d} updates: loss {np.mean(losses):.4f}, curvature error "
                f"{errors[0]:.4f} 1/m, speed error {errors[1]:.2f} m/s",
                flush=True,
            )
            losses = []
    return SteeringNetwork(layers)


def validate(network: SteeringNetwork, samples: Samples) -> tuple[float, float]:
    """Return the root mean square errors of curvature [1/m] and speed [m/s]."""
    answers = np.array([network.answer(view) for view in samples.views])
    errors = np.sqrt(np.mean((answers - samples.answers) ** 2, axis=0))
    return float(errors[0]), float(errors[1])


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="train the steering network")
    parser.add_argument("samples", help="file of sdc_perception.imitation.record")
    parser.add_argument("network", help="file to write")
    parser.add_argument("--epochs", type=int, default=EPOCHS, help="how often each picture is used")
    parser.add_argument(
        "--on-line-only", action="store_true", help="leave out all pictures off the line"
    )
    parser.add_argument("--lesson", help="file with your balance and loss, see imitation.check")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    started_s, cpu_s = time.monotonic(), time.process_time()
    try:
        samples = Samples.load(options.samples)
        updates = options.epochs * len(samples) // _BATCH
        if options.on_line_only:
            samples = samples.only(~samples.off_line)
        lesson = runpy.run_path(options.lesson) if options.lesson else None
        network = train(samples, updates, options.seed, lesson)
        network.save(options.network)
    except (OSError, ValueError) as error:
        sys.exit(f"train: {error}")
    print(
        f"{options.network}: {len(samples)} pictures, {time.monotonic() - started_s:.0f} s "
        f"({time.process_time() - cpu_s:.0f} s of CPU time)"
    )


if __name__ == "__main__":
    main()
