"""A weathered rock face: tilted beds of unlike hardness, ridges over them, cracked into blocks."""

import numpy as np

from image import blur, down, linear, mix, normalise, occlusion, smax, smin, smoothstep, srgb8, unorm8, unorm16
from noise import cell_border, fbm, grid, hash01, perlin, relaxed_points, ridged

SIZE, SS, SEED = 512, 2, 0x70CC
BEDS = 11


def make():
    u, v = grid(SIZE, SS)
    wu = u + 0.060 * fbm(u, v, 4, 5, SEED + 1, 0.55)
    wv = v + 0.060 * fbm(u, v, 4, 5, SEED + 2, 0.55)

    # Beds: folded, never level, and still periodic in both axes.
    fold = 0.045 * np.sin(2 * np.pi * (u + 0.12 * fbm(u, v, 2, 2, SEED + 19)))
    s = BEDS * (v + fold + 0.070 * fbm(u, v, 2, 4, SEED + 3)) + 0.22 * fbm(u, v, 9, 4, SEED + 4, 0.6)
    bed = np.floor(s).astype(np.int64)
    f = s - bed
    bed %= BEDS

    def level(b):
        return hash01(SEED + 5, b % BEDS)

    bench = mix(level(bed), level(bed + 1), smoothstep(0.80, 0.98, f)) + 0.22 * f * (1 - smoothstep(0.86, 0.99, f))

    # Blocks: two generations of cracks; each block stands at its own height and leans.
    big = relaxed_points(3, 6, SEED + 6, jitter=1.5, rounds=0)
    own, gap = cell_border(wu, wv + fold, big, reach=1.0)
    small = relaxed_points(7, 12, SEED + 7, jitter=1.5, rounds=0)
    own2, gap2 = cell_border(wu + 0.02 * fbm(u, v, 12, 3, SEED + 8), wv + 0.02 * fbm(u, v, 12, 3, SEED + 9), small)
    here = smoothstep(-0.10, 0.30, fbm(u, v, 4, 2, SEED + 10))
    open_here = smoothstep(-0.22, 0.30, fbm(u, v, 5, 3, SEED + 11))
    crack = (1 - smoothstep(0, 0.003 + 0.009 * open_here, gap)) * open_here
    crack2 = (1 - smoothstep(0, 0.006, gap2)) * here
    step = smoothstep(0.0, 0.016, gap) * hash01(SEED + 12, own) + 0.45 * smoothstep(0.0, 0.010, gap2) * hash01(SEED + 13, own2) * here

    relief = fbm(wu, wv, 2, 3, SEED + 14)
    crest = ridged(wu, wv, 4, 5, SEED + 15, 0.55)
    rubble = fbm(u, v, 24, 4, SEED + 16, 0.62)
    grain = fbm(u, v, 96, 2, SEED + 17, 0.8)
    chips = np.abs(fbm(wu, wv, 18, 3, SEED + 18))
    h = (
        0.55
        + 0.20 * relief
        + 0.26 * bench
        + 0.34 * (crest - 0.4)
        + 0.17 * step
        + 0.085 * rubble
        - 0.10 * chips
        + 0.020 * grain
        - 0.24 * crack
        - 0.10 * crack2
    )
    low, high = np.quantile(h, (0.002, 0.998))
    h = smin(smax(h, 0 * h + low, 0.06), 0 * h + high, 0.06)
    height = normalise(blur(down(h, SS), 0.95))

    # Colour: each bed its own grey or ochre, iron stains down the beds, lichen on what stands out.
    tone = np.stack([linear(c) for c in ("#86817b", "#75706c", "#948c80", "#7f7a75", "#9f9788", "#6b6866", "#8d857a")])
    pick = np.floor(hash01(SEED + 20, bed) * len(tone)).astype(np.int64)
    after = np.floor(hash01(SEED + 20, (bed + 1) % BEDS) * len(tone)).astype(np.int64)
    rgb = mix(tone[pick], tone[after], smoothstep(0.80, 0.98, f)[..., None])
    bands = perlin(u, v, 16, SEED + 21) * 0.15 + np.sin(2 * np.pi * (3 * s + 0.8 * fbm(u, v, 8, 3, SEED + 22)))
    rgb = rgb * (1 + 0.07 * bands + 0.22 * rubble + 0.16 * grain + 0.10 * (hash01(SEED + 23, own) - 0.5))[..., None]
    rust = smoothstep(0.08, 0.55, fbm(wu, wv, 4, 4, SEED + 24)) * (0.6 + 0.4 * smoothstep(0.3, 0.9, f))
    rgb = mix(rgb, linear("#9a6a42") * (1 + 0.3 * rubble)[..., None], (0.50 * rust)[..., None])
    lichen = smoothstep(0.28, 0.50, fbm(u, v, 9, 4, SEED + 25, 0.6) + 0.25 * relief) * smoothstep(0.3, 0.6, h)
    rgb = mix(rgb, mix(linear("#a9ad86"), linear("#c3bd94"), smoothstep(-0.3, 0.3, rubble)[..., None]), (0.40 * lichen)[..., None])
    rgb = rgb * (1 - 0.55 * np.clip(crack + 0.7 * crack2, 0, 1))[..., None]
    rgb = rgb * mix(0.80, 1.06, smoothstep(low, high, h))[..., None]
    rough = 0.86 + 0.07 * grain + 0.08 * lichen - 0.10 * smoothstep(0.5, 1.0, bench)

    return {
        "rock_height": unorm16(height),
        "rock_albedo": srgb8(down(rgb, SS)),
        "rock_orm": unorm8(occlusion(height, 0.10), down(rough, SS), 0 * height),
    }
