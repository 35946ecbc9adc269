from __future__ import annotations

import pytest

from hgs_core.codec.format.layers import layers


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ([], []),
        ([7], [0]),
        ([25, 25, 25, 25], [0, 1, 2, 3]),
        ([24, 26, 25, 25], [0, 0, 1, 2]),
        ([1, 1, 97, 1], [0, 0, 0, 1]),
    ],
)
def test_base_is_the_shortest_beginning_with_its_part_of_the_bytes(sizes: list[int], expected: list[int]) -> None:
    assert layers(sizes, 4) == expected
