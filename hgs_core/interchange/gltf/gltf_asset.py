"""The content of a glTF 2.0 document and its block of bytes: arrays of numbers, and meshes in their places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.base.errors import InputError
from hgs_core.scene.rotations import matrices, unit_quaternions

__all__ = ["GltfAsset"]

_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_UNREAD = "save it as one GLB file of plain numbers"


@dataclass(frozen=True)
class GltfAsset:
    """A document and its bytes; `path` is for messages. Every method raises InputError where these do not fit."""

    path: Path
    document: dict[str, Any]
    binary: bytes

    def items(self, kind: str) -> list[dict[str, Any]]:
        """Return all of a kind, such as "meshes"."""
        found = self.document.get(kind, [])
        if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
            raise InputError(self.path, f"has {kind} that are no list of objects", "export it again")
        return found

    def item(self, kind: str, index: object) -> dict[str, Any]:
        """Return one of a kind by its number."""
        found = self.items(kind)
        if type(index) is not int or not 0 <= index < len(found):
            raise InputError(self.path, f"names {kind} {index!r} of {len(found)}", "export it again")
        return found[index]

    def numbers(self, index: object) -> Doubles:
        """Return the numbers of an accessor [N, C]; normalised integers are 0 to 1, or -1 to 1."""
        accessor = self.item("accessors", index)
        kind, width = _COMPONENTS.get(accessor.get("componentType", 0)), _WIDTHS.get(accessor.get("type", ""))
        if kind is None or width is None:
            problem = f"of type {accessor.get('type')} and component type {accessor.get('componentType')}"
            raise InputError(self.path, f"has accessor {index} {problem}", "export it again")
        if "sparse" in accessor or "bufferView" not in accessor:
            raise InputError(self.path, f"has accessor {index}, which is sparse or has no bytes of its own", _UNREAD)
        view = self.item("bufferViews", accessor["bufferView"])
        buffer = self.item("buffers", view.get("buffer"))
        if view["buffer"] != 0 or "uri" in buffer:
            raise InputError(self.path, f"keeps accessor {index} outside of its own bytes", _UNREAD)
        dtype = np.dtype(kind)
        count, first, skipped, size, stride = (
            self._whole(source, name, default)
            for source, name, default in (
                (accessor, "count", -1),
                (view, "byteOffset", 0),
                (accessor, "byteOffset", 0),
                (view, "byteLength", -1),
                (view, "byteStride", width * dtype.itemsize),
            )
        )
        element = width * dtype.itemsize
        needed, there = skipped + (count - 1) * stride + element, min(size, len(self.binary) - first)
        if count and (stride < element or needed > there):
            problem = f"has accessor {index} of {count} elements in {there} bytes, {stride} apart"
            raise InputError(self.path, problem, "copy it again")
        strides = (stride, dtype.itemsize)
        rows = np.ndarray((count, width), dtype, self.binary, first + skipped, strides).astype(np.float64)
        if accessor.get("normalized") and dtype.kind != "f":
            rows = np.maximum(rows / np.iinfo(dtype).max, -1.0)
        return rows

    def placed_meshes(self) -> Iterator[tuple[dict[str, Any], Doubles]]:
        """Yield the meshes of the scene that is shown, each with the matrix [4, 4] that places it in the world."""
        nodes = self.items("nodes")
        if self.items("scenes"):
            roots = self.item("scenes", self.document.get("scene", 0)).get("nodes", [])
        else:
            children = {child for node in nodes for child in node.get("children", [])}
            roots = [number for number in range(len(nodes)) if number not in children]
        waiting, placed = [(number, np.eye(4)) for number in reversed(roots)], set()
        while waiting:
            number, parent = waiting.pop()
            node = self.item("nodes", number)
            if number in placed:
                raise InputError(self.path, f"has node {number} in two places", "export it again")
            placed.add(number)
            world = parent @ self._local(node, number)
            if "mesh" in node:
                yield self.item("meshes", node["mesh"]), world
            waiting += [(child, world) for child in reversed(node.get("children", []))]

    def _local(self, node: dict[str, Any], number: int) -> Doubles:
        """Return the matrix of a node: as it stands, or of its translation, rotation x, y, z, w and scale."""
        defaults = {"matrix": np.eye(4).ravel(), "translation": [0] * 3, "rotation": [0, 0, 0, 1], "scale": [1] * 3}
        try:
            found = {name: np.array(node.get(name, value), np.float64) for name, value in defaults.items()}
            whole, move, turn, scale = (found[name].reshape(-1) for name in defaults)
            local = whole.reshape(4, 4).T
            if "matrix" not in node:
                local[:3, :3] = matrices(unit_quaternions(turn.reshape(1, 4)[:, [3, 0, 1, 2]]))[0] * scale.reshape(3)
                local[:3, 3] = move
            if not np.isfinite(local).all():
                raise ValueError
        except (TypeError, ValueError) as error:
            raise InputError(self.path, f"has node {number} in a place that is none", "export it again") from error
        return local

    def _whole(self, source: dict[str, Any], name: str, default: int) -> int:
        value = source.get(name, default)
        if type(value) is not int or value < 0:
            raise InputError(self.path, f"has {name} {value!r}", "export it again")
        return value
