"""Files in and out, scenes and pictures."""

from __future__ import annotations

import os
import struct
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import VOLUME, Box

import nestd_nester as nn

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


def write_stl(path: Path, box: Box) -> Path:
    triangles = box.vertices[box.faces].astype("<f4")
    rows = [struct.pack("<12fH", *([0.0] * 3), *triangle.ravel(), 0) for triangle in triangles]
    path.write_bytes(b" " * 80 + struct.pack("<I", len(rows)) + b"".join(rows))
    return path


def write_obj(path: Path, box: Box) -> Path:
    corners = [f"v {x} {y} {z}" for x, y, z in box.vertices]
    path.write_text("\n".join(corners + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in box.faces]) + "\n")
    return path


def write_ply(path: Path, box: Box) -> Path:
    head = ["ply", "format ascii 1.0", f"element vertex {len(box.vertices)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(box.faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(map(str, row)) for row in box.vertices] + [f"3 {a} {b} {c}" for a, b, c in box.faces]
    path.write_text("\n".join(head + rows) + "\n")
    return path


def items_of(path: Path) -> list[np.ndarray]:
    """The 4 x 4 matrices of the items of a 3MF, read without any library of meshes."""
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        model = ElementTree.fromstring(package.read("3D/3dmodel.model"))
    assert model.get("unit") == "millimeter"
    rows = [np.array(item.get("transform").split(), float).reshape(4, 3) for item in model.iter(f"{CORE}item")]
    return [np.vstack([row.T, [0, 0, 0, 1]]) for row in rows]


def test_files_of_all_formats_are_read(tmp_path: Path, box: Box) -> None:
    files = [write_stl(tmp_path / "a.stl", box), write_obj(tmp_path / "b.obj", box), write_ply(tmp_path / "c.ply", box)]
    solution = nn.pack({files[0]: 2, str(files[1]): 3, files[2]: 1}, VOLUME, 2, evaluations=600)
    assert [(part.name, part.copies) for part in solution.parts] == [("a.stl", 2), ("b.obj", 3), ("c.ply", 1)]
    assert [part.key for part in solution.parts] == [files[0], str(files[1]), files[2]]
    solution.write_3mf(tmp_path / "d.3mf")
    again = nn.pack([(tmp_path / "d.3mf", 1)], VOLUME, 2, evaluations=600)
    assert sum(part.copies for part in again.parts) == 6 and len(again.placements) == 6


def test_a_file_without_a_unit_is_read_in_the_given_one(tmp_path: Path) -> None:
    inch = write_stl(tmp_path / "inch.stl", Box(1, 0.5, 0.25))
    solution = nn.pack({inch: 1}, VOLUME, 2, evaluations=100, unit="inch")
    np.testing.assert_allclose(np.ptp(solution.mesh(0)[0], axis=0), [25.4, 12.7, 6.35])
    with pytest.warns(nn.PartWarning, match="suspicious size"):
        nn.pack({inch: 1}, VOLUME, 2, evaluations=100)


def test_a_written_build_opens_again_with_the_same_poses(tmp_path: Path, box: Box) -> None:
    solution = nn.pack({box: 5, Box(9, 9, 9): 4}, VOLUME, 2, evaluations=800)
    path = tmp_path / "build.3mf"
    solution.write_3mf(path, title="Tuesday")
    written = items_of(path)
    assert len(written) == 9
    # No coordinate of a file is negative: poses move by the tolerance of walls, at most.
    np.testing.assert_allclose(written, solution.poses, rtol=0, atol=1e-6)
    assert os.listdir(tmp_path) == ["build.3mf"], "no draft is left"
    if os.name == "posix":
        mask = os.umask(0)
        os.umask(mask)
        assert path.stat().st_mode & 0o777 == 0o666 & ~mask
    solution.write_3mf(str(path))
    assert len(items_of(path)) == 9, "an existing file is replaced"


def test_trimesh_opens_a_written_build(tmp_path: Path, box: Box) -> None:
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    pytest.importorskip("lxml")
    solution = nn.pack({box: 5, Box(9, 9, 9): 4}, VOLUME, 2, evaluations=800)
    # trimesh 5.2 reads one copy of each shared object.
    solution.write_3mf(tmp_path / "build.3mf", shared=False)
    scene = trimesh.load_scene(tmp_path / "build.3mf")
    assert len(scene.graph.nodes_geometry) == 9
    assert scene.bounds[1][2] == pytest.approx(solution.height, abs=1e-5)
    assert scene.volume == pytest.approx(5 * 1920 + 4 * 729, rel=1e-5)


def test_a_build_that_cannot_be_written_leaves_nothing(tmp_path: Path, box: Box) -> None:
    solution = nn.pack({box: 1}, VOLUME, 2, evaluations=100)
    with pytest.raises(FileNotFoundError) as caught:
        solution.write_3mf(tmp_path / "no" / "folder.3mf")
    assert caught.value.filename == str(tmp_path / "no" / "folder.3mf")
    with pytest.raises(OSError):
        solution.write_3mf(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_scene_has_a_node_for_each_copy(box: Box) -> None:
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    pin = trimesh.creation.capsule(12, 3)
    solution = nn.pack({pin: 3, box: 2}, VOLUME, 2, evaluations=500)
    scene = solution.to_scene()
    assert len(scene.graph.nodes_geometry) == 5 and len(scene.geometry) == 2
    assert scene.bounds[1][2] == pytest.approx(solution.height)
    assert scene.volume == pytest.approx(3 * pin.volume + 2 * 1920)
    nodes = sorted(scene.graph.nodes_geometry)
    np.testing.assert_allclose(scene.graph[nodes[0]][0], solution.placements[0].matrix)


def test_pictures_are_png_of_the_asked_size(box: Box) -> None:
    solution = nn.pack({box: 3}, VOLUME, 2, evaluations=300)
    for view in ("iso", "top", "front"):
        png = solution.picture(320, 200, view)
        assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", png[16:24]) == (320, 200)
    assert solution._repr_png_()[:4] == b"\x89PNG"
    with pytest.raises(nn.InputError, match="give one of"):
        solution.picture(view="behind")
