"""A coarse plain weave, 16 by 16 threads a tile: round twisted yarns that pass over and under."""

import numpy as np

from image import blur, down, linear, mix, normalise, occlusion, smax, smoothstep, srgb8, unorm8, unorm16
from noise import fbm, grid, hash01, perlin

SIZE, SS, SEED = 512, 2, 0xC107
THREADS = 16


def yarns(along, across, u, v, seed, phase):
    """One set of yarns, straight but for a little wander: height, and what colours it."""
    a = across + 0.004 * fbm(u, v, 6, 2, seed + 1)
    x = THREADS * a
    i = np.floor(x).astype(np.int64)
    f = 2 * (x - i) - 1
    i %= THREADS
    width = 0.91 + 0.06 * (2 * hash01(seed, i, 0) - 1) + 0.05 * perlin(along, across, (12, THREADS), seed + 2)
    q = f / width
    body = np.sqrt(np.clip(1 - np.minimum(np.abs(q), 1) ** 2.5, 0, 1))
    swing = np.cos(np.pi * (THREADS * along - 0.5)) * np.where((i + phase) % 2 == 0, 1.0, -1.0)
    swing = np.sign(swing) * np.abs(swing) ** 0.8
    # Two plies twisted about each other, and loose fibres that follow the twist.
    twist = 0.5 + 0.5 * np.cos(2 * np.pi * (2 * THREADS * along + 0.55 * f + hash01(seed, i, 1)))
    fibre = fbm(along + 0.35 * f / THREADS, across, (40, 160), 2, seed + 3, 0.7)
    h = 0.5 + 0.135 * swing + 0.30 * (body - 1) + 0.040 * (twist - 0.5) * body + 0.045 * fibre * body
    h = h - 0.5 * np.maximum(np.abs(q) - 1, 0)
    return h, i, twist, fibre, body


def make():
    u, v = grid(SIZE, SS)
    warp, wi, wt, wf, wb = yarns(v, u, u, v, SEED, 0)
    weft, fi, ft, ff, fb = yarns(u, v, u, v, SEED + 50, 1)
    cloth = smax(warp, weft, 0.035)
    cloth = smax(cloth, 0 * cloth + np.quantile(cloth, 0.02), 0.06)  # the holes between four yarns have a floor
    height = normalise(blur(down(cloth, SS), 1.0))

    over = smoothstep(-0.02, 0.02, warp - weft)

    def dye(a, b, number, seed, twist, fibre, body):
        c = mix(linear(a), linear(b), hash01(seed, number, 7)[..., None])
        return c * (0.62 + 0.38 * body + 0.14 * (twist - 0.5) + 0.42 * fibre)[..., None]

    rgb = mix(dye("#b39468", "#c7ab7c", fi, SEED + 50, ft, ff, fb), dye("#9a7b54", "#b09268", wi, SEED, wt, wf, wb), over[..., None])
    rgb = rgb * (1 + 0.12 * fbm(u, v, 5, 3, SEED + 90))[..., None]
    rough = 0.90 + 0.06 * fbm(u, v, 48, 2, SEED + 91)
    return {
        "cloth_height": unorm16(height),
        "cloth_albedo": srgb8(down(rgb, SS)),
        "cloth_orm": unorm8(occlusion(height, 0.03), down(rough, SS), 0 * height),
    }
