"""A cobbled street: river stones in relaxed Voronoi cells, domed and worn, set in sand."""

import numpy as np

from image import blur, down, linear, mix, normalise, occlusion, smax, smoothstep, srgb8, unorm8, unorm16
from noise import cell_border, fbm, grid, hash01, perlin, relaxed_points

SIZE, SS, SEED = 512, 2, 0xC0BB
ACROSS, DOWN = 7, 8


def make():
    u, v = grid(SIZE, SS)
    stones = relaxed_points(ACROSS, DOWN, SEED, jitter=1.0, rounds=2)
    wu = u + 0.0075 * fbm(u, v, 10, 3, SEED + 1)
    wv = v + 0.0075 * fbm(u, v, 10, 3, SEED + 2)
    owner, border = cell_border(wu, wv, stones, roundness=0.0105)

    def per_stone(k):
        return hash01(SEED, np.arange(len(stones)), k)[owner]

    def signed(k):
        return 2 * per_stone(k) - 1

    widest = np.zeros(len(stones))
    np.maximum.at(widest, owner.ravel(), border.ravel())
    gap = 0.0055 + 0.0035 * per_stone(0)
    inside = border - gap
    t = np.clip(inside / (widest[owner] - gap), 0, 1)

    # A dome over the cell: steep at the rim, worn flat on top; its own height, lean and lumps.
    fullness = 2.0 + 0.9 * per_stone(1)
    dome = (1 - (1 - t) ** fullness) ** (1 / 1.75)
    bump = stones[owner]
    dx, dy = (wu - bump[..., 0] + 0.5) % 1 - 0.5, (wv - bump[..., 1] + 0.5) % 1 - 0.5
    lean = 9 * (0.22 * signed(2) * dx + 0.22 * signed(3) * dy)
    lumps = fbm(u, v, 16, 3, SEED + 3)
    grain = fbm(u, v, 72, 3, SEED + 4, 0.65)
    pocks = smoothstep(0.40, 0.72, fbm(u, v, 48, 2, SEED + 5)) * per_stone(4)
    top = 0.70 + 0.13 * signed(5)
    stone = (0.10 + (top + 0.10 * lumps + lean * t) * dome) + dome * (0.016 * grain - 0.045 * pocks)
    stone = stone - 10.0 * np.maximum(-inside, 0)

    # Sand with grit: a second, fine set of cells makes pebbles where the noise lets them lie.
    sand = fbm(u, v, 96, 2, SEED + 6, 0.8)
    drift = fbm(u, v, 9, 3, SEED + 7)
    pebbles = relaxed_points(27, 27, SEED + 8, jitter=1.0, rounds=1)
    which, rim = cell_border(u, v, pebbles, roundness=0.0028, reach=0.11)
    keep = hash01(SEED + 9, which) > 0.45
    grit = np.where(keep, np.sqrt(np.clip(rim / 0.014, 0, 1)), 0) * (0.5 + 0.5 * hash01(SEED + 10, which))
    bed = 0.13 + 0.055 * drift + 0.022 * sand + 0.080 * grit
    is_stone = smoothstep(-0.04, 0.05, stone - bed)
    height = normalise(blur(down(smax(stone, bed, 0.07), SS), 0.8))

    # Colour: granites, basalts, sandstones; specks inside, a pale worn crown, damp dark feet, moss in the joints.
    tint = np.stack([linear(c) for c in ("#8d8a86", "#77787c", "#9a9084", "#6a6a70", "#a39a8c", "#8a7d74", "#7f8588", "#94857a")])
    pick = np.floor(per_stone(10) * len(tint)).astype(np.int64)
    rgb = mix(tint[pick], tint[(pick + 3) % len(tint)], (0.6 * per_stone(11))[..., None])
    rgb = rgb * (1 + 0.22 * signed(12) + 0.18 * lumps)[..., None]
    specks = perlin(u, v, 128, SEED + 11)
    rgb = rgb * (1 + (0.10 + 0.26 * per_stone(13)) * specks + 0.14 * grain)[..., None]
    veins = smoothstep(0.030, 0.0, np.abs(fbm(wu, wv, 11, 3, SEED + 12))) * smoothstep(0.82, 0.95, per_stone(14))
    rgb = mix(rgb, linear("#d8d2c6"), (0.55 * veins)[..., None])
    rgb = mix(rgb, linear("#b9b2a6"), (0.22 * smoothstep(0.75, 1.0, t))[..., None])
    rgb = rgb * mix(0.62, 1.0, smoothstep(0.0, 0.45, t))[..., None]
    ground = linear("#8a7558") * (1 + 0.30 * sand + 0.22 * drift)[..., None]
    pebble = mix(linear("#6d6458"), linear("#b0a48f"), hash01(SEED + 13, which)[..., None])
    ground = mix(ground, pebble, (0.8 * smoothstep(0.1, 0.5, grit))[..., None])
    green = smoothstep(0.02, 0.45, fbm(u, v, 5, 4, SEED + 14) + 0.15 * sand)
    ground = mix(ground, linear("#4f5a2c") * (1 + 0.35 * sand)[..., None], (0.72 * green)[..., None])
    rgb = mix(ground, rgb, is_stone[..., None])
    rough = mix(0.95 + 0 * u, 0.62 - 0.14 * smoothstep(0.7, 1.0, t) + 0.08 * grain + 0.10 * signed(15), is_stone)

    return {
        "cobbles_height": unorm16(height),
        "cobbles_albedo": srgb8(down(rgb, SS)),
        "cobbles_orm": unorm8(occlusion(height, 0.07), down(rough, SS), 0 * height),
    }
