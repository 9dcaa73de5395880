"""The result: poses, proof, files and pictures."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any, Optional

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import InputError, NestingError
from ._parts import NativeItem, Part

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class PackedPart:
    """A part of a solution. A file with several solids has several parts."""

    #: Name in messages and in the build file.
    name: str
    #: What the user gave.
    key: Part = field(repr=False)
    #: Number of copies asked for.
    copies: int


@dataclass(frozen=True)
class Placement:
    """One copy of a part in its place."""

    #: Index into ``Solution.parts``.
    part: int
    #: Name of the part.
    name: str
    #: What the user gave as the part.
    key: Part = field(repr=False)
    #: Number of the copy, from 0.
    copy: int
    #: 4 x 4, float64, read-only, on column vectors: frame of the part -> frame of the build volume, mm.
    matrix: npt.NDArray[np.float64] = field(repr=False, compare=False)


@dataclass(frozen=True)
class LeftOut:
    """A copy that found no place."""

    #: Index into ``Solution.parts``.
    part: int
    #: Name of the part.
    name: str
    #: What the user gave as the part.
    key: Part = field(repr=False)
    #: Number of the copy, from 0.
    copy: int


@dataclass(frozen=True)
class Removal:
    """How a copy is taken out of the finished build."""

    #: Index into ``Solution.placements``.
    placement: int
    #: Unit vector along which the copy is drawn out, in the frame of the build volume.
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class Proof:
    """What ``Solution.verify`` has measured on the triangles."""

    #: Top of the highest placement, mm.
    height: float
    #: Least distance between any two copies, mm; ``None`` where no two are nearer than twice the clearance plus 1 mm.
    least_distance: Optional[float]
    #: Number of copies that were proved.
    placements: int
    #: An order in which the copies can be taken out; empty with ``interlock="allow"``.
    removal_order: list[Removal] = field(repr=False)
    #: Placements that are locked into others; none unless ``interlock="warn"`` or ``method="paper"``.
    locked: list[int]


class Solution:
    """A layout in which every placed copy keeps its clearance and lies in the build volume.

    Lengths are in mm. A notebook shows its picture.
    """

    def __init__(self, layout: _native.Layout, items: list[NativeItem]) -> None:
        self._layout = layout
        #: The parts, in the order in which they were given.
        self.parts = [PackedPart(item.name, item.key, item.copies) for item in items]

        def named(part: int) -> tuple[str, Part]:
            return self.parts[part].name, self.parts[part].key

        #: The placed copies. ``verify`` proves their matrices as they are here, which is why nobody may write to them.
        self.placements = [Placement(part, *named(part), copy, matrix) for part, copy, matrix in layout.placements()]
        for placement in self.placements:
            placement.matrix.flags.writeable = False
        #: The copies that found no place, in the order of the parts.
        self.left_out = [LeftOut(part, *named(part), copy) for part, copy in layout.left_out()]

    @property
    def poses(self) -> list[npt.NDArray[np.float64]]:
        """The 4 x 4 matrices of all placements."""
        return [placement.matrix for placement in self.placements]

    @property
    def height(self) -> float:
        """Top of the highest placement, mm; 0 when nothing is placed."""
        return self._layout.height

    @property
    def density(self) -> float:
        """Part volume / (base area x height), 0 to 1."""
        return self._layout.density

    @property
    def lower_bound(self) -> float:
        """A height that no layout of all copies can beat, mm."""
        return self._layout.lower_bound

    @property
    def evaluations(self) -> int:
        """Number of evaluations that the search made until it found the layout."""
        return self._layout.evaluations

    @property
    def seconds(self) -> float:
        """Wall seconds of the search."""
        return self._layout.seconds

    @property
    def ended(self) -> str:
        """Why the search ended, in words."""
        return self._layout.ended

    @property
    def heights(self) -> list[tuple[float, float]]:
        """(seconds, height in mm) of each better layout with as many copies as this one."""
        return self._layout.heights

    def explain_left_out(self) -> dict[int, str]:
        """For each part of which copies are left out (its index): where one more copy would fit.

        This takes about as long as to place the parts some times.
        """
        return self._layout.explain_left_out()

    def mesh(self, part: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
        """Vertices (mm) and faces of a part by its index, with equal vertices merged."""
        return self._layout.mesh(part)

    def verify(self, poses: Optional[Sequence[npt.ArrayLike]] = None) -> Proof:
        """Proves the poses again on the triangles, with a prover that relies on no result of the search.

        Proved are the build volume, all clearances, that no part is inside another, the orientations and, with
        ``interlock="forbid"``, that the copies can be taken out one after the other along straight lines.

        Args:
            poses: Other 4 x 4 matrices, one for each of ``placements``: for a layout that you have changed.

        Raises:
            InputError: The poses are not one rotation and translation for each placement.
            ProofError: The layout is not valid; names the faults.
        """
        matrices = np.asarray(self.poses if poses is None else poses, dtype=np.float64)
        if matrices.shape != (len(self.placements), 4, 4) and (matrices.size or self.placements):
            count = len(self.placements)
            raise InputError(f"poses have the shape {matrices.shape}. Give a 4 x 4 matrix for each of {count} placements.")
        matrices = matrices.reshape(-1, 4, 4)
        height, least_distance, locked, order = self._layout.verify(matrices)
        removals = [Removal(placement, direction) for placement, direction in order]
        return Proof(height, least_distance, len(self.placements), removals, locked)

    def write_3mf(self, path: str | os.PathLike[str], *, title: Optional[str] = None, shared: bool = True) -> None:
        """Writes the build as a 3MF: one object for each part, one item for each placed copy, and a picture.

        The file is read back and proved before it gets its name. An existing file is replaced. With ``shared=False``
        each copy is an object of its own, in its place: for readers that ignore transforms or shared objects.

        Raises:
            InputError: Nothing is placed.
            OSError: The file cannot be written.
            ProofError: The written file is not the layout.
        """
        placed = len(self.placements)
        title = f"nestd-nester, {placed} {'part' if placed == 1 else 'parts'}" if title is None else title
        self._layout.write_3mf(path, title, datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"), shared)

    def to_scene(self) -> trimesh.Scene:
        """The placed copies as a ``trimesh.Scene``. Meshes that were given as ``trimesh.Trimesh`` keep their looks."""
        try:
            import trimesh
        except ImportError:
            raise NestingError("to_scene() needs trimesh: pip install nestd-nester[trimesh].") from None
        scene = trimesh.Scene()
        graph: Any = scene.graph  # trimesh has no types for it
        geometries: dict[int, str] = {}
        for placement in self.placements:
            part, node = placement.part, f"{placement.part + 1} {placement.name} #{placement.copy + 1}"
            if part in geometries:
                graph.update(frame_to=node, matrix=placement.matrix, geometry=geometries[part])
                continue
            mesh = placement.key
            if not isinstance(mesh, trimesh.Trimesh):
                mesh = trimesh.Trimesh(*self.mesh(part), process=False)
            geometries[part] = f"{part + 1} {placement.name}"
            scene.add_geometry(mesh, node_name=node, geom_name=geometries[part], transform=placement.matrix)
        return scene

    def picture(self, width: int = 800, height: int = 600, view: str = "iso") -> bytes:
        """A picture of the build as a PNG; ``view`` is ``iso``, ``top`` or ``front``, the size is in pixels."""
        return self._layout.picture(view, (width, height))

    def _repr_png_(self) -> bytes:
        return self.picture()

    def __repr__(self) -> str:
        copies = sum(part.copies for part in self.parts)
        return (
            f"<Solution: {self.height:.2f} mm high, {len(self.placements)} of {copies} copies placed, "
            f"density {self.density:.3f}, {self.seconds:.1f} s, {self.ended}>"
        )
