"""The hard scenes: where tracing in a shell loses its digits, its rays or its way."""

import math

import numpy as np

import shapes
from gltf import MIRROR, Scene
from image import linear

FAR = (12000.0, 0.0, -16000.0)  # 20 km


def stage(name, eye, target, fov, sun, model=None, near=0.05):
    s = Scene("stability_" + name, model)
    s.camera(eye, target, fov, near)
    s.sun(sun)
    return s


def cliffs():
    """Two triangles seen at 2 degrees, cliffs one texel wide, the borders closed by walls."""
    distance, angle = 3.0, math.radians(2)
    s = stage("cliffs", (0.0, distance * math.sin(angle), distance * math.cos(angle)), (0.0, -0.02, 0.0), 7, (-0.6, 0.5, 0.4))
    clay = s.bare("cliffs", linear("#b08a5e"), 0.08, 1.0, border="wall")
    sheet = s.geometry(shapes.sheet((0, 0, 0), (1, 0, 0), (0, 0, 1), (2, 2)))
    s.node(name="sheet", mesh=s.mesh("sheet", sheet, clay))
    return s


def needles():
    """Lone needles, one texel wide, on a coarse torus: most stand before the background somewhere."""
    s = stage("needles", (1.7, 2.2, 2.9), (0.0, 0.0, 0.0), 38, (-0.7, 0.8, 0.6))
    steel = s.bare("needles", linear("#8d99a6"), 0.3, 0.0)
    s.node(name="torus", mesh=s.mesh("torus", s.geometry(shapes.torus(around=24, along=12, repeat=(3, 1))), steel))
    return s


def slivers():
    """An arch of triangles 300 times as long as they are wide, seen across and along them."""
    s = stage("slivers", (1.3, 1.7, 2.2), (0.0, 0.5, 0.1), 36, (-0.7, 0.8, 0.3))
    stone = s.displaced("cobbles", 0.08, 0.5)
    s.node(name="arch", mesh=s.mesh("arch", s.geometry(shapes.arch()), stone))
    return s


def seams():
    """Mirrored UVs and seams that disagree on the height along every edge; the first octant is not displaced at all."""
    s = stage("seams", (-0.7, 1.3, 2.7), (0.0, 0.0, 0.0), 47, (-0.7, 0.8, 0.6))
    p, n, t, triangles = shapes.patches()
    rough = s.bare("cliffs", linear("#7c8f6a"), 0.25, 0.5, wrap=MIRROR)
    smooth = s.plain("smooth", linear("#c9c2b2"), 0.5)
    split = len(triangles) - 4
    parts = [(s.geometry((p, n, t, triangles[:split])), rough), (s.geometry((p, n, t, triangles[split:])), smooth)]
    s.node(name="patches", mesh=s.mesh("patches", *parts[0], *parts[1:]))
    return s


def far():
    """The torus, 20 km from the origin, and the camera with it."""
    place = np.array(FAR)
    s = stage("far", place + (1.6, 2.05, 2.9), place + (0.0, -0.2, 0.0), 36, (-0.75, 0.85, 0.6), model="torus")
    cobbles = s.displaced("cobbles", 0.08, 0.5)
    s.node(name="torus", mesh=s.mesh("torus", s.geometry(shapes.torus()), cobbles), translation=list(FAR))
    return s


def inside():
    """The camera inside the shell, in a valley of the torus."""
    s = stage("inside", (0.0, 0.35, 1.27), (0.7, 0.35, 1.05), 75, (-0.3, 0.9, 0.2), near=0.005)
    rock = s.displaced("rock", 0.3, 0.5)
    s.node(name="torus", mesh=s.mesh("torus", s.geometry(shapes.torus(around=24, along=12)), rock))
    return s


def make():
    return [cliffs(), needles(), slivers(), seams(), far(), inside()]
