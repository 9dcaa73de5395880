"""What makes no sense is refused with what to do about it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import BOX_FACES, VOLUME, Box

import nestd_nester as nn


def refusal(*given: object, **options: object) -> str:
    with pytest.raises(nn.InputError) as caught:
        nn.pack(*given, **{"evaluations": 50, **options})  # type: ignore[arg-type]
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, nn.NestingError)
    return str(caught.value)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"volume": (10, 20)}, "three positive lengths"),
        ({"volume": (10, 20, 0)}, "three positive lengths"),
        ({"volume": (10, 20, -1)}, "at least 0"),
        ({"volume": 300}, "three positive lengths"),
        ({"volume": ("a", 2, 3)}, "no number"),
        ({"clearance": -1}, "at least 0"),
        ({"clearance": float("nan")}, "finite"),
        ({"seconds": 0}, "some time"),
        ({"seconds": "soon"}, "no number"),
        ({"evaluations": 0}, "from 1"),
        ({"evaluations": 1.5}, "no whole number"),
        ({"seed": -1}, "from 0"),
        ({"threads": -2}, "from 0"),
        ({"orientation": "sideways"}, "expected one of `free`, `upright`, `axis`, `fixed`"),
        ({"interlock": "no"}, "expected one of `forbid`, `warn`, `allow`"),
        ({"method": "magic"}, "`nestd`"),
        ({"on_better": 5}, "cannot be called"),
    ],
)
def test_options_that_make_no_sense_are_named(box: Box, options: dict[str, object], told: str) -> None:
    assert told in refusal({box: 1}, **{"volume": VOLUME, **options})


def test_parts_that_are_none_are_named(box: Box) -> None:
    assert "no parts" in refusal({}, VOLUME)
    assert "0 copies" in refusal({box: 0}, VOLUME)
    assert "is a str" in refusal({box: "two"}, VOLUME)
    assert "neither a dict nor a list" in refusal("bracket.stl", VOLUME)
    assert "neither a dict nor a list" in refusal(box, VOLUME)
    assert "object is no part" in refusal({object(): 1}, VOLUME)
    assert "no pair" in refusal([box], VOLUME)
    assert "is a ndarray" in refusal([(box.vertices, box.faces)], VOLUME), "a pair of arrays without copies"
    assert "clearance of x" in refusal([nn.Item(box, name="x", clearance=-1)], VOLUME)


@pytest.mark.parametrize(
    ("vertices", "faces", "told"),
    [
        (np.zeros((8, 2)), BOX_FACES, "shape (8, 2)"),
        (np.zeros(24), BOX_FACES, "shape (24,)"),
        (Box(1, 1, 1).vertices, np.zeros((6, 4), int), "Split quads"),
        (Box(1, 1, 1).vertices, BOX_FACES.astype(float), "whole numbers"),
        (Box(1, 1, 1).vertices, BOX_FACES + 1, "names vertex 8"),
        (Box(1, 1, 1).vertices, BOX_FACES - 1, "names vertex -1"),
        (Box(1, 1, 1).vertices * np.nan, BOX_FACES, "not a finite number"),
        (Box(1, 1, 0).vertices, BOX_FACES, "encloses no volume"),
        (Box(1, 1, 1).vertices, BOX_FACES[:0], "no triangles"),
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no triangles"),
        ("corners", BOX_FACES, "no array of numbers"),
        ([[1, 2, 3], [4, 5]], BOX_FACES, "no array of numbers"),
    ],
)
def test_arrays_that_are_no_solid_are_refused(vertices: object, faces: object, told: str) -> None:
    text = refusal([((vertices, faces), 1)], VOLUME)
    assert text.startswith("part 1: ") and told in text


def test_a_part_that_does_not_fit_is_refused_before_the_search(box: Box) -> None:
    text = refusal({box: 1, Box(500, 5, 5): 1}, VOLUME, evaluations=None, seconds=600)
    assert text.startswith("part 2: needs ") and "there are 60 x 60 x 120 mm" in text and "check the unit" in text


def test_files_that_are_not_there_or_no_parts_are_refused(tmp_path: Path) -> None:
    missing = tmp_path / "missing.stl"
    with pytest.raises(FileNotFoundError) as caught:
        nn.pack({missing: 1}, VOLUME)
    assert caught.value.filename == str(missing)
    with pytest.raises(IsADirectoryError):
        nn.pack({tmp_path: 1}, VOLUME)
    for name, content, told in [
        ("step.stl", b"ISO-10303-21;\nHEADER;\n" * 20, "Export the part from the CAD program as STL or 3MF"),
        ("cut.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "truncated"),
        ("zip.3mf", b"PK\x03\x04 and nothing else", "truncated: the end of the ZIP package is missing"),
    ]:
        file = tmp_path / name
        file.write_bytes(content)
        text = refusal({str(file): 1}, VOLUME)
        assert text.startswith(str(file)) and told in text and "drop" not in text, text
    assert "unit='parsec'" in refusal({missing: 1}, VOLUME, unit="parsec").replace('"', "'")


def test_an_open_surface_is_a_warning(box: Box) -> None:
    with pytest.warns(nn.PartWarning, match="part 1: the surface is not closed") as caught:
        nn.pack([((box.vertices, BOX_FACES[:-1]), 1)], VOLUME, evaluations=50)
    assert caught[0].filename == __file__, "it names the line of the caller"


def test_a_sound_part_gives_no_warning(box: Box, recwarn: pytest.WarningsRecorder) -> None:
    nn.pack({box: 1}, VOLUME, evaluations=50)
    assert not recwarn.list
