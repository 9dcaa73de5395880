"""Packs triangle meshes into a build volume as low as they go.

Parts may have any rotation, all parts keep a clearance, and no part is locked into others. It is made for powder-bed
3D printers, where every millimetre of height costs machine time. Lengths are in millimetres, matrices act on column
vectors, the origin is the lower front left corner of the build volume, and z points up.

    import nestd_nester as nn

    solution = nn.pack({"bracket.stl": 12, mesh: 3}, volume=(356, 280, 356), clearance=3, seconds=60)
    print(solution.height)
    solution.write_3mf("build.3mf")
"""

from ._errors import InputError, NestingError, PartWarning, ProofError
from ._pack import pack
from ._parts import Item, MeshLike, Part
from ._solution import LeftOut, PackedPart, Placement, Proof, Removal, Solution

__all__ = [
    "InputError",
    "Item",
    "LeftOut",
    "MeshLike",
    "NestingError",
    "PackedPart",
    "Part",
    "PartWarning",
    "Placement",
    "Proof",
    "ProofError",
    "Removal",
    "Solution",
    "pack",
]
