from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from hgs_core.fit.fit_config import BUDGETS, EncodeConfig


def test_the_budget_is_one_of_those_there_are() -> None:
    assert [EncodeConfig(budget=name).budget for name in BUDGETS] == ["low", "default", "high"]
    with pytest.raises(InputError, match=r"config\.encode\.budget: unknown choice 'free'; use low, default or high"):
        EncodeConfig(budget="free")


def test_fine_tuning_is_a_share_of_the_training() -> None:
    assert EncodeConfig().fine_tune_iterations(20_000) == 333
    assert EncodeConfig(fine_tune=0.0).fine_tune_iterations(20_000) == 0
    with pytest.raises(InputError, match=r"config\.encode\.fine_tune: .*1\.5"):
        EncodeConfig(fine_tune=1.5)
