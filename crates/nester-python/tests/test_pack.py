"""Layouts, measured with means that are not those of the package."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from conftest import BOX_FACES, VOLUME, Box, box_gap, corners_at

import nestd_nester as nn


def test_boxes_keep_their_clearance_and_stay_in_the_volume(box: Box) -> None:
    plate = Box(30.0, 20.0, 3.0)
    solution = nn.pack({box: 8, plate: 6}, VOLUME, 2, evaluations=3000)
    assert len(solution.placements) == 14 and not solution.left_out
    placed = [corners_at(placement.key, placement.matrix) for placement in solution.placements]
    for corners in placed:
        assert corners.min() >= -1e-6 and (corners <= np.array(VOLUME) + 1e-6).all()
    for one, other in itertools.combinations(placed, 2):
        assert box_gap(one, other) > 0, "two boxes overlap"
    assert solution.height == pytest.approx(max(corners[:, 2].max() for corners in placed), abs=1e-9)
    for matrix in solution.poses:
        assert matrix.shape == (4, 4) and matrix.dtype == np.float64
        np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(matrix) == pytest.approx(1.0) and matrix[3].tolist() == [0, 0, 0, 1]


def test_boxes_along_the_axes_keep_their_clearance_exactly(box: Box) -> None:
    solution = nn.pack({box: 12}, VOLUME, 3, evaluations=2000, orientation="axis")
    placed = [corners_at(box, matrix) for matrix in solution.poses]
    gaps = []
    for one, other in itertools.combinations(placed, 2):
        apart = np.maximum(other.min(axis=0) - one.max(axis=0), one.min(axis=0) - other.max(axis=0))
        gaps.append(np.linalg.norm(np.maximum(apart, 0.0)))
    assert min(gaps) >= 3 - 1e-6
    proof = solution.verify()
    assert proof.least_distance == pytest.approx(min(gaps), abs=1e-6) and proof.placements == 12
    assert sorted(removal.placement for removal in proof.removal_order) == list(range(12)) and not proof.locked
    assert proof.height == pytest.approx(solution.height)


def test_shapes_keep_their_clearance_as_another_kernel_measures_it() -> None:
    trimesh, manifold3d = pytest.importorskip("trimesh"), pytest.importorskip("manifold3d")
    ring, torus = trimesh.creation.annulus(8, 14, 6), trimesh.creation.torus(10, 3)
    solution = nn.pack({ring: 6, torus: 6}, VOLUME, 1.5, evaluations=3000)
    assert len(solution.placements) == 12

    def solid(placement: nn.Placement) -> object:
        mesh = placement.key.copy()
        mesh.apply_transform(placement.matrix)
        vertices, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)
        return manifold3d.Manifold(manifold3d.Mesh(vert_properties=vertices, tri_verts=faces))

    solids = [solid(placement) for placement in solution.placements]
    gaps = [one.min_gap(other, 4.0) for one, other in itertools.combinations(solids, 2)]
    assert min(gaps) >= 1.5 - 1e-4
    assert solution.verify().least_distance == pytest.approx(min(gaps), abs=1e-4)
    assert all((one ^ other).volume() == 0 for one, other in itertools.combinations(solids, 2))


def test_the_same_seed_and_evaluations_give_the_same_poses() -> None:
    frustum = Box(20, 14, 16)
    frustum.vertices[4:, :2] = frustum.vertices[4:, :2] * 0.2 + [8, 2]

    def poses(seed: int, threads: int, lanes: int) -> np.ndarray:
        options = {"seed": seed, "threads": threads, "lanes": lanes}
        return np.array(nn.pack({frustum: 12}, VOLUME, 2, evaluations=1500, **options).poses)

    first = poses(1, 1, 2)
    assert (first == poses(1, 2, 2)).all(), "the number of threads does not count"
    assert (first != poses(2, 1, 2)).any()


@pytest.mark.parametrize("floats", [np.float64, np.float32, np.float16, np.int32])
@pytest.mark.parametrize("integers", [np.int64, np.int32, np.uint32, np.uint8, np.uint64])
def test_arrays_of_any_kind_of_number_are_the_same_part(floats: type, integers: type) -> None:
    vertices, faces = Box(8, 6, 4).vertices.astype(floats), BOX_FACES.astype(integers)
    for pair in [(vertices, faces), (np.asfortranarray(vertices), faces[::-1]), (vertices.tolist(), faces.tolist())]:
        solution = nn.pack([(pair, 2)], (30, 30, 30), 1, evaluations=200)
        assert solution.density == pytest.approx(2 * 192 / (900 * solution.height))
        assert solution.mesh(0)[0].shape == (8, 3) and solution.mesh(0)[1].shape == (12, 3)
        assert solution.placements[0].key is pair


def test_poses_belong_to_the_frame_of_the_given_mesh() -> None:
    away = Box(10, 8, 6)
    away.vertices = away.vertices + [500.0, -300.0, 70.0]
    solution = nn.pack({away: 1}, (20, 20, 20), 1, evaluations=100, orientation="fixed")
    np.testing.assert_allclose(corners_at(away, solution.poses[0]).min(axis=0), 0.0, atol=1e-5)
    assert (solution.poses[0][:3, :3] == np.eye(3)).all()


def test_parts_may_have_names_orientations_and_clearances_of_their_own(box: Box) -> None:
    items = [nn.Item(box, 2, name="tower", orientation="fixed", clearance=9.0), (Box(5, 5, 5), 3)]
    solution = nn.pack(items, VOLUME, 1, evaluations=800)
    assert [part.name for part in solution.parts] == ["tower", "part 2"]
    assert [part.copies for part in solution.parts] == [2, 3]
    towers = [placement for placement in solution.placements if placement.name == "tower"]
    assert [tower.copy for tower in towers] == [0, 1]
    for tower in towers:
        np.testing.assert_allclose(tower.matrix[:3, :3], np.eye(3), atol=1e-12)
        for other in solution.placements:
            if other is not tower:
                corners = corners_at(tower.key, tower.matrix), corners_at(other.key, other.matrix)
                assert np.linalg.norm(corners[0].mean(axis=0) - corners[1].mean(axis=0)) > 9.0 + 4.0 + 2.5
    solution.verify()


def test_poses_that_somebody_has_changed_are_proved_or_refused(box: Box) -> None:
    solution = nn.pack({box: 4}, VOLUME, 2, evaluations=400, orientation="axis")
    assert solution.verify(solution.poses) == solution.verify()
    poses = np.array(solution.poses)

    def fault(kind: type[Exception], change: object, at: int = 1) -> str:
        changed = poses.copy()
        changed[at] = change
        with pytest.raises(kind) as caught:
            solution.verify(changed)
        return str(caught.value)

    shifted, outside, aslant = poses[0].copy(), poses[1].copy(), poses[1].copy()
    shifted[2, 3] += 8.0 + 1.25
    if np.ptp(corners_at(box, poses[0])[:, 2]) == pytest.approx(8.0):
        assert "part 1 #1 and part 1 #2 are 1.2500 mm apart instead of 2" in fault(nn.ProofError, shifted)
    assert "are 0.0000 mm apart" in fault(nn.ProofError, poses[0])
    outside[0, 3] -= 7.0
    assert "part 1 #2 is " in fault(nn.ProofError, outside) and "mm outside" in fault(nn.ProofError, outside)
    aslant[:3, :3] = [[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]
    aslant[:3, 3] = [20, 20, 80]
    assert "turned against its orientation rule" in fault(nn.ProofError, aslant)
    for nonsense in (poses[1] * 1.01, np.diag([1, 1, -1, 1]), np.full((4, 4), np.nan), np.ones((4, 4))):
        assert "pose 1 is no rotation" in fault(nn.InputError, nonsense)
    with pytest.raises(nn.InputError, match="each of 4 placements"):
        solution.verify(poses[:3])
    with pytest.raises(nn.InputError, match="each of 4 placements"):
        solution.verify(poses[0])
    with pytest.raises(ValueError, match="read-only"):
        solution.poses[0][0, 3] = 0.0


def test_interlocking_is_checked_unless_it_is_allowed(box: Box) -> None:
    for rule, removed in (("forbid", 4), ("warn", 4), ("allow", 0)):
        proof = nn.pack({box: 4}, VOLUME, 2, evaluations=200, interlock=rule).verify()
        assert len(proof.removal_order) == removed and not proof.locked


def test_copies_without_room_are_left_out_and_explained(box: Box) -> None:
    solution = nn.pack({box: 5}, (22, 22, 22), 2, evaluations=500, orientation="fixed")
    assert len(solution.placements) == 2 and [left.copy for left in solution.left_out] == [2, 3, 4]
    assert all(left.key is box and left.name == "part 1" for left in solution.left_out)
    assert "one of them would fit alone" in solution.explain_left_out()[0]
    assert "2 of 5 copies placed" in repr(solution)
    solution.verify()


def test_the_search_ends_at_the_lowest_layout_and_says_so(box: Box) -> None:
    solution = nn.pack({box: 1}, VOLUME, 2, seconds=60)
    assert solution.seconds < 30 and solution.ended == "no lower layout exists"
    assert solution.height == pytest.approx(8.0, abs=0.02) and solution.lower_bound <= solution.height + 1e-6
    assert solution.heights[-1][1] == solution.height


def test_the_published_method_packs_too(box: Box) -> None:
    solution = nn.pack({box: 4}, VOLUME, 2, seconds=1.0, method="paper")
    assert len(solution.placements) == 4
    assert solution.verify().least_distance is None or solution.verify().least_distance >= 2 - 1e-6


def test_limits_are_those_that_were_given(box: Box) -> None:
    timed = nn.pack({box: 12, Box(9, 7, 5): 9}, VOLUME, 2, seconds=0.7)
    assert timed.seconds < 3.0 and timed.ended != "stopped"
    idle = nn.pack({box: 12, Box(9, 7, 5): 9}, VOLUME, 2, patience=0.3, seconds=60)
    assert idle.seconds < 50.0 and idle.ended in ("nothing gained for 0 s", "no lower layout exists")
