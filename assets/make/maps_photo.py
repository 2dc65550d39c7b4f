"""The CC0 photographs of bricks and grass that the scikit-image wheel carries: coloured by a ramp, and heights invented for
them. A photograph in grey has neither colours nor heights; both are guesses from its tone."""

import importlib.util
import os

import numpy as np
from PIL import Image

from image import blur, down, linear, normalise, srgb8, unorm16

# Tone (sRGB, 0 to 1) and the colour given to it; in between, linear light is interpolated.
BRICK = [(0.15, "#3b1a12"), (0.30, "#8c4a34"), (0.42, "#a8644a"), (0.62, "#b9b0a2"), (0.85, "#d8d2c6")]
GRASS = [(0.05, "#10180a"), (0.35, "#31511c"), (0.60, "#6c8f35"), (0.80, "#b3b96a"), (1.00, "#e4dfb4")]


def photograph(name):
    """Its tone. The package is found but not imported: only the file is wanted."""
    package = importlib.util.find_spec("skimage").submodule_search_locations[0]
    tone = np.asarray(Image.open(os.path.join(package, "data", name + ".png")))
    assert tone.shape == (512, 512) and tone.dtype == np.uint8
    return tone / 255.0


def ramp(tone, stops):
    colours = np.stack([linear(c) for _, c in stops])
    at = [s for s, _ in stops]
    return srgb8(np.stack([np.interp(tone, at, colours[:, k]) for k in range(3)], -1))


def band(tone, fine, coarse):
    """What is larger than `fine` and smaller than `coarse` texels. Mirrored beyond the edges, as the scene's sampler does."""
    n = tone.shape[0]
    p = np.pad(tone, n // 2, mode="symmetric")
    p = blur(p, fine) - blur(p, coarse)
    return p[n // 2 : -(n // 2), n // 2 : -(n // 2)]


def heights(signal, share):
    """To 0..1 with `share` of the texels cut off at each end, at half the photograph's size: nothing finer is left."""
    low, high = np.quantile(signal, [share, 1 - share])
    return unorm16(normalise(down(np.clip(signal, low, high), 2)))


def make():
    brick, grass = photograph("brick"), photograph("grass")
    return {
        "photo_brick_albedo": ramp(brick, BRICK),
        # The mortar is lighter than the bricks, and lower.
        "photo_brick_height": heights(-band(brick, 1.5, 40), 0.02),
        "photo_grass_albedo": ramp(grass, GRASS),
        # What lies on top catches the light.
        "photo_grass_height": heights(band(grass, 1.5, 24), 0.005),
    }
