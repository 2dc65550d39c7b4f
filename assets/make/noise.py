"""Periodic noise over the unit square. Every function here wraps exactly at u = 1 and v = 1.

Randomness is a hash of integers (splitmix64), not a generator with state: the same seed gives the
same value on every machine and with every numpy, whatever was drawn before it.
"""

import numpy as np

_M1, _M2, _G = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB), np.uint64(0x9E3779B97F4A7C15)


def hash01(seed, *keys):
    """A number in [0, 1) for each entry of the (broadcast) integer arrays `keys`."""
    h = np.uint64(seed)
    with np.errstate(over="ignore"):
        for key in keys:
            h = (np.asarray(key).astype(np.int64).astype(np.uint64) + h * _G + _G)
            h = (h ^ (h >> np.uint64(30))) * _M1
            h = (h ^ (h >> np.uint64(27))) * _M2
            h = h ^ (h >> np.uint64(31))
    return (h >> np.uint64(11)).astype(np.float64) / float(1 << 53)


def grid(size, supersample=1):
    """u, v at the centres of size² texels, each split into supersample² samples. v grows downwards."""
    n = size * supersample
    c = (np.arange(n) + 0.5) / n
    return np.meshgrid(c, c)


def perlin(u, v, period, seed):
    """Gradient noise with `period` (one integer, or one per axis) cells a tile; about [-1, 1]."""
    pu, pv = (period, period) if np.isscalar(period) else period
    x, y = u * pu, v * pv
    x0, y0 = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    fx, fy = x - x0, y - y0
    ang = 2 * np.pi * hash01(seed, *np.meshgrid(np.arange(pu), np.arange(pv)))
    gx, gy = np.cos(ang), np.sin(ang)

    def corner(i, j):
        a, b = (y0 + j) % pv, (x0 + i) % pu
        return gx[a, b] * (fx - i) + gy[a, b] * (fy - j)

    sx = fx * fx * fx * (fx * (fx * 6 - 15) + 10)
    sy = fy * fy * fy * (fy * (fy * 6 - 15) + 10)
    top = corner(0, 0) * (1 - sx) + corner(1, 0) * sx
    bottom = corner(0, 1) * (1 - sx) + corner(1, 1) * sx
    return 1.5 * (top * (1 - sy) + bottom * sy)


def fbm(u, v, period, octaves, seed, gain=0.5):
    """Octaves of Perlin noise, divided by the sum of their weights."""
    pu, pv = (period, period) if np.isscalar(period) else period
    total, weight, a = 0.0, 0.0, 1.0
    for o in range(octaves):
        total = total + a * perlin(u, v, (pu << o, pv << o), seed + 101 * o)
        weight += a
        a *= gain
    return total / weight


def ridged(u, v, period, octaves, seed, gain=0.5):
    """Musgrave's ridged multifractal: sharp crests, each octave weighted by the one below; [0, 1]."""
    total, weight, a, carry = 0.0, 0.0, 1.0, 1.0
    for o in range(octaves):
        r = (1 - np.abs(perlin(u, v, period << o, seed + 131 * o))).clip(0, 1) ** 2
        total = total + a * r * carry
        carry = np.clip(1.6 * r, 0, 1)
        weight += a
        a *= gain
    return total / weight


def wrap(d):
    """The shortest periodic difference, in [-1/2, 1/2]."""
    return d - np.round(d)


def relaxed_points(count_u, count_v, seed, jitter=0.9, rounds=2, res=256):
    """Jittered rows of points (every other row shifted), evened out by Lloyd's rounds."""
    i, j = np.meshgrid(np.arange(count_u), np.arange(count_v))
    x = (i + 0.5 * (j % 2) + 0.25 + jitter * (hash01(seed, i, j, 0) - 0.5)) / count_u
    y = (j + 0.5 + jitter * (hash01(seed, i, j, 1) - 0.5)) / count_v
    p = np.stack([x.ravel(), y.ravel()], 1) % 1.0
    u, v = grid(res)
    for _ in range(rounds):
        owner, _, _ = nearest(u, v, p)
        for k in range(len(p)):
            m = owner == k
            if m.any():
                p[k] += (wrap(u[m] - p[k, 0]).mean(), wrap(v[m] - p[k, 1]).mean())
        p %= 1.0
    return p


def nearest(u, v, points):
    """For each sample the nearest point's number, and the vector to it."""
    best = np.full(u.shape, np.inf)
    owner = np.zeros(u.shape, np.int64)
    bx, by = np.zeros(u.shape), np.zeros(u.shape)
    for k, (px, py) in enumerate(points):
        dx, dy = wrap(px - u), wrap(py - v)
        d = dx * dx + dy * dy
        m = d < best
        best[m], owner[m], bx[m], by[m] = d[m], k, dx[m], dy[m]
    return owner, bx, by


def cell_border(u, v, points, roundness=0.0, reach=None):
    """(owner, distance to the cell's border). `roundness` > 0 blends the border's straight sides into
    one another over about that distance (a smooth minimum), which rounds the corners."""
    owner, bx, by = nearest(u, v, points)
    reach = reach or 3.0 / np.sqrt(len(points))
    acc = np.full(u.shape, np.inf) if roundness == 0 else np.zeros(u.shape)
    for k, (px, py) in enumerate(points):
        dx, dy = wrap(px - u), wrap(py - v)
        ex, ey = dx - bx, dy - by
        length = np.sqrt(ex * ex + ey * ey)
        use = (owner != k) & (length < reach)
        if not use.any():
            continue
        dist = (0.5 * ((dx + bx) * ex + (dy + by) * ey))[use] / length[use]
        if roundness == 0:
            acc[use] = np.minimum(acc[use], dist)
        else:
            acc[use] += np.exp(-dist / roundness)
    return owner, (acc if roundness == 0 else -roundness * np.log(acc))
