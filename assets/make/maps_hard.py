"""Height maps that a search along a ray gets wrong first: cliffs and needles one texel wide. No albedo: only the shape counts."""

import numpy as np

from image import unorm16
from noise import hash01

SIZE = 64


def cliffs():
    """Blocks of 4² texels on five levels, cut by walls and trenches one texel thick. Every slope is one texel wide."""
    y, x = np.mgrid[:SIZE, :SIZE]
    h = np.floor(5 * hash01(11, x // 4, y // 4)) / 4
    for k in range(6):
        # From edge to edge, so that the map still wraps; walls and trenches in turn, along u and v in turn.
        at = int(SIZE * hash01(12, k))
        h[(at, slice(None)) if k // 2 % 2 else (slice(None), at)] = k % 2
    return h


def needles():
    """Single texels of full height on flat ground, about one in eighty, no two of them adjacent."""
    y, x = np.mgrid[:SIZE, :SIZE]
    rank = hash01(21, x, y)
    around = [np.roll(rank, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
    return ((rank < 1 / 80) & (rank < np.min(around, 0))).astype(np.float64)


def make():
    return {"cliffs_height": unorm16(cliffs()), "needles_height": unorm16(needles())}
