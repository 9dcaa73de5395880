"""Distances of placed triangle meshes, for judge.py: box trees, distances of triangles, what is inside a solid."""
import math

import numpy as np

CHUNK = 8192  # triangle pairs at a time


class Shape:
    """The triangles of an STL in the order of a box tree: below node k of a level are nodes 2k and 2k + 1 of the next."""

    def __init__(self, triangles):
        self.depth = max(0, math.ceil(math.log2(len(triangles))))
        order = np.minimum(np.arange(2**self.depth), len(triangles) - 1)[None, :]
        middles = triangles.mean(1)
        for _ in range(self.depth):
            at = middles[order]
            longest = (at.max(1) - at.min(1)).argmax(1)
            keys = np.take_along_axis(at, longest[:, None, None], 2)[:, :, 0]
            order = np.take_along_axis(order, keys.argsort(1, kind="stable"), 1).reshape(2 * len(order), -1)
        self.surface, self.triangles = triangles, triangles[order[:, 0]]  # the latter filled up with copies of the last
        self.volume = abs(np.einsum("ij,ij->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2]))) / 6
        self.shells = first_corners(triangles)


def first_corners(triangles):
    """A corner of each connected surface."""
    corners, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    index, label = index.reshape(-1, 3), np.arange(len(corners))
    while True:
        least = label.copy()
        np.minimum.at(least, index.ravel(), np.repeat(label[index].min(1), 3))
        least = least[least]
        if (least == label).all():
            return corners[np.unique(label)]
        label = least


class Copy:
    """A shape at its place, with the boxes of its tree, the whole one first."""

    def __init__(self, name, shape, motion):
        self.name, self.shape, self.motion = name, shape, motion
        self.triangles = shape.triangles @ motion[0] + motion[1]
        self.shells = shape.shells @ motion[0] + motion[1]
        boxes = [(self.triangles.min(1), self.triangles.max(1))]
        while len(boxes[-1][0]) > 1:
            low, high = boxes[-1]
            boxes.append((low.reshape(-1, 2, 3).min(1), high.reshape(-1, 2, 3).max(1)))
        self.boxes = boxes[::-1]
        self.low, self.high = self.boxes[0][0][0], self.boxes[0][1][0]


def dot(a, b):
    return (a * b).sum(-1)


def triangle_distances(a, b):
    """Squared distances of pairs of triangles, (n, 3, 3) each; 0 where they meet.

    The nearest points are on two edges, or on a corner and a face, or an edge passes through a face.
    """
    u, v = np.roll(a, -1, 1) - a, np.roll(b, -1, 1) - b  # edges
    w = a[:, :, None] - b[:, None]  # from corner j of b to corner i of a: [n, i, j]
    u_, v_ = u[:, :, None], v[:, None]
    uu, vv, uv, uw, vw = dot(u_, u_), dot(v_, v_), dot(u_, v_), dot(u_, w), dot(v_, w)
    with np.errstate(divide="ignore", invalid="ignore"):
        # A corner and an edge.
        t = np.nan_to_num(np.clip(vw / vv, 0, 1))[..., None]
        s = np.nan_to_num(np.clip(-uw / uu, 0, 1))[..., None]
        to_b, to_a = w - t * v_, w + s * u_
        best = np.minimum(dot(to_b, to_b).min((1, 2)), dot(to_a, to_a).min((1, 2)))
        # Two edges inside both: along their common normal.
        normal = np.cross(u_, v_)
        area = dot(normal, normal)
        s, t = (uv * vw - vv * uw) / area, (uu * vw - uv * uw) / area
        inside = (area > 1e-12 * uu * vv) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
        best = np.minimum(best, np.where(inside, dot(w, normal) ** 2 / area, np.inf).min((1, 2)))
        # Corners and edges of one, the face of the other.
        for w, u, v in ((w, u, v), (-w.swapaxes(1, 2), v, u)):
            normal = np.cross(v[:, 0], v[:, 1])
            area = dot(normal, normal)
            inward = np.cross(normal[:, None], v)
            side = dot(w, inward[:, None])
            height = dot(w[:, :, 0], normal[:, None])
            over = (side >= 0).all(2) & (area > 0)[:, None]
            best = np.minimum(best, np.where(over, height**2 / area[:, None], np.inf).min(1))
            after = np.roll(height, -1, 1)
            share = (height / (height - after))[..., None]
            through = (side + share * dot(u[:, :, None], inward[:, None]) >= 0).all(2)
            best = np.where((through & (height * after < 0)).any(1), 0.0, best)
    return best


def distance(one, two, cap):
    """The least distance of the surfaces of two copies, if it is less than `cap`; else `cap`."""
    i = j = np.zeros(1, int)
    best = cap * cap
    at, other = 0, 0
    while True:
        low1, high1, low2, high2 = *(side[i] for side in one.boxes[at]), *(side[j] for side in two.boxes[other])
        gap = np.maximum(np.maximum(low1 - high2, low2 - high1), 0)
        gap = dot(gap, gap)
        # No two points of two boxes are farther apart than this.
        span = np.maximum(high1 - low2, high2 - low1)
        bound = min(best, dot(span, span).min()) if len(i) else best
        near = gap <= bound
        i, j, gap = i[near], j[near], gap[near]
        if not len(i) or (at == one.shape.depth and other == two.shape.depth):
            break
        if at < one.shape.depth:
            at, i, j = at + 1, np.concatenate((2 * i, 2 * i + 1)), np.concatenate((j, j))
        if other < two.shape.depth:
            other, i, j = other + 1, np.concatenate((i, i)), np.concatenate((2 * j, 2 * j + 1))
    order = gap.argsort()
    for start in range(0, len(order), CHUNK):
        chunk = order[start : start + CHUNK]
        if gap[chunk[0]] >= best:
            break
        best = min(best, triangle_distances(one.triangles[i[chunk]], two.triangles[j[chunk]]).min())
    return math.sqrt(best)


def winds_around(points, triangles):
    """How often a closed surface winds around points, by solid angles (van Oosterom and Strackee 1983)."""
    a, b, c = (triangles[None, :, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.sqrt(dot(side, side)) for side in (a, b, c))
    volume = dot(a, np.cross(b, c))
    return np.arctan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb).sum(1) / (2 * np.pi)


def is_inside(one, two):
    """Whether a surface of `one` is in the solid of `two`, if the two do not meet."""
    points = one.shells[((one.shells >= two.low) & (one.shells <= two.high)).all(1)]
    turn, shift = two.motion
    return len(points) > 0 and (np.abs(winds_around((points - shift) @ turn.T, two.shape.surface)) > 0.5).any()
