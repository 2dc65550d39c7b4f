"""PNG output, colour, resampling, and what is derived from a height map."""

import struct
import zlib

import numpy as np


def smoothstep(a, b, x):
    t = np.clip((x - a) / (b - a), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def mix(a, b, t):
    return a + (b - a) * t


def smax(a, b, k):
    """Smooth maximum: polynomial, over a band of width k."""
    h = np.clip(0.5 + 0.5 * (a - b) / k, 0, 1)
    return b + (a - b) * h + k * h * (1 - h)


def smin(a, b, k):
    return -smax(-a, -b, k)


def normalise(h):
    """To [0, 1] exactly."""
    return (h - h.min()) / (h.max() - h.min())


def down(a, s):
    """Box filter by s in both axes."""
    n, m = a.shape[0] // s, a.shape[1] // s
    return a.reshape(n, s, m, s, *a.shape[2:]).mean(axis=(1, 3))


def blur(a, sigma):
    """Periodic Gaussian; takes single-texel spikes away and keeps the map tileable."""
    r = int(np.ceil(3 * sigma))
    w = np.exp(-0.5 * (np.arange(-r, r + 1) / sigma) ** 2)
    w /= w.sum()
    for axis in (0, 1):
        a = sum(wi * np.roll(a, i - r, axis) for i, wi in enumerate(w))
    return a


def linear(hex_colour):
    """'#rrggbb' (sRGB) to linear."""
    s = np.array([int(hex_colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)


def srgb8(rgb):
    x = np.clip(rgb, 0, 1)
    s = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.round(s * 255).astype(np.uint8)


def unorm8(*channels):
    return np.round(np.clip(np.stack(channels, -1), 0, 1) * 255).astype(np.uint8)


def unorm16(h):
    return np.round(np.clip(h, 0, 1) * 65535).astype(np.uint16)


def occlusion(h, depth, directions=16, reach=32):
    """Ambient occlusion of a tileable height map: the mean over azimuths of cos² of the horizon's
    elevation. `depth` is the relief's full range as a share of the tile's width."""
    n = h.shape[0]
    z = h * depth * n
    total = np.zeros(h.shape)
    for d in range(directions):
        a = 2 * np.pi * (d + 0.5) / directions
        slope = np.zeros(h.shape)
        r = 1.0
        while r <= reach:
            x, y = int(round(r * np.cos(a))), int(round(r * np.sin(a)))
            if (x, y) != (0, 0):
                slope = np.maximum(slope, (np.roll(z, (-y, -x), (0, 1)) - z) / np.hypot(x, y))
            r *= 1.25
        total += 1 / (1 + slope * slope)
    return total / directions


def write_png(path, pixels):
    """8- or 16-bit, grey or RGB. Own writer, so that 16-bit grey is 16-bit grey and the bytes hang on
    zlib alone. Each row takes the filter with the least sum of absolute residues."""
    depth = 16 if pixels.dtype == np.uint16 else 8
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    height, width = pixels.shape[:2]
    raw = np.ascontiguousarray(pixels.astype(">u2" if depth == 16 else "u1")).view(np.uint8).reshape(height, -1)
    bpp = channels * depth // 8
    x = raw.astype(np.int16)
    left = np.pad(x, ((0, 0), (bpp, 0)))[:, : x.shape[1]]
    up = np.pad(x, ((1, 0), (0, 0)))[:-1]
    corner = np.pad(x, ((1, 0), (bpp, 0)))[:-1, : x.shape[1]]
    p = left + up - corner
    pa, pb, pc = np.abs(p - left), np.abs(p - up), np.abs(p - corner)
    paeth = np.where((pa <= pb) & (pa <= pc), left, np.where(pb <= pc, up, corner))
    rows = np.stack([(x - f) & 255 for f in (0 * x, left, up, (left + up) >> 1, paeth)]).astype(np.uint8)
    best = np.abs(rows.view(np.int8).astype(np.int64)).sum(2).argmin(0)
    data = b"".join(bytes([best[y]]) + rows[best[y], y].tobytes() for y in range(height))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, depth, {1: 0, 3: 2}[channels], 0, 0, 0)
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data, 9)) + chunk(b"IEND", b""))
