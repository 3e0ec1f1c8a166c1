"""Train a linear policy with the cross-entropy method."""

from __future__ import annotations

import gymnasium
import numpy as np

from sdc_experiments.learning.observation import NAMES

DEVIATIONS = [0.3, 1.0, 0.3, 3.0, 3.0, 3.0, 3.0, 0.3, 0.3, 0.3, 0.3]  # of the first weights
SPEED, ERROR, TURN = NAMES.index("speed_mps"), NAMES.index("cross_track_m"), NAMES.index("steer")
BENDS, LIMITS = NAMES.index("curvature_0m"), NAMES.index("speed_limit_0m_mps")


def act(weights: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the actions (N, 2) of policies with these weights (N, 11)."""
    limits, speed = seen[:, LIMITS : LIMITS + 3], seen[:, [SPEED]]
    pace = np.hstack([np.minimum(limits - speed, 3.0), np.minimum(limits[:, 1:2], 1.0)])
    road = np.hstack([seen[:, ERROR:TURN], seen[:, BENDS : BENDS + 4]])
    actions = np.sum(weights[:, 7:] * pace, 1), np.sum(weights[:, :7] * road, 1)
    return np.clip(np.column_stack(actions), -1.0, 1.0).astype(np.float32)


def train(generations: int = 10, policies: int = 48, routes: int = 6, ticks: int = 800) -> tuple:
    """Return the weights, and the mean return of the best policies of each generation."""
    random = np.random.default_rng(0)
    mean, deviation, curve = np.zeros(11), np.array(DEVIATIONS), []
    cars = gymnasium.make_vec("SdcRandomRoutes-v0", policies * routes, routes=routes)
    for generation in range(generations):
        weights = mean + deviation * random.standard_normal((policies, 11))
        every = np.repeat(weights, routes, axis=0)
        seen, _ = cars.reset(seed=routes * generation)
        total, lasts = np.zeros(len(every)), np.ones(len(every), bool)
        for _ in range(min(ticks, 200 + 100 * generation)):
            seen, rewards, ended, truncated, _ = cars.step(act(every, seen))
            total += np.where(lasts, rewards, 0.0)
            lasts &= ~(ended | truncated)
        returns = total.reshape(policies, routes).mean(axis=1)
        best = np.argsort(returns)[-policies // 6 :]
        mean, deviation = weights[best].mean(axis=0), weights[best].std(axis=0) + 0.01
        curve.append(float(returns[best].mean()))
        print(f"generation {generation}: {curve[-1]:.1f}", flush=True)
    return mean, curve


def drive(weights: np.ndarray, seed: int) -> tuple[str, float]:
    """Drive a random route; return how the drive ended and the RMS of the cross-track error [m]."""
    car = gymnasium.make("SdcRandomRoutes-v0")
    seen, info = car.reset(seed=seed)
    errors, over = [], False
    while not over:
        seen, _, ended, truncated, info = car.step(act(weights[None], seen[None])[0])
        errors.append(info["cross_track_m"])
        over = ended or truncated
    return info["status"] or "truncated", float(np.sqrt(np.mean(np.square(errors))))


if __name__ == "__main__":
    policy, _ = train()
    print([drive(policy, seed) for seed in range(1000, 1005)])
