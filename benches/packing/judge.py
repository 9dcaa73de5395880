#!/usr/bin/env python3
"""Judges an entry to the benchmark of 3D packing (README.md beside it). Needs Python 3.9 and numpy.

    judge.py FOLDER WORKLOAD ENTRY     ENTRY: a 3MF file, or JSON {"parts": [{"file": "..", "transform": [[4 x 4]]}]}
    judge.py --table results.json      prints the table of results

Exit code 0: the entry counts; 1: it has faults, each is printed; 2: something cannot be read.
"""
import argparse
import csv
import hashlib
import json
import math
import posixpath
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from distances import Copy, Shape, distance, dot, is_inside

JUDGE_VERSION = 1
FIT_MM = 0.01  # how far a corner of an entry may be from its place in the moved STL
SLACK_MM = 1e-3  # for roundings, at clearance, walls and floor
FAULTS_SHOWN = 20
UNIT_MM = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
IDENTITY = (np.eye(3), np.zeros(3))


class Unreadable(Exception):
    """Something cannot be read; the text says what, and what to do."""


# ---- Workloads ----


def read_stl(path):
    """The triangles of a binary STL, (n, 3, 3)."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else 0
    if not count or len(data) != 84 + 50 * count:
        raise Unreadable(f"{path} is not a whole binary STL: write the workloads again")
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    return np.frombuffer(data, facet, count, 84)["corners"].astype(float)


def read_workload(folder, name):
    """Base, clearance, and for each file its triangles and its number of copies."""
    try:
        beside = json.loads((folder / "workloads" / f"{name}.json").read_text())
        with open(folder / "workloads" / f"{name}.csv", newline="") as rows:
            listed = [(row["file"], int(row["quantity"])) for row in csv.DictReader(rows)]
        parts = {}
        for file, quantity in listed:
            parts[file] = (read_stl(folder / file), quantity + parts.get(file, (None, 0))[1])
        return beside["volume_mm"][:2], float(beside["clearance_mm"]), parts
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise Unreadable(f"workload {name} in {folder}: {error!r}: write the workloads into this folder, see README.md")


# ---- Entries ----


def local(name):
    return name.rsplit("}", 1)[-1]


def attribute(element, name):
    return next((value for key, value in element.attrib.items() if local(key) == name), None)


def children(element, name):
    return [child for child in element if local(child.tag) == name]


class Package:
    """A 3MF file: the triangles of each mesh below its build items."""

    def __init__(self, path):
        self.zip, self.models, self.meshes = zipfile.ZipFile(path), {}, {}
        links = ElementTree.fromstring(self.zip.read("_rels/.rels"))
        models = [link.get("Target") for link in links if (link.get("Type") or "").endswith("/3dmodel")]
        if not models:
            raise Unreadable("the package names no 3D model in _rels/.rels: write it as 3MF says")
        self.root = posixpath.join("/", models[0])

    def model(self, path):
        if path not in self.models:
            root = ElementTree.fromstring(self.zip.read(path.lstrip("/")))
            objects = {o.get("id"): o for group in children(root, "resources") for o in children(group, "object")}
            self.models[path] = (root, objects, UNIT_MM[root.get("unit", "millimeter")])
        return self.models[path]

    def motion(self, element, unit):
        """Rows of numbers as 3MF writes them: a row vector times the first three, plus the last."""
        text = element.get("transform")
        if text is None:
            return IDENTITY
        rows = np.array([float(number) for number in text.split()]).reshape(4, 3)
        return rows[:3], rows[3] * unit

    def mesh(self, path, key, mesh, unit):
        if (path, key) not in self.meshes:
            corners = [[float(v.get(axis)) for axis in "xyz"] for v in children(mesh, "vertices")[0]]
            indices = [[int(t.get(v)) for v in ("v1", "v2", "v3")] for t in children(mesh, "triangles")[0]]
            self.meshes[path, key] = np.array(corners)[np.array(indices)] * unit
        return self.meshes[path, key]

    def placed(self, path, key, motion, depth=0):
        if depth > 32:
            raise Unreadable("components are nested more than 32 deep, or in a circle: write them flat")
        _, objects, unit = self.model(path)
        for mesh in children(objects[key], "mesh"):
            yield self.mesh(path, key, mesh, unit) @ motion[0] + motion[1]
        for group in children(objects[key], "components"):
            for part in children(group, "component"):
                turn, shift = self.motion(part, unit)
                inside = posixpath.join("/", attribute(part, "path") or path)
                moved = (turn @ motion[0], shift @ motion[0] + motion[1])
                yield from self.placed(inside, part.get("objectid"), moved, depth + 1)

    def copies(self):
        root, _, unit = self.model(self.root)
        for build in children(root, "build"):
            for item in children(build, "item"):
                path = posixpath.join("/", attribute(item, "path") or self.root)
                yield from self.placed(path, item.get("objectid"), self.motion(item, unit))


def read_entry(path, parts):
    """For each copy the files that it may be, and its triangles."""
    try:
        if zipfile.is_zipfile(path):
            copies = [(None, triangles) for triangles in Package(path).copies()]
            if not all(np.isfinite(triangles).all() for _, triangles in copies):
                raise Unreadable(f"{path} has numbers that are not finite: write them again")
            return copies
        copies = []
        for part in json.loads(Path(path).read_text())["parts"]:
            matrix = np.array(part["transform"], float)
            if part["file"] not in parts:
                raise Unreadable(f"{path} places {part['file']!r}: name files as the list of the workload does")
            if matrix.shape != (4, 4) or not np.isfinite(matrix).all() or (matrix[3] != [0, 0, 0, 1]).any():
                raise Unreadable(f"{path}: a transform is not 4 x 4 numbers with the last row 0 0 0 1")
            copies.append((part["file"], parts[part["file"]][0] @ matrix[:3, :3].T + matrix[:3, 3]))
        return copies
    except (OSError, KeyError, IndexError, ValueError, TypeError, ElementTree.ParseError, zipfile.BadZipFile) as error:
        raise Unreadable(f"{path}: {error!r}: an entry is a whole 3MF file, or JSON as README.md shows")


# ---- Each copy is its STL, moved ----


def fit(source, target):
    """The rigid motion that moves corners nearest to others (Kabsch 1976); what is wrong if they do not meet."""
    p, q = source.reshape(-1, 3), target.reshape(-1, 3)
    p0, q0 = p.mean(0), q.mean(0)
    p, q = p - p0, q - q0
    u, stretch, v = np.linalg.svd(p.T @ q)
    sign = np.sign(np.linalg.det(u @ v))

    def miss(turn, scale=1.0):
        return np.linalg.norm(scale * p @ turn - q, axis=1).max()

    signs = np.array([1, 1, sign])
    turn = (u * signs) @ v  # a row vector times `turn` is turned
    off = miss(turn)
    if off < FIT_MM:
        return (turn, q0 - p0 @ turn), off, None
    scale = (stretch * signs).sum() / (p * p).sum()
    if sign < 0 and miss(u @ v, stretch.sum() / (p * p).sum()) < FIT_MM:
        return None, off, "is mirrored: only rotations and translations are allowed"
    if miss(turn, scale) < FIT_MM:
        return None, off, f"is scaled by {scale:.5f}: write it in its own size (3MF: look at the unit)"
    return None, off, f"is {off:.3f} mm away from the moved STL: keep corners and triangles as they are, in their order"


def match(copies, parts):
    """Placed copies (file, number, motion), and faults."""
    found, faults, left = [], [], {file: quantity for file, (_, quantity) in parts.items()}
    for at, (file, triangles) in enumerate(copies, 1):
        names = [file] if file else [f for f in parts if len(parts[f][0]) == len(triangles)]
        tries = [(fit(parts[name][0], triangles), name) for name in names]
        fitting = [(name, motion) for (motion, _, _), name in tries if motion is not None]
        if fitting:
            name, motion = next((f for f in fitting if left[f[0]] > 0), fitting[0])
            left[name] -= 1
            found.append((name, parts[name][1] - left[name], motion))
        elif tries:
            (_, _, wrong), name = min(tries, key=lambda one: one[0][1])
            faults.append(f"copy {at} ({name}) {wrong}")
        else:
            count = f"{len(triangles)} triangles, as no STL of the workload"
            faults.append(f"copy {at} has {count}: write its triangles unchanged")
    for file, missing in left.items():
        if missing:
            word = f"{missing} missing: place each" if missing > 0 else f"{-missing} too many: leave them out"
            faults.append(f"{file}: {word}")
    return found, faults


# ---- Distances ----


def compare(copies, clearance):
    """The least distance of all pairs, and faults."""
    low, high = np.array([c.low for c in copies]), np.array([c.high for c in copies])
    gap = np.maximum(np.maximum(low[:, None] - high[None], low[None] - high[:, None]), 0)
    gap = np.sqrt(dot(gap, gap))
    first, second = np.triu_indices(len(copies), 1)
    order = gap[first, second].argsort(kind="stable")
    wanted, least, faults = max(clearance - SLACK_MM, 1e-9), math.inf, []
    for one, two in ((first[k], second[k]) for k in order):
        cap = min(max(least, wanted), 1e6)
        if gap[one, two] >= cap:
            break
        a, b = copies[one], copies[two]
        found = distance(a, b, cap)
        if found < cap:
            least = min(least, found)
        if found < wanted:
            how = f"are {found:.4f} mm apart, {clearance:g} mm are asked" if found else "meet"
            faults.append(f"{a.name} and {b.name} {how}: move them apart")
        if gap[one, two] == 0 and found > 0:
            for inner, outer in ((a, b), (b, a)):
                if is_inside(inner, outer):
                    faults.append(f"{inner.name} is inside the solid of {outer.name}: place it outside")
    return least, faults


# ---- The judgement ----


def judge(folder, name, entry, clearance=None):
    """The record of an entry, and the poses of its copies."""
    base, asked, parts = read_workload(folder, name)
    clearance = asked if clearance is None else clearance
    found, faults = match(read_entry(entry, parts), parts)
    shapes = {file: Shape(triangles) for file, (triangles, _) in parts.items()}
    copies = [Copy(f"{file} #{number}", shapes[file], motion) for file, number, motion in found]
    for copy in copies:
        out = np.array([-copy.low[0], -copy.low[1], copy.high[0] - base[0], copy.high[1] - base[1]]).max()
        if out > SLACK_MM:
            where = f"outside the base of {base[0]:g} x {base[1]:g} mm"
            faults.append(f"{copy.name} is {out:.4f} mm {where}: move it inside")
        if copy.low[2] < -SLACK_MM:
            faults.append(f"{copy.name} is {-copy.low[2]:.4f} mm below the floor: raise it to z = 0")
    least, near = compare(copies, clearance) if len(copies) > 1 else (math.inf, [])
    height = max((float(copy.high[2]) for copy in copies), default=0.0)
    volume = sum(copy.shape.volume for copy in copies)
    faults += near
    record = {
        "workload": name,
        "height_mm": round(height, 4),
        "least_distance_mm": round(least, 4) if least < math.inf else None,
        "clearance_mm": clearance,
        "density": round(volume / (base[0] * base[1] * height), 5) if height > 0 else 0.0,
        "copies": len(copies),
        "file_sha256": hashlib.sha256(Path(entry).read_bytes()).hexdigest(),
        "judge": JUDGE_VERSION,
        "ok": not faults,
        "faults": faults,
    }
    return record, found


def as_poses(found):
    """An entry as JSON, a line for each copy."""

    def matrix(turn, shift):
        rows = np.column_stack((turn.T, shift)).round(9).tolist()
        return rows + [[0, 0, 0, 1]]

    lines = [json.dumps({"file": file, "transform": matrix(*motion)}) for file, _, motion in found]
    return '{"parts": [\n' + ",\n".join(lines) + "\n]}\n"


def table(path):
    """The best result of each program for each workload."""
    try:
        entries = json.loads(Path(path).read_text())["entries"]
        programs = list(dict.fromkeys(e["program"] for e in entries))
        rows = {}
        for e in entries:
            mark = "" if e["clearance_ok"] else f" (distance {e['least_distance_mm']:.2f})"
            cell = (not e["clearance_ok"], e["height_mm"], f"{e['height_mm']:.1f}{mark}")
            cells = rows.setdefault(e["workload"], {})
            cells[e["program"]] = min(cell, cells.get(e["program"], cell))
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise Unreadable(f"{path}: {error!r}: see results.json in the repository for what an entry holds")
    lines = ["| workload | " + " | ".join(programs) + " |", "|---" * (len(programs) + 1) + "|"]
    for workload, cells in rows.items():
        lines.append(f"| {workload} | " + " | ".join(cells[p][2] if p in cells else "-" for p in programs) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("given", nargs="*", metavar="FOLDER WORKLOAD ENTRY")
    parser.add_argument("--clearance", type=float, metavar="MM", help="judge at another clearance")
    parser.add_argument("--json", metavar="FILE", help="also write the result as a record")
    parser.add_argument("--poses", metavar="FILE", help="also write the entry as a small JSON of poses")
    parser.add_argument("--table", metavar="RESULTS", help="print the table of results")
    asked = parser.parse_args()
    try:
        if asked.table:
            print(table(asked.table))
            return 0
        if len(asked.given) != 3:
            parser.error("say FOLDER WORKLOAD ENTRY, e.g. judge.py workloads fans20 build.3mf")
        record, found = judge(Path(asked.given[0]), *asked.given[1:], asked.clearance)
        if asked.poses:
            Path(asked.poses).write_text(as_poses(found))
        if asked.json:
            Path(asked.json).write_text(json.dumps(record, indent=1) + "\n")
    except (Unreadable, OSError) as error:
        print(f"judge.py: {error}", file=sys.stderr)
        return 2
    least = record["least_distance_mm"]
    print(f"{record['workload']}: {record['copies']} copies, clearance {record['clearance_mm']:g} mm")
    print(f"height          {record['height_mm']:.4f} mm")
    print(f"least distance  {'-' if least is None else f'{least:.4f} mm'}")
    print(f"density         {record['density']:.4f}")
    for fault in record["faults"][:FAULTS_SHOWN]:
        print(f"FAULT: {fault}")
    if len(record["faults"]) > FAULTS_SHOWN:
        print(f"and {len(record['faults']) - FAULTS_SHOWN} more faults")
    print("OK" if record["ok"] else "this entry does not count")
    return 0 if record["ok"] else 1


if __name__ == "__main__":
    sys.exit(main())
