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
    fine_tune: float = 1 / 60  # share of `train.iterations` that the scene is trained further as it decodes; 0: none
    by_segment: bool = False  # every segment as soon as it is trained, so that it can be watched while others are made

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        check_fields(self, "config.encode", {"fine_tune": (0.0, 1.0)}, {"budget": tuple(BUDGETS)})

    def fine_tune_iterations(self, trained: int) -> int:
        """Return the iterations of fine-tuning after so many of training."""
        return round(trained * self.fine_tune)
