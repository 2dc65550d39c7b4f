"""The USGS elevation model that the matplotlib wheel carries, and a tint for it."""

import math
import os

import numpy as np

from image import linear, mix, smoothstep, srgb8, unorm16
from noise import fbm

LOW, HIGH = 236.0, 1076.0  # metres; 0 and 65535 in the PNG
EARTH = 111_200.0  # metres a degree of latitude


def load():
    import matplotlib

    path = os.path.join(matplotlib.get_data_path(), "sample_data", "jacksboro_fault_dem.npz")
    with np.load(path) as dem:
        z = dem["elevation"].astype(np.float64)
        lat = 0.5 * float(dem["ymin"] + dem["ymax"])
        dx = EARTH * float(dem["dx"]) * math.cos(math.radians(lat))
        dy = EARTH * float(dem["dy"])
    assert z.shape == (344, 403) and z.min() == LOW and z.max() == HIGH
    return z, dx, dy


def extent():
    """(width, depth, relief) in metres."""
    z, dx, dy = load()
    return z.shape[1] * dx, z.shape[0] * dy, HIGH - LOW


def twice(a):
    """Bilinear, two texels for one, the ends held."""
    for axis in (0, 1):
        p = np.pad(a, [(1, 1) if k == axis else (0, 0) for k in range(a.ndim)], mode="edge")
        n = a.shape[axis]
        before, here, after = (np.take(p, np.arange(n) + k, axis) for k in range(3))
        a = np.stack([0.25 * before + 0.75 * here, 0.75 * here + 0.25 * after], axis + 1)
        a = a.reshape([2 * n if k == axis else s for k, s in enumerate(here.shape)])
    return a


def make():
    z, dx, dy = load()
    height = unorm16((z - LOW) / (HIGH - LOW))

    # Tint by height, a bare tone on steep ground, a little unevenness. No light is baked in.
    gy, gx = np.gradient(z, dy, dx)
    steep = twice(np.hypot(gx, gy))
    fine = twice(z)
    n, m = fine.shape
    u, v = np.meshgrid((np.arange(m) + 0.5) / m, (np.arange(n) + 0.5) / n)
    rough = fbm(u, v, 24, 5, 0x7E44, 0.65)
    at = fine + 35 * rough
    stops = [(236, "#5f8152"), (300, "#7b9960"), (380, "#a3ad6e"), (480, "#bfae78"), (600, "#a98b5d"), (760, "#8d7155"), (900, "#9b8c7d"), (1076, "#d9d4cc")]
    colours = np.stack([linear(c) for _, c in stops])
    rgb = np.stack([np.interp(at, [s for s, _ in stops], colours[:, k]) for k in range(3)], -1)
    rgb = mix(rgb, linear("#6b6152"), (0.45 * smoothstep(0.18, 0.55, steep))[..., None])
    rgb = rgb * (1 + 0.16 * rough)[..., None]
    return {"terrain_height": height, "terrain_albedo": srgb8(rgb)}
