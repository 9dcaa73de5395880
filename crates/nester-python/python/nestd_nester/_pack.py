"""The entry point: parts in, a solution out."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Callable, NamedTuple, Optional

from . import _native
from ._errors import InputError
from ._parts import Item, Part, native_items
from ._solution import Solution

#: Wall seconds of a search without any limit.
DEFAULT_SECONDS = 30.0


class _Search(NamedTuple):
    """The build volume, the rules and the limits of a search, checked."""

    volume: tuple[float, float, float]
    clearance: float
    seconds: Optional[float]
    evaluations: Optional[int]
    patience: Optional[float]
    seed: int
    threads: int
    lanes: int
    interlock: str
    method: str


def pack(
    parts: Mapping[Any, int] | Iterable[Item | tuple[Part, int]],
    volume: Sequence[float],
    clearance: float = 3.0,
    *,
    seconds: Optional[float] = None,
    evaluations: Optional[int] = None,
    patience: Optional[float] = None,
    seed: int = 1,
    threads: int = 1,
    lanes: int = 0,
    orientation: str = "free",
    interlock: str = "forbid",
    method: str = "nestd",
    unit: str = "mm",
    on_better: Optional[Callable[[float, float], object]] = None,
) -> Solution:
    """Packs copies of parts into a box, as low as the search gets within its limits.

    Args:
        parts: A dict of parts with their numbers of copies, or a list of pairs ``(part, copies)`` or of :class:`Item`.
            A part is the path of an STL, 3MF, OBJ or PLY file, a mesh with ``.vertices`` and ``.faces`` such as
            ``trimesh.Trimesh``, or (in a list) a pair of arrays ``(vertices, faces)``. If not all copies fit, parts
            that come first go first.
        volume: Edge lengths of the build volume along x, y and z, mm.
        clearance: Least distance between the surfaces of any two placed copies, mm.
        seconds: Wall time of the search; 30 without any limit, ``math.inf`` for none. The search ends sooner when no
            lower layout exists.
        evaluations: Number of evaluations of the search. The same seed, lanes and evaluations give the same poses.
        patience: The search ends when it has found nothing better for so many seconds.
        seed: Seed of every random choice, from 0.
        threads: Number of threads; 0 = one per core.
        lanes: Searches side by side that exchange their layouts; 0 = one per thread. It affects the poses, and the
            number of threads does not.
        orientation: How parts may be turned: ``free``, ``upright`` (about z only), ``axis`` (24 rotations) or
            ``fixed``.
        interlock: Parts that are locked into others: ``forbid`` (no layout has any), ``warn`` or ``allow``.
        method: ``nestd``, or ``paper`` for the published method that the search is compared with.
        unit: Unit of files that state none (STL, OBJ, PLY): ``mm``, ``cm``, ``m``, ``micron``, ``inch`` or ``foot``.
        on_better: Called as ``on_better(height, seconds)`` in the calling thread, whenever the search has found a
            lower layout, or one of more copies. If it returns ``False``, the search ends with what it has found.

    Returns:
        The layout, also where copies are left out: see ``Solution.left_out``.

    Raises:
        InputError: The input makes no sense, or a part does not fit the volume. It is a ``ValueError``.
        OSError: A file cannot be read: ``FileNotFoundError`` and the like.
        KeyboardInterrupt: Somebody has pressed Ctrl-C; the layout is lost.
    """
    if seconds is None and evaluations is None and patience is None:
        seconds = DEFAULT_SECONDS
    if on_better is not None and not callable(on_better):
        raise InputError("on_better cannot be called. Give a function of height and seconds.")
    search = _Search(
        volume=_box(volume),
        clearance=_number("clearance", clearance, 0.0),
        seconds=_limit("seconds", seconds),
        evaluations=None if evaluations is None else _whole("evaluations", evaluations, 1),
        patience=_limit("patience", patience),
        seed=_whole("seed", seed, 0),
        threads=_whole("threads", threads, 0, 4096),
        lanes=_whole("lanes", lanes, 0, 4096),
        interlock=interlock,
        method=method,
    )
    items = native_items(parts, orientation, unit)
    for item in items:
        if item.clearance is not None:
            _number(f"clearance of {item.name}", item.clearance, 0.0)
    return Solution(_native.search(list(items), search, on_better), items)


def _number(what: str, given: float, least: float) -> float:
    """A finite number of at least ``least``."""
    try:
        number = float(given)
    except (TypeError, ValueError):
        raise InputError(f"{what}={given!r} is no number.") from None
    if not (math.isfinite(number) and number >= least):
        raise InputError(f"{what}={given!r}: give a finite number of at least {least:g}.")
    return number


def _limit(what: str, given: Optional[float]) -> Optional[float]:
    """A positive number of seconds; ``inf`` is no limit."""
    if given is None or given == math.inf:
        return given
    number = _number(what, given, 0.0)
    if number == 0.0:
        raise InputError(f"{what}={given!r}: give the search some time.")
    return number


def _whole(what: str, given: int, least: int, most: int = 2**64 - 1) -> int:
    try:
        number = operator.index(given)
    except TypeError:
        raise InputError(f"{what}={given!r} is no whole number.") from None
    if not least <= number <= most:
        raise InputError(f"{what}={number}: give a whole number from {least} to {most}.")
    return number


def _box(volume: Sequence[float]) -> tuple[float, float, float]:
    try:
        edges = tuple(_number("volume", edge, 0.0) for edge in volume)
    except TypeError:
        edges = ()
    if len(edges) != 3 or min(edges) == 0.0:
        raise InputError(f"volume={volume!r}: give three positive lengths in mm, for example (356, 280, 356).")
    return edges[0], edges[1], edges[2]
