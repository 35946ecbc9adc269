"""The attributes a chunk can hold: their numbers, shapes and quantisers (docs/format.md, "Attributes")."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from hgs_core.codec.streams import Transform

__all__ = ["ATTRIBUTES", "BY_ID", "MOTION_ORDERS", "Attribute", "Kind", "Quantiser"]


class Kind(IntEnum):
    """What the splats of a chunk are."""

    STATIC = 0
    DYNAMIC = 1


class Quantiser(IntEnum):
    """How the codes of an attribute are laid out and turned into numbers."""

    AFFINE = 0  # origin + code * step
    MORTON = 1  # the same, the three codes interleaved and stored as differences
    SMALLEST_THREE = 2  # the same for three components of a unit quaternion, and the index of the fourth


@dataclass(frozen=True)
class Attribute:
    """One attribute: its id on the wire never changes its meaning."""

    id: int
    name: str
    components: int
    quantiser: Quantiser = Quantiser.AFFINE
    transforms: tuple[Transform, ...] = (Transform.NONE, Transform.DELTA)  # those an encoder tries
    dynamic_only: bool = False
    optional: bool = False  # absent means zero


ATTRIBUTES: dict[str, Attribute] = {
    attribute.name: attribute
    for attribute in (
        Attribute(1, "position", 3, Quantiser.MORTON, (Transform.NONE,)),
        Attribute(2, "log_scale", 3),
        Attribute(3, "rotation", 3, Quantiser.SMALLEST_THREE),
        Attribute(4, "opacity", 1),
        Attribute(5, "rgb", 3, transforms=(Transform.NONE, Transform.DELTA, Transform.GREEN)),
        Attribute(16, "time_center", 1, dynamic_only=True),
        Attribute(17, "time_log_precision", 1, dynamic_only=True),
        Attribute(18, "time_exponent", 1, dynamic_only=True),
        Attribute(19, "velocity", 3, dynamic_only=True, optional=True),
        Attribute(20, "acceleration", 3, dynamic_only=True, optional=True),
        Attribute(21, "jerk", 3, dynamic_only=True, optional=True),
        Attribute(22, "turning", 4, dynamic_only=True, optional=True),
    )
}
"""By name, in the order in which a chunk stores them."""

BY_ID: dict[int, Attribute] = {attribute.id: attribute for attribute in ATTRIBUTES.values()}

MOTION_ORDERS: tuple[str, ...] = ("velocity", "acceleration", "jerk")
"""The attributes of the motion polynomial's coefficients of order 1, 2 and 3."""
