"""What the user gives as parts: files, meshes and arrays become meshes of the native half."""

from __future__ import annotations

import operator
import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Optional, Protocol, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import InputError, PartWarning

#: The most copies of one part.
MAX_COPIES = 100_000

_FLOATS = (np.dtype(np.float64), np.dtype(np.float32))
_INTEGERS = (np.dtype(np.int64), np.dtype(np.int32), np.dtype(np.uint32))


class MeshLike(Protocol):
    """A triangle mesh in millimetres, such as ``trimesh.Trimesh``."""

    @property
    def vertices(self) -> Any:
        """Places of the corners, n x 3."""

    @property
    def faces(self) -> Any:
        """Indices of the corners of each triangle, m x 3, counter-clockwise seen from outside."""


#: A part: the path of an STL, 3MF, OBJ or PLY file, a mesh, or a pair of arrays (vertices, faces).
Part = Union[str, "os.PathLike[str]", MeshLike, "tuple[npt.ArrayLike, npt.ArrayLike]"]


@dataclass(frozen=True)
class Item:
    """A part with its copies and its own rules."""

    #: The path of a file, a mesh, or a pair of arrays (vertices, faces).
    part: Part
    #: Number of copies. A 3MF file may itself ask for several: they are multiplied.
    copies: int = 1
    #: Name in messages and in the build file; else that of the file or mesh.
    name: Optional[str] = None
    #: ``free``, ``upright`` (turned about z only), ``axis`` (24 rotations) or ``fixed``; else that of the whole build.
    orientation: Optional[str] = None
    #: Least distance to other parts, mm, where it is greater than that of the build.
    clearance: Optional[float] = None


class NativeItem(NamedTuple):
    """A part as the native half takes it; ``key`` is what the user gave."""

    name: str
    mesh: _native.Mesh
    copies: int
    orientation: str
    clearance: Optional[float]
    key: Part


def native_items(
    parts: Mapping[Any, int] | Iterable[Item | tuple[Part, int]], orientation: str, unit: str
) -> list[NativeItem]:
    """Reads all parts. A file or mesh that is given several times is read once."""
    known: dict[object, list[tuple[str, _native.Mesh]]] = {}
    found: list[NativeItem] = []
    for number, item in enumerate(_to_items(parts), start=1):
        copies = _copies_of(item, number)
        identity = _identity(item.part)
        if identity not in known:
            known[identity] = _read_part(item.part, f"part {number}", unit)
        meshes = known[identity]
        for name, mesh in meshes:
            if item.name is not None:
                name = item.name if len(meshes) == 1 else f"{item.name} ({mesh.name})"
            rule = item.orientation if item.orientation is not None else orientation
            found.append(NativeItem(name, mesh, copies * mesh.copies, rule, item.clearance, item.part))
    if not found:
        raise InputError("there are no parts. Give at least one part with its number of copies.")
    return found


def _to_items(parts: Mapping[Any, int] | Iterable[Item | tuple[Part, int]]) -> list[Item]:
    if isinstance(parts, Mapping):
        return [Item(part, copies) for part, copies in parts.items()]
    if isinstance(parts, (str, bytes, os.PathLike)) or not isinstance(parts, Iterable):
        raise InputError('parts is neither a dict nor a list. Give {"bracket.stl": 12} or [("bracket.stl", 12)].')
    items = []
    for number, given in enumerate(parts, start=1):
        if isinstance(given, Item):
            items.append(given)
        elif isinstance(given, tuple) and len(given) == 2:
            items.append(Item(*given))
        else:
            raise InputError(f"part {number} of the list is no pair. Give (part, copies) or nestd_nester.Item.")
    return items


def _copies_of(item: Item, number: int) -> int:
    try:
        copies = operator.index(item.copies)
    except TypeError:
        raise InputError(
            f"part {number}: its number of copies is a {type(item.copies).__name__}. Give (part, copies) with a whole "
            "number of copies."
        ) from None
    if not 1 <= copies <= MAX_COPIES:
        raise InputError(f"part {number}: {copies} copies. Give 1 to {MAX_COPIES}, or leave the part out.")
    return copies


def _identity(part: Part) -> object:
    if isinstance(part, (str, os.PathLike)):
        return os.fspath(part)
    if isinstance(part, tuple):
        return tuple(id(array) for array in part)
    return id(part)


def _read_part(part: Part, name: str, unit: str) -> list[tuple[str, _native.Mesh]]:
    """The meshes of a part with their names; what a person should know is warned of."""
    if isinstance(part, (str, os.PathLike)):
        path = os.fspath(part)
        name = os.path.basename(path)
        meshes, sentences = _native.read_file(path, unit)
        named = [(name if len(meshes) == 1 else f"{name} ({mesh.name})", mesh) for mesh in meshes]
    else:
        vertices, faces, name = _arrays_of(part, name)
        named, sentences = [(name, _native.mesh_from_arrays(vertices, faces, name))], []
    for sentence in sentences:
        _warn(name, sentence)
    for name, mesh in named:
        for sentence in mesh.warnings:
            _warn(name, sentence)
    return named


def _warn(name: str, sentence: str) -> None:
    # The caller of pack() is five frames up.
    warnings.warn(f"{name}: {sentence}", PartWarning, stacklevel=5)


def _arrays_of(part: MeshLike | tuple[npt.ArrayLike, npt.ArrayLike], name: str) -> tuple[Any, Any, str]:
    """Vertices, faces and the name of a mesh or pair. Arrays are not copied where the native half can read them."""
    if isinstance(part, tuple):
        if len(part) != 2:
            raise InputError(f"{name}: a tuple of {len(part)} is no mesh. Give a pair (vertices, faces).")
        vertices, faces = part
    else:
        try:
            vertices, faces = part.vertices, part.faces
        except AttributeError:
            raise InputError(
                f"{name}: {type(part).__name__} is no part. Give a path, a mesh with .vertices and .faces such as "
                "trimesh.Trimesh, or a pair (vertices, faces)."
            ) from None
        name = _name_of_mesh(part) or name
    return _to_array(vertices, "vertices", _FLOATS, name), _to_array(faces, "faces", _INTEGERS, name), name


def _name_of_mesh(mesh: MeshLike) -> Optional[str]:
    """The name that trimesh keeps with a mesh."""
    metadata = getattr(mesh, "metadata", None)
    if not isinstance(metadata, Mapping):
        return None
    name = metadata.get("name") or metadata.get("file_name")
    return name if isinstance(name, str) else None


def _to_array(given: Any, what: str, dtypes: tuple[np.dtype[Any], ...], name: str) -> npt.NDArray[Any]:
    try:
        array = np.asarray(given)
        if array.dtype not in dtypes:
            # Numbers of another kind are converted; but a fraction is no index.
            rule: Any = "same_kind" if array.size else "unsafe"
            array = array.astype(dtypes[0], casting=rule)
    except (TypeError, ValueError) as error:
        wanted = "numbers" if what == "vertices" else "whole numbers"
        raise InputError(f"{name}: {what} are no array of {wanted}: {error}.") from None
    if array.ndim != 2 or array.shape[1] != 3:
        remedy = "Split quads and polygons into triangles." if what == "faces" else "Give x, y and z in mm in each row."
        raise InputError(f"{name}: {what} have the shape {array.shape} instead of (n, 3). {remedy}")
    return np.require(array, requirements="A")
