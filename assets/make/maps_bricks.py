"""An old brick wall in running bond: 4 bricks by 12 courses a tile, raked mortar, no two bricks alike."""

import numpy as np

from image import blur, down, linear, mix, normalise, occlusion, smax, smoothstep, srgb8, unorm8, unorm16
from noise import fbm, grid, hash01

SIZE, SS, SEED = 512, 3, 0xB71C
ACROSS, COURSES = 4, 12


def make():
    u, v = grid(SIZE, SS)

    # Lengths in brick-course heights: a tile is 12 x 12, a brick's pitch 3 x 1.
    warp = 0.030
    x = COURSES * u + warp * (fbm(u, v, 8, 2, SEED + 1) + 0.55 * fbm(u, v, 40, 3, SEED + 2))
    y = COURSES * v + warp * (fbm(u, v, 8, 2, SEED + 3) + 0.55 * fbm(u, v, 40, 3, SEED + 4))
    pitch = COURSES / ACROSS
    row = np.floor(y).astype(np.int64)
    shift = 0.5 * (row % 2)
    col = np.floor(x / pitch + shift).astype(np.int64)
    px = x - (col + 0.5 - shift) * pitch
    py = y - (row + 0.5)
    row, col = row % COURSES, col % ACROSS

    def per_brick(k):
        return hash01(SEED, col, row, k)

    def signed(k):
        return 2 * per_brick(k) - 1

    # The outline: a rounded box, a little turned and moved, with chipped edges.
    turn = 0.010 * signed(0)
    qx = px + turn * py - 0.022 * signed(1)
    qy = py - turn * px - 0.018 * signed(2)
    half_x = 0.5 * pitch - 0.085 - 0.020 * per_brick(3)
    half_y = 0.5 - 0.080 - 0.016 * per_brick(4)
    corner = 0.10 + 0.08 * per_brick(5)
    bx, by = np.abs(qx) - half_x + corner, np.abs(qy) - half_y + corner
    inside = -(np.hypot(np.maximum(bx, 0), np.maximum(by, 0)) + np.minimum(np.maximum(bx, by), 0) - corner)
    chips = smoothstep(0.25, 0.75, fbm(u, v, 20, 3, SEED + 5)) * (0.35 + 0.65 * per_brick(6))
    inside = inside - 0.10 * chips

    # The face: its own level and tilt, sanded grain, drag marks along it, pits.
    radius = 0.13 + 0.05 * per_brick(7)
    t = np.clip(inside / radius, 0, 1)
    edge = 1 - np.sqrt(np.clip(1 - (1 - t) ** 2, 0, 1))
    level = 0.80 + 0.085 * signed(8) + 0.035 * signed(9) * qx / half_x + 0.045 * signed(10) * qy / half_y
    grain = fbm(u, v, 64, 3, SEED + 6, 0.7)
    lumps = fbm(u, v, 14, 3, SEED + 7)
    drag = fbm(u, v, (16, 96), 2, SEED + 8)
    pits = smoothstep(0.42, 0.68, fbm(u, v, 56, 2, SEED + 9)) * smoothstep(-0.15, 0.35, fbm(u, v, 10, 2, SEED + 10))
    face = level + 0.044 * grain + 0.050 * lumps + 0.022 * drag * per_brick(11) - 0.085 * pits
    brick = face - 0.42 * edge - 2.6 * np.maximum(-inside, 0)

    # The mortar: hollowed between the bricks, sandy, pressed up here and there.
    sand = fbm(u, v, 72, 3, SEED + 11, 0.75)
    mortar = 0.185 + 0.070 * fbm(u, v, 12, 3, SEED + 12) + 0.045 * sand + 0.10 * smoothstep(0.06, -0.02, np.abs(inside + 0.04))
    mortar = mortar + 0.16 * smoothstep(0.25, 0.6, fbm(u, v, 6, 2, SEED + 13))
    is_brick = smoothstep(-0.05, 0.05, brick - mortar)
    height = normalise(blur(down(smax(brick, mortar, 0.06), SS), 0.75))

    # Colour, in linear light: clays by the batch, darker where over-fired, pale bloom, weather from above.
    clay = np.stack([linear(c) for c in ("#9c5540", "#8c4634", "#a9664b", "#834338", "#9d5d48", "#754138", "#b07659")])
    pick = np.floor(per_brick(20) * len(clay)).astype(np.int64)
    rgb = mix(clay[pick], clay[(pick + 2) % len(clay)], (0.5 * per_brick(21))[..., None])
    rgb = rgb * (1 + 0.20 * signed(22) + 0.16 * lumps + 0.22 * grain + 0.12 * drag)[..., None]
    fired = smoothstep(0.78, 0.95, per_brick(23)) * smoothstep(-0.3, 0.5, fbm(u, v, 9, 3, SEED + 14) + 0.35 * signed(24))
    rgb = mix(rgb, linear("#4a3230"), (0.75 * fired)[..., None])
    bloom = smoothstep(0.12, 0.62, fbm(u, v, 7, 4, SEED + 15))
    rgb = mix(rgb, linear("#cdb7a3"), (0.26 * bloom)[..., None])
    rgb = mix(rgb, linear("#5a2f25"), (0.45 * pits)[..., None])
    rgb = mix(rgb, linear("#c08a6a"), (0.30 * smoothstep(0.0, 0.4, edge) * (1 - chips * 0.5))[..., None])
    joint = linear("#b3a892") * (1 + 0.22 * sand + 0.16 * fbm(u, v, 18, 3, SEED + 16))[..., None]
    joint = mix(joint, linear("#6f6a58"), (0.6 * smoothstep(0.0, 0.6, fbm(u, v, 5, 3, SEED + 17)))[..., None])
    rgb = mix(joint, rgb, is_brick[..., None])
    soot = smoothstep(0.05, 0.65, fbm(u, v, 3, 4, SEED + 18))
    rgb = rgb * (1 - 0.22 * soot)[..., None]
    rough = mix(0.95 + 0 * u, 0.80 - 0.10 * fired + 0.07 * grain + 0.08 * bloom, is_brick)

    return {
        "bricks_height": unorm16(height),
        "bricks_albedo": srgb8(down(rgb, SS)),
        "bricks_orm": unorm8(occlusion(height, 0.05), down(rough, SS), 0 * height),
    }
