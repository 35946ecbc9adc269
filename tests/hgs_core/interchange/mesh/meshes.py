"""One surface as files of every format of meshes."""

from __future__ import annotations

import struct

import numpy as np

from hgs_core.interchange.gltf.glb_container import glb_bytes

__all__ = ["FILES", "TRIANGLES", "VERTICES", "glb", "obj", "ply"]

VERTICES = np.array([[0, 0, 1], [2, 0, 1], [2, 1, 3], [0, 1, 3]], np.float64)
TRIANGLES = [[0, 1, 2], [0, 2, 3]]


def ply(order: str) -> bytes:
    kinds = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}
    head = (
        f"ply\nformat {kinds[order]} 1.0\nelement face 2\nproperty uchar flags\n"
        "property list uchar int vertex_indices\n"
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nend_header\n"
    )
    if not order:
        faces = "".join(f"7 3 {a} {b} {c}\n" for a, b, c in TRIANGLES)
        return (head + faces + "".join(f"{x} {y} {z} 255\n" for x, y, z in VERTICES)).encode()
    faces = b"".join(struct.pack(f"{order}BB3i", 7, 3, *triangle) for triangle in TRIANGLES)
    return head.encode() + faces + b"".join(struct.pack(f"{order}3fB", *vertex, 255) for vertex in VERTICES)


def obj() -> bytes:
    places = "".join(f"v {x} {y} {z} 0.5 0.5 0.5\n" for x, y, z in VERTICES)
    return f"# a wall\no wall\n{places}vn 0 0 1\nf 1/1/1 2//1 3\nf -4 -2 -1\n".encode()


def glb() -> bytes:
    """A mesh half as wide, in a node that doubles x and lifts z by 1, beside a cloud of points."""
    places = ((VERTICES - (0, 0, 1)) / (2, 1, 1)).astype("<f4").tobytes()
    indices = np.array(TRIANGLES, "<u2").tobytes()
    views = [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4},
        {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 6},
    ]
    primitives = [{"attributes": {"POSITION": 0}, "indices": 1}, {"attributes": {"POSITION": 0}, "mode": 0}]
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 60}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": primitives}],
        "nodes": [{"mesh": 0, "scale": [2, 1, 1], "translation": [0, 0, 1]}],
        "scenes": [{"nodes": [0]}],
    }
    return glb_bytes(document, places + indices)


FILES = {"a.ply": ply("<"), "b.PLY": ply(">"), "c.ply": ply(""), "d.obj": obj(), "e.glb": glb()}
