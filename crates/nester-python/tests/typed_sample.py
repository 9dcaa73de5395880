"""A program as users write it; mypy --strict checks it."""

from __future__ import annotations

from pathlib import Path
from typing import Optional

import numpy as np
import numpy.typing as npt

import nestd_nester as nn


class Shape:
    """A mesh of one's own."""

    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]


def pack_all(shape: Shape, folder: Path) -> Optional[float]:
    by_name: dict[str, int] = {"a.stl": 12}
    solution: nn.Solution = nn.pack(by_name, volume=(356, 280, 356), clearance=3, seconds=60, seed=1, threads=8)
    solution = nn.pack({folder / "b.3mf": 1, shape: 2}, [100, 100, 100.5], on_better=lambda height, seconds: height > 50)
    pairs: list[tuple[nn.Part, int]] = [((shape.vertices, shape.faces), 3), ("c.obj", 1)]
    solution = nn.pack(pairs, (100, 100, 100), evaluations=1000)
    solution = nn.pack([nn.Item(shape, 3, name="shape", orientation="upright", clearance=2.5)], (100, 100, 100))
    pose: npt.NDArray[np.float64] = solution.poses[0]
    names: list[str] = [f"{placement.name} {placement.copy}" for placement in solution.placements]
    left: list[int] = [left_out.part for left_out in solution.left_out]
    print(pose.shape, names, left, solution.height, solution.parts[0].copies)
    solution.write_3mf(folder / "build.3mf", title="a build")
    try:
        return solution.verify().least_distance
    except nn.ProofError as error:
        print(error)
        return None
