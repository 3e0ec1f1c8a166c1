"""Train PPO of stable-baselines3 for some 100,000 steps, and print what it learned.

It needs stable-baselines3, which `docker/prepare sb3` installs.
"""

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import sdc_experiments.learning  # noqa: F401

STEPS = 20_000


def main():
    torch.set_num_threads(1)
    model = PPO(
        "MlpPolicy", make_vec_env("SdcRandomRoutes-v0", 8, seed=0), n_steps=256, gamma=0.97, seed=0
    )
    for _ in range(5):
        model.learn(STEPS, reset_num_timesteps=False)
        episodes = [episode["r"] for episode in model.ep_info_buffer]
        print(f"{model.num_timesteps} steps: mean return {np.mean(episodes):.1f}", flush=True)


if __name__ == "__main__":
    main()
