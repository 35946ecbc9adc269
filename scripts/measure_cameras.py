"""How far cameras that are found from a capture's pictures lie from the capture's own.

    python -m scripts.measure_cameras CAPTURE [--cameras A,B,...] [--known]

Angles and distances are after the best similarity transform of the centres (Umeyama 1991).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.progress import silent
from hgs_core.calibrate.calibration_views import Pinhole, look
from hgs_core.calibrate.find_cameras import cameras_of_views
from hgs_core.calibrate.structure import Solution
from hgs_core.capture.open import open_capture
from hgs_core.scene.camera import Camera

__all__ = ["main", "misplacement"]

Floats = npt.NDArray[np.float64]


def misplacement(solution: Solution, truth: Sequence[Camera]) -> tuple[Floats, Floats]:
    """Return by how many degrees each camera is turned, and how far it is off in shares of the true rig's radius."""
    found = {camera.name: camera.world_to_camera for camera in solution.cameras}
    true = {camera.name: camera.world_to_camera for camera in truth}
    names = sorted(found)
    here, there = (np.array([-p[n][:3, :3].T @ p[n][:3, 3] for n in names]) for p in (found, true))
    a, b = here - here.mean(axis=0), there - there.mean(axis=0)
    left, spread, right = np.linalg.svd(b.T @ a)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = left @ sign @ right
    scale = float((spread * np.diag(sign)).sum() / (a**2).sum())
    radius = float(np.linalg.norm(b, axis=1).mean())
    off = np.linalg.norm(scale * a @ turn.T - b, axis=1) / radius
    traces = [np.trace(found[name][:3, :3] @ turn.T @ true[name][:3, :3].T) for name in names]
    return np.degrees(np.arccos(np.clip((np.array(traces) - 1) / 2, -1, 1))), off


def main() -> None:
    """Find the cameras and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("capture", type=Path)
    parser.add_argument("--cameras", default="", help="names, with commas between; default: all")
    parser.add_argument("--known", action="store_true", help="give the capture's intrinsics")
    options = parser.parse_args()
    capture = open_capture(options.capture)
    names = options.cameras.split(",") if options.cameras else [camera.name for camera in capture.cameras]
    chosen = [capture.camera_index(name) for name in names]
    truth = [capture.cameras[index] for index in chosen]
    known = [Pinhole(c.fx, c.fy, c.cx, c.cy) if options.known else None for c in truth]
    began = time.process_time()
    views = look(names, known, lambda camera, frame: capture.frame(chosen[camera], frame), len(capture.times), silent)
    looked = time.process_time()
    solution = cameras_of_views(options.capture, views, silent)
    done = time.process_time()
    degrees, off = misplacement(solution, truth)
    print(f"{len(solution.cameras)} of {len(truth)} cameras, {solution.error:.2f} px")
    print(f"degrees: {np.median(degrees):.3f} median, {degrees.max():.3f} largest")
    print(f"of the radius: {100 * np.median(off):.2f} % median, {100 * off.max():.2f} % largest")
    print(f"focal: {', '.join(f'{camera.parameters[0]:.1f}' for camera in solution.cameras[:5])}")
    print(f"CPU seconds: {looked - began:.1f} features, {done - looked:.1f} matches and mapping")


if __name__ == "__main__":
    main()
