"""Meshes as (positions, unit normals, UVs, triangles). Counter-clockwise from outside, Y up, v down the image.

Positions that coincide are equal to the bit (angles are taken by index, modulo the count), so that an
engine which welds by position closes every seam.
"""

import math
import os

import numpy as np

import noise


def grid_triangles(columns, rows):
    """Of (columns + 1) x (rows + 1) vertices, row by row; the first row is on top, seen from outside."""
    triangles = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 1, a + columns + 2
            triangles += [(a, c, d), (a, d, b)]
    return triangles


def torus(major=1.0, minor=0.4, around=48, along=24, repeat=(5, 2)):
    """u runs around the ring, v down the tube; 5:2 repeats make square tiles of 2π/5 at the tube's top."""
    p, n, t = [], [], []
    for j in range(along + 1):
        b = 2 * math.pi * (-(j % along)) / along
        for i in range(around + 1):
            a = 2 * math.pi * (i % around) / around
            normal = (math.cos(b) * math.cos(a), math.sin(b), -math.cos(b) * math.sin(a))
            p.append((major * math.cos(a) + minor * normal[0], minor * normal[1], -major * math.sin(a) + minor * normal[2]))
            n.append(normal)
            t.append((repeat[0] * i / around, repeat[1] * j / along))
    return p, n, t, grid_triangles(around, along)


def sphere(around=64, down=32):
    """Of radius 1; the poles are points, without empty triangles."""
    p, t = [], []
    for j in range(down + 1):
        b = math.pi * j / down
        s, c = (0.0, math.copysign(1.0, down / 2 - j)) if j in (0, down) else (math.sin(b), math.cos(b))
        for i in range(around + 1):
            a = 2 * math.pi * (i % around) / around
            p.append((s * math.cos(a), c, -s * math.sin(a)))
            t.append((i / around, j / down))
    triangles = [f for f in grid_triangles(around, down) if len({p[k] for k in f}) == 3]
    return p, p, t, triangles


def stack(radius=0.62, trunk=1.6, flare=0.25, around=40, dome_rows=10, trunk_rows=14, repeat=3):
    """A sea stack: a half ball on a trunk that widens downwards (r = radius + flare k²), open below, its
    foot at y = 0. u runs around `repeat` tiles, v down the outline at the same size of tile."""
    tile = 2 * math.pi * radius / repeat
    outline = []  # radius, y, normal's radius, normal's y, arc length
    for j in range(dome_rows):
        b = math.pi / 2 * j / dome_rows
        outline.append((radius * math.sin(b), trunk + radius * math.cos(b), math.sin(b), math.cos(b), radius * b))
    arc = radius * math.pi / 2
    for j in range(trunk_rows + 1):
        k = j / trunk_rows
        if j:
            arc += math.hypot(k * k * flare - outline[-1][0] + radius, trunk / trunk_rows)
        length = math.hypot(trunk, 2 * flare * k)
        outline.append((radius + flare * k * k, trunk * (1 - k), trunk / length, 2 * flare * k / length, arc))
    p, n, t = [], [], []
    for r, y, nr, ny, s in outline:
        for i in range(around + 1):
            a = 2 * math.pi * (i % around) / around
            p.append((r * math.cos(a), y, -r * math.sin(a)))
            n.append((nr * math.cos(a), ny, -nr * math.sin(a)))
            t.append((repeat * i / around, s / tile))
    p = [tuple(x + 0.0 for x in q) for q in p]
    triangles = [f for f in grid_triangles(around, dome_rows + trunk_rows) if len({p[k] for k in f}) == 3]
    return p, n, t, triangles


def well(inner=0.78, outer=1.06, foot=-0.1, height=0.52, rounding=0.07, around=64, corner_rows=5, repeat=7):
    """A ring wall with a rounded rim, open below. u runs around `repeat` units, v down the outline from the inside to the
    outside; a unit is 3 wide (half way between inside and outside) by 2 high."""
    unit = 2 / 3 * math.pi * (inner + outer) / repeat
    outline = [(inner, foot, -1.0, 0.0)]  # radius, y, normal's radius, normal's y
    for radius, start in ((inner + rounding, 180), (outer - rounding, 90)):
        for j in range(corner_rows + 1):
            b = math.radians(start - 90 * j / corner_rows)
            n = (math.cos(b), math.sin(b))
            outline.append((radius + rounding * n[0], height - rounding + rounding * n[1], *n))
    outline.append((outer, foot, 1.0, 0.0))
    p, n, t, arc = [], [], [], 0.0
    for j, (r, y, nr, ny) in enumerate(outline):
        if j:
            arc += math.hypot(r - outline[j - 1][0], y - outline[j - 1][1])
        for i in range(around + 1):
            a = 2 * math.pi * (i % around) / around
            p.append((r * math.cos(a), y, -r * math.sin(a)))
            n.append((nr * math.cos(a), ny, -nr * math.sin(a)))
            t.append((repeat * i / around, arc / unit))
    return p, n, t, grid_triangles(around, len(outline) - 1)


def cylinder(radius=0.6, height=1.4, around=32, repeat=(5, 2)):
    """Around the y axis, open at both ends."""
    p, n, t = [], [], []
    for j in range(2):
        for i in range(around + 1):
            a = 2 * math.pi * (i % around) / around
            normal = (math.cos(a), 0.0, -math.sin(a))
            p.append((radius * normal[0], (0.5 - j) * height, radius * normal[2]))
            n.append(normal)
            t.append((repeat[0] * i / around, repeat[1] * j))
    return p, n, t, grid_triangles(around, 1)


def patch(radius, width, height, columns=4, rows=4):
    """Of a ball's surface, the top of it at the origin: `width` east by `height` north along the arcs, north is -Z."""
    p, n, t = [], [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            a, b = width / radius * (i / columns - 0.5), height / radius * (0.5 - j / rows)
            normal = (math.sin(a) * math.cos(b), math.cos(a) * math.cos(b), -math.sin(b))
            n.append(normal)
            p.append((radius * normal[0], radius * (normal[1] - 1), radius * normal[2]))
            t.append((i / columns, j / rows))
    return p, n, t, grid_triangles(columns, rows)


def disc(radius, around=48, repeat=1.0):
    """Flat, facing up, with one UV unit for `repeat` of its length."""
    p = [(0.0, 0.0, 0.0)]
    for i in range(around):
        a = 2 * math.pi * i / around
        p.append((radius * math.cos(a), 0.0, -radius * math.sin(a)))
    t = [((x + radius) / repeat, (z + radius) / repeat) for x, _, z in p]
    return p, [(0.0, 1.0, 0.0)] * len(p), t, [(0, 1 + i, 1 + (i + 1) % around) for i in range(around)]


def sheet(centre, right, down, repeat=(1, 1), columns=1, rows=1):
    """A flat rectangle: centre, half extents as vectors, the UV range."""
    normal = np.cross(down, right)
    normal = normal / np.linalg.norm(normal)
    p, t = [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            x, y = i / columns, j / rows
            p.append(np.add(centre, np.multiply(right, 2 * x - 1)) + np.multiply(down, 2 * y - 1))
            t.append((repeat[0] * x, repeat[1] * y))
    return p, [normal] * len(p), t, grid_triangles(columns, rows)


def cube():
    """24 vertices, face normals, each face the whole tile. Around the four sides u runs on, so that the
    map goes over the upright edges without a step; at the top and the bottom it does not."""
    faces = [  # outward, right, down
        ((0, 0, 1), (1, 0, 0), (0, -1, 0)),
        ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
        ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
        ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
        ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
        ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
    ]
    p, n, t, triangles = [], [], [], []
    for outward, right, down in faces:
        q = sheet(outward, right, down)
        triangles += [tuple(k + len(p) for k in f) for f in q[3]]
        p, n, t = p + list(q[0]), n + list(q[1]), t + q[2]
    return p, n, t, triangles


def cloth(cells=32, width=3.0, height=2.0, repeat=(3, 2)):
    """A hanging sheet that waves: z = f(x, y), its normals from f's derivatives."""
    waves = [(0.20, 2.3, 0.7, 0.4), (0.075, -1.4, 3.1, 1.9), (0.045, 5.2, 1.3, 0.0)]  # amplitude, x, y, phase
    p, n, t = [], [], []
    for j in range(cells + 1):
        for i in range(cells + 1):
            x, y = width * (i / cells - 0.5), height * (0.5 - j / cells)
            z = sum(a * math.sin(kx * x + ky * y + c) for a, kx, ky, c in waves)
            dx = sum(a * kx * math.cos(kx * x + ky * y + c) for a, kx, ky, c in waves)
            dy = sum(a * ky * math.cos(kx * x + ky * y + c) for a, kx, ky, c in waves)
            length = math.sqrt(dx * dx + dy * dy + 1)
            p.append((x, y, z))
            n.append((-dx / length, -dy / length, 1 / length))
            t.append((repeat[0] * i / cells, repeat[1] * j / cells))
    return p, n, t, grid_triangles(cells, cells)


def arch(radius=0.8, angle=2.0, length=2.0, columns=240, repeat=(2.5, 3)):
    """Slivers: a strip of a cylinder around Z, of `columns` quads as long as the whole; with these numbers each
    triangle is 300 times as long as it is wide."""
    p, n, t = [], [], []
    for j in (0, 1):
        for i in range(columns + 1):
            a = angle * (0.5 - i / columns)
            n.append((-math.sin(a), math.cos(a), 0.0))
            p.append((-radius * math.sin(a), radius * math.cos(a), length * (j - 0.5)))
            t.append((repeat[0] * i / columns, repeat[1] * j))
    return p, n, t, grid_triangles(columns, 1)


def patches(seed=1, tile=0.8):
    """A ball of 32 triangles (an octahedron, split once) of which each lies elsewhere in the map, turned anyhow, every
    other one mirrored: no edge agrees with its neighbour. The four of the first octant come last."""
    p, t = [], []
    axes = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for x, y, z in axes:
        corners = np.array([(x, 0, 0), (0, y, 0), (0, 0, z)], np.float64)
        if x * y * z < 0:
            corners = corners[[0, 2, 1]]
        # Midpoints are sums of the same two numbers on both sides of an edge, so they are equal to the bit.
        a, b, c = corners
        ab, bc, ca = ((u + v) / np.linalg.norm(u + v) for u, v in ((a, b), (b, c), (c, a)))
        for triangle in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)):
            k = len(p) // 3
            angle = 2 * math.pi * noise.hash01(seed, k, 0)
            turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
            place = 3 * np.array([noise.hash01(seed, k, 1), noise.hash01(seed, k, 2)]) - 1.5
            for u, v in ((0, 0), (0.5, -math.sqrt(0.75)), (1, 0)):
                t.append(place + tile * turn @ ((v, u) if k % 2 else (u, v)))
            p += [tuple(q) for q in triangle]
    return p, p, t, [(i, i + 1, i + 2) for i in range(0, len(p), 3)]


def suzanne():
    """From suzanne.obj (see suzanne_bpy.py); v is turned over, as glTF counts it from the top."""
    v, vn, vt, corners, triangles = [], [], [], {}, []
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "suzanne.obj")) as f:
        for line in f:
            word = line.split()
            if word[0] in ("v", "vn", "vt"):
                {"v": v, "vn": vn, "vt": vt}[word[0]].append([float(x) for x in word[1:]])
            elif word[0] == "f":
                triangles.append([corners.setdefault(tuple(int(k) - 1 for k in c.split("/")), len(corners)) for c in word[1:]])
    n = np.array([vn[k] for _, _, k in corners])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return [v[k] for k, _, _ in corners], n, [(vt[k][0], 1 - vt[k][1]) for _, k, _ in corners], triangles
