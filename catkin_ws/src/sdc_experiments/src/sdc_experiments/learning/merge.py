"""Train a small policy to merge into a motorway: python3 -m sdc_experiments.learning.merge."""

from __future__ import annotations

import gymnasium
import numpy as np

import sdc_experiments.learning  # noqa: F401  registers the environments
from sdc_experiments.learning.traffic_environment import LIMIT_MPS, OPEN_M, TRAFFIC_NAMES

# The first policy keeps speed and distance, and changes lanes at once.
FIRST = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.3, 0.1, 0.0, 0.0, 0.0])
DEVIATIONS = np.array([1.0, 0.5, 0.5, 0.3, 0.3, 0.5, 0.1, 0.2, 0.1, 0.3, 0.3, 0.3])


def act(weights: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the actions (N, 2) of policies with these weights (N, 12)."""
    see = dict(zip(TRAFFIC_NAMES, seen.T))
    speed, on_ramp = see["speed_mps"], see["own_ends_m"] < OPEN_M
    ahead, behind, own = (
        np.minimum(see[f"{name}_m"], 50.0) for name in ("left_ahead", "left_behind", "own_ahead")
    )
    closing = see["left_ahead_mps"], see["left_behind_mps"]
    change = np.ones_like(speed), ahead / 10.0, behind / 10.0, *closing, see["own_ends_m"] / 100.0
    changes = on_ramp & (np.sum(weights[:, :6].T * change, 0) > 0.0)
    pace = (
        np.clip(LIMIT_MPS - speed, -5.0, 5.0),
        np.minimum(own - 1.5 * speed, 0.0) / 10.0,
        np.minimum(see["own_ahead_mps"], 0.0) * (own < 50.0),
        on_ramp * np.minimum(ahead - speed, 0.0) / 10.0,
        on_ramp * np.minimum(behind - speed, 0.0) / 10.0,
        on_ramp * np.maximum(60.0 - see["own_ends_m"], 0.0) / 10.0,
    )
    pedals = np.sum(weights[:, 6:].T * pace, 0)
    # A given law steers to the middle of the lane.
    heading = np.clip(-0.03 * (see["cross_track_m"] - 3.5 * changes), -0.06, 0.06)
    steer = 0.15 * (see["heading_error_rad"] - heading)
    return np.clip(np.column_stack([pedals, steer]), -1.0, 1.0).astype(np.float32)


def drive(weights: np.ndarray, worlds: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return returns and statuses (P, worlds) of policies (P, 12), each in the same worlds."""
    every = np.repeat(weights, worlds, axis=0)
    cars = gymnasium.make_vec("SdcTraffic-v0", len(every))
    seen, _ = cars.reset(seed=[*range(seed, seed + worlds)] * len(weights))
    total, status = np.zeros(len(every)), np.full(len(every), "", object)
    lasts = np.ones(len(every), bool)
    while lasts.any():
        seen, rewards, ended, truncated, info = cars.step(act(every, seen))
        total += np.where(lasts, rewards, 0.0)
        status = np.where(lasts, info["status"], status)
        lasts &= ~(ended | truncated)
    return total.reshape(-1, worlds), status.reshape(-1, worlds)


def train(generations: int = 12, policies: int = 48, worlds: int = 64) -> np.ndarray:
    """Return the weights that the cross-entropy method finds."""
    random, mean, deviation = np.random.default_rng(0), FIRST, DEVIATIONS
    for generation in range(generations):
        weights = mean + deviation * random.standard_normal((policies, len(mean)))
        returns = drive(weights, worlds, worlds * generation)[0].mean(axis=1)
        best = np.argsort(returns)[-policies // 6 :]
        mean, deviation = weights[best].mean(axis=0), weights[best].std(axis=0) + 0.01
        print(f"generation {generation}: {returns[best].mean():.1f}", flush=True)
    return mean


if __name__ == "__main__":
    for name, policy in (("before", FIRST), ("after", train())):
        _, statuses = drive(policy[None], 1000, 100_000)
        print(f"{name}: {np.mean(statuses == 'completed'):.1%} of 1,000 drives merge")
