"""Registers the environments with Gymnasium, if it is installed."""

from __future__ import annotations

import gymnasium

NAME = "underbrush/Reach-v0"


def register() -> None:
    """Register ``underbrush/Reach-v0``, single and vector."""
    if NAME not in gymnasium.registry:
        gymnasium.register(
            id=NAME,
            entry_point="underbrush.gym:ReachEnv",
            vector_entry_point="underbrush.gym:ReachVectorEnv",
        )
