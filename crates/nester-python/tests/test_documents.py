"""The README, the notebook and the types are what they say."""

from __future__ import annotations

import ast
import importlib.util
import json
import os
import re
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

import nestd_nester as nn

ROOT = Path(__file__).parent.parent


def run(code: str, folder: Path) -> str:
    ended = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_the_five_lines_of_the_readme_run_as_they_stand(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    block = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert block is not None and len(block[1].strip().splitlines()) == 5
    began = time.monotonic()
    said = run(block[1], tmp_path)
    print(f"five lines: {time.monotonic() - began:.1f} s, {said}")
    assert "30 of 30 copies placed" in said and "Proof(" in said
    with zipfile.ZipFile(tmp_path / "build.3mf") as package:
        assert package.read("3D/3dmodel.model").count(b"<item ") == 30


def test_the_notebook_runs(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    file = ROOT / "examples" / "pack.ipynb"
    if importlib.util.find_spec("nbclient") and importlib.util.find_spec("ipykernel"):
        import nbclient
        import nbformat

        notebook = nbformat.read(file, as_version=4)
        nbformat.validate(notebook)
        nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
        outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
        assert any("image/png" in output.get("data", {}) for output in outputs), "the notebook shows a picture"
    else:
        cells = [cell for cell in json.loads(file.read_text())["cells"] if cell["cell_type"] == "code"]
        run("\n".join("".join(cell["source"]) for cell in cells), tmp_path)
    assert (tmp_path / "build.3mf").exists()


def test_the_notebook_holds_no_results() -> None:
    cells = json.loads((ROOT / "examples" / "pack.ipynb").read_text())["cells"]
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells)


def test_types_are_strict(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    sample = Path(__file__).parent / "typed_sample.py"
    arguments = ["--strict", "--cache-dir", str(tmp_path), str(sample), "-p", "nestd_nester"]
    for given in (arguments[:-2], arguments[:3] + arguments[-2:]):
        checked = subprocess.run([sys.executable, "-m", "mypy", *given], capture_output=True, text=True, cwd=tmp_path)
        assert checked.returncode == 0, checked.stdout + checked.stderr


def test_types_find_what_is_wrong(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import nestd_nester as nn\nnn.pack({'a.stl': 'many'}, (1, 2, 3)).height.strip()\n")
    arguments = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(wrong)]
    checked = subprocess.run(arguments, capture_output=True, text=True, cwd=tmp_path)
    assert checked.returncode == 1 and "Found 2 errors" in checked.stdout, checked.stdout


def test_it_is_imported_without_trimesh(tmp_path: Path) -> None:
    run("import sys; sys.modules['trimesh'] = None; import nestd_nester as nn; assert nn.pack", tmp_path)
    run("import sys, nestd_nester; assert 'trimesh' not in sys.modules", tmp_path)
    code = """
import sys; sys.modules["trimesh"] = None
import numpy as np, nestd_nester as nn
faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
solution = nn.pack([((np.eye(4)[:, :3] * 9, faces), 1)], (20, 20, 20), 1, evaluations=50)
try:
    solution.to_scene()
except nn.NestingError as error:
    print(error)
"""
    # The corners are three unit vectors and the origin: a tetrahedron, inside out.
    assert "pip install nestd-nester[trimesh]" in run(code, tmp_path)


def test_the_package_is_written_for_python_3_9_and_has_types() -> None:
    assert nn.__file__ is not None
    package = Path(nn.__file__).parent
    for file in package.glob("*.py"):
        ast.parse(file.read_text(), feature_version=(3, 9))
    assert {"py.typed", "_native.pyi"} <= set(os.listdir(package))
    native = [name for name in os.listdir(package) if name.startswith("_native.") and name.endswith((".so", ".pyd"))]
    assert native and all("cpython" not in name for name in native), f"not for all versions: {native}"


def test_everything_public_is_described() -> None:
    for name in nn.__all__:
        assert name == "Part" or (getattr(nn, name).__doc__ or "").strip(), name
    for name in dir(nn.Solution):
        assert name.startswith("_") or getattr(nn.Solution, name).__doc__, name
