"""Shapes for the tests, and an independent measure of boxes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

VOLUME = (60.0, 60.0, 120.0)

BOX_FACES = np.array(
    [
        [0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4],
        [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7],
    ]
)  # fmt: skip


class Box:
    """A box as a mesh of its own kind: it has .vertices and .faces, and nothing else."""

    def __init__(self, *size: float) -> None:
        corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        self.vertices = np.array(corners, dtype=np.float64) * size
        self.faces = BOX_FACES


def corners_at(box: Box, matrix: np.ndarray) -> np.ndarray:
    """The corners of a box in its place."""
    return box.vertices @ matrix[:3, :3].T + matrix[:3, 3]


def box_gap(one: np.ndarray, other: np.ndarray) -> float:
    """A distance that two boxes certainly keep, by separating axes: exact between faces, too small between corners."""
    axes = [edges(one), edges(other)]
    crossed = [np.cross(a, b) for a, b in itertools.product(axes[0], axes[1])]
    gap = -np.inf
    for axis in [*axes[0], *axes[1], *crossed]:
        length = np.linalg.norm(axis)
        if length < 1e-6:
            continue
        a, b = one @ axis / length, other @ axis / length
        gap = max(gap, b.min() - a.max(), a.min() - b.max())
    return gap


def edges(corners: np.ndarray) -> list[np.ndarray]:
    """Unit vectors along the three edges of a box at its first corner."""
    return [(corners[at] - corners[0]) / np.linalg.norm(corners[at] - corners[0]) for at in (1, 3, 4)]


@pytest.fixture
def box() -> Box:
    return Box(20.0, 12.0, 8.0)
