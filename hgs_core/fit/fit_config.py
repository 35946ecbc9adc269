"""The config of encoding; free of torch, so that the API can validate it."""

from __future__ import annotations

from dataclasses import dataclass

from hgs_core.base.config_fields import check_fields

__all__ = ["BUDGETS", "EncodeConfig"]

BUDGETS: dict[str, float] = {"low": 0.8, "default": 0.1, "high": 0.02}
"""The allowed loss of training views and of their moving pixels, dB; others lose less."""


@dataclass(frozen=True)
class EncodeConfig:
    """How a trained scene is encoded."""

    budget: str = "default"  # one of `BUDGETS`
    by_segment: bool = False  # every segment as soon as it is trained, so that it can be watched while others are made

    def __post_init__(self) -> None:
        """Check the budget.

        Raises:
            InputError: it is none of `BUDGETS`.
        """
        check_fields(self, "config.encode", {}, {"budget": tuple(BUDGETS)})
