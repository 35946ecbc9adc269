"""GLB files of splats: glTF 2.0 with KHR_gaussian_splatting, as the Khronos Group ratified it in 2026.

A mesh of points with float32 attributes: places, rotations x, y, z, w, standard deviations, opacities, spherical
harmonics (colour is 0.5 + SH_0 of degree 0, sRGB), and linear colours for viewers that know points alone. Axes are
right, up, back.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.antialiasing_note import NOTE, noted_for_us
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.deviations import deviations_limited, deviations_of, log_scales_of
from hgs_core.interchange.far_places import middle_if_far, moved
from hgs_core.interchange.file_format import NOTHING_KNOWN, FileFormat, Reading, ReadSplats
from hgs_core.interchange.gltf.glb_container import glb_bytes, read_glb
from hgs_core.interchange.gltf.gltf_asset import GltfAsset
from hgs_core.interchange.light import srgb_replaced, to_light, to_srgb
from hgs_core.interchange.ply.gaussian_ply import NO_NEGATIVE_COLOUR, harmonics
from hgs_core.interchange.right_up_back import other_way_up, our_rotations, stored_rotations
from hgs_core.interchange.splat_properties import SH_0
from hgs_core.scene.opacities import logits_of_any, opacities_of
from hgs_core.scene.rotations import matrices, quaternions_of, unit_quaternions
from hgs_core.scene.splats import StaticSplats, joined

__all__ = ["GLB", "glb_file", "read_gaussian_glb"]

EXTENSION = "KHR_gaussian_splatting"
SRGB, LINEAR = "srgb_rec709_display", "lin_rec709_display"
UNDERSTOOD = {EXTENSION, "KHR_mesh_quantization", "KHR_materials_unlit"}  # supported requirements of files
_ROTATION, _SCALE, _OPACITY = (f"{EXTENSION}:{name}" for name in ("ROTATION", "SCALE", "OPACITY"))
_COLOUR = f"{EXTENSION}:SH_DEGREE_0_COEF_0"
_HARMONICS = [[f"{EXTENSION}:SH_DEGREE_{degree}_COEF_{n}" for n in range(2 * degree + 1)] for degree in (1, 2, 3)]


def glb_file(splats: StaticSplats[Floats], antialiased: bool = False) -> Written:
    """Return a GLB file of degree 0, 60 bytes a splat, with a note on its drawing in the asset.

    Raises:
        InputError: there are no splats: glTF knows no empty arrays.
    """
    if not len(splats):
        raise InputError("splats", "are none, and glTF holds no empty array", "choose another --time")
    opacities = opacities_of(splats.opacity_logits)
    points = np.concatenate([to_light(np.clip(splats.rgb, 0, 1)), opacities[:, None]], axis=1)
    arrays: dict[str, np.ndarray[Any, Any]] = {
        "POSITION": other_way_up(splats.means).astype("<f4"),
        _ROTATION: stored_rotations(unit_quaternions(splats.quats)).astype("<f4"),
        _SCALE: deviations_of(splats.log_scales).astype("<f4"),
        _OPACITY: opacities[:, None].astype("<f4"),
        _COLOUR: ((splats.rgb - 0.5) / SH_0).astype("<f4"),
        "COLOR_0": np.rint(points * 255).astype(np.uint8),
    }
    views, accessors, at = [], [], 0
    for number, array in enumerate(arrays.values()):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": array.nbytes, "target": 34962})
        at += array.nbytes
        bytes_ = {"componentType": 5121, "normalized": True} if array.dtype == np.uint8 else {"componentType": 5126}
        width = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[array.shape[1]]
        accessors.append({"bufferView": number, **bytes_, "count": len(array), "type": width})
    places = arrays["POSITION"]
    accessors[0] |= {"min": places.min(axis=0).tolist(), "max": places.max(axis=0).tolist()}
    primitive = {
        "mode": 0,
        "attributes": {name: number for number, name in enumerate(arrays)},
        "extensions": {EXTENSION: {"kernel": "ellipse", "colorSpace": SRGB}},
    }
    document = {
        "asset": {"version": "2.0", "generator": "HGS", "extras": {NOTE: antialiased}},
        "extensionsUsed": [EXTENSION],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": at}],
    }
    note = noted_for_us(antialiased)
    changes = (
        *([] if note is None else [note]),
        deviations_limited(splats.log_scales),
        Change.where(Action.LIMITED, "colour", splats.rgb < 0, NO_NEGATIVE_COLOUR),
    )
    return Written(glb_bytes(document, b"".join(array.tobytes() for array in arrays.values())), changes)


def read_gaussian_glb(path: Path, reading: Reading = NOTHING_KNOWN) -> ReadSplats:
    """Read the splats of the scene that a GLB file shows, in the places that its nodes give them.

    Raises:
        InputError: the file is missing, damaged, needs an extension that is not read, or holds no splats.
    """
    asset = GltfAsset(path, *read_glb(path))
    try:
        return _read(asset, reading)
    except (AttributeError, TypeError) as error:
        raise InputError(path, f"holds JSON that is no glTF ({error})", "export it again") from error


def _read(asset: GltfAsset, reading: Reading) -> ReadSplats:
    for name in asset.document.get("extensionsRequired", []):
        if name not in UNDERSTOOD:
            raise InputError(asset.path, f"needs the extension {name}", "export it without, as plain numbers")
    sets, changes, others = [], [], 0
    for mesh, world in asset.placed_meshes():
        for primitive in mesh.get("primitives", []):
            extension = primitive.get("extensions", {}).get(EXTENSION)
            if extension is None:
                others += 1
                continue
            found, more = _ellipsoids(asset, primitive.get("attributes", {}), extension)
            changes += more
            sets.append(_placed(found, world))
    if not sets:
        raise InputError(asset.path, f"holds no splats: no mesh has {EXTENSION}", "give a .glb file of splats")
    if others:
        changes.append(Change.whole(Action.LEFT_OUT, f"{others} parts of meshes", "they are no splats"))
    if asset.items("animations"):
        changes.append(Change.whole(Action.LEFT_OUT, "animations", "splats are taken as the nodes place them"))
    middle = middle_if_far(np.concatenate([one.means for one in sets])) if reading.centred else None
    changes += [] if middle is None else [moved(middle)]
    extras = asset.document.get("asset", {}).get("extras", {})
    note = extras.get(NOTE) if isinstance(extras, dict) else None
    return ReadSplats(
        joined([_in_floats(one, middle) for one in sets]),
        changes=tuple(changes),
        middle=middle,
        antialiased=note if isinstance(note, bool) else None,
    )


class _Ellipsoids(NamedTuple):
    """The splats of one primitive as glTF has them, in its own axes."""

    means: Doubles  # [N, 3]
    deviations: Doubles  # [N, 3]
    xyzw: Doubles  # [N, 4]
    opacities: Doubles  # [N], 0 to 1
    rgb: Doubles  # [N, 3], sRGB


def _ellipsoids(
    asset: GltfAsset, attributes: Mapping[str, object], extension: Mapping[str, Any]
) -> tuple[_Ellipsoids, list[Change]]:
    """Return the splats of one primitive, with omissions and changes."""
    kernel, space, deeper = (extension.get(name) for name in ("kernel", "colorSpace", "extensions"))
    if deeper:
        raise InputError(asset.path, f"stores splats by {', '.join(deeper)}", "export it without, as plain numbers")
    if kernel != "ellipse" or space not in (SRGB, LINEAR):
        problem = f"has splats of kernel {kernel!r} in colour space {space!r}"
        raise InputError(asset.path, problem, f"export it with 'ellipse' in {SRGB!r}")
    for name in ("POSITION", _ROTATION, _SCALE, _OPACITY, _COLOUR):
        if name not in attributes:
            problem = f"has splats without {name}: it follows a draft of the extension"
            raise InputError(asset.path, problem, "export it again with a newer program")
    arrays = [asset.numbers(attributes[name]) for name in ("POSITION", _SCALE, _ROTATION, _OPACITY, _COLOUR)]
    rest = [asset.numbers(attributes[name]) for names in _HARMONICS for name in names if name in attributes]
    widths = [3, 3, 4, 1, 3, *[3] * len(rest)]
    if [array.shape for array in (*arrays, *rest)] != [(len(arrays[0]), width) for width in widths]:
        raise InputError(asset.path, "has splats whose attributes differ in number or kind", "export it again")
    means, scales, quats, opacities, colours = arrays
    if (scales < 0).any():
        problem = f"has negative {_SCALE}: it follows a draft of the extension, of logarithms"
        raise InputError(asset.path, problem, "export it again with a newer program")
    rgb = 0.5 + SH_0 * colours
    changes = [Change.where(Action.LIMITED, "opacity", (opacities < 0) | (opacities > 1), "to 0 to 1")]
    if rest:
        changes.append(harmonics(np.concatenate(rest, axis=1) != 0))
    if space == LINEAR:
        rgb = to_srgb(rgb)
        changes.append(srgb_replaced(len(rgb)))
    return _Ellipsoids(means, scales, quats, np.clip(opacities[:, 0], 0, 1), rgb), changes


def _placed(found: _Ellipsoids, world: Doubles) -> _Ellipsoids:
    """Return splats where a node's matrix [4, 4] puts them, in our axes.

    Under a matrix that is no identity an ellipsoid M R S becomes the one of its singular values and left vectors.
    """
    means, deviations, xyzw, opacities, rgb = found
    if not np.array_equal(world, np.eye(4)):
        linear = world[:3, :3]
        means = means @ linear.T + world[:3, 3]
        ellipsoids = linear @ (matrices(unit_quaternions(xyzw[:, [3, 0, 1, 2]])) * deviations[:, None, :])
        finite = np.asarray(np.isfinite(ellipsoids).all(axis=(1, 2)))
        axes, deviations, _ = np.linalg.svd(np.where(finite[:, None, None], ellipsoids, 0.0))
        axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]
        deviations = np.where(finite[:, None], deviations, np.nan)
        xyzw = quaternions_of(axes)[:, [1, 2, 3, 0]]
    return _Ellipsoids(other_way_up(means), deviations, xyzw, opacities, rgb)


def _in_floats(found: _Ellipsoids, middle: Doubles | None) -> StaticSplats[Floats]:
    """Return splats in numbers of 32 bits, with the offset subtracted from all places."""
    means = found.means if middle is None else found.means - middle
    return StaticSplats(
        means.astype(np.float32),
        log_scales_of(found.deviations),
        our_rotations(found.xyzw).astype(np.float32),
        logits_of_any(found.opacities),
        found.rgb.astype(np.float32),
    )


GLB = FileFormat(".glb", read=read_gaussian_glb, write_still=glb_file)
