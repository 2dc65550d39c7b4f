"""The scenes: what stands where, with which map, seen from where."""

import maps_terrain
import shapes
from gltf import CLAMP, MIRROR, Scene, turn
from image import linear

EXAGGERATION = 4.0  # of the terrain's heights


def one(name, mesh, material, eye, target, fov, sun):
    s = Scene(name)
    s.node(name=name, mesh=s.mesh(name, s.geometry(mesh), s.displaced(**material)))
    s.camera(eye, target, fov)
    s.sun(sun)
    return s


def prism_shell():
    """A cobbled ring, sunk into a brick floor; a plain ball fills the ring, two more lie in the floor."""
    s = Scene("prism_shell")
    bricks = s.displaced("bricks", 0.08, 1.0)
    cobbles = s.displaced("cobbles", 0.10, 0.5)
    teal = s.plain("teal glaze", linear("#1d6b73"), 0.28)
    amber = s.plain("amber glaze", linear("#c98a2b"), 0.32)
    ivory = s.plain("ivory", linear("#d9d2c3"), 0.45)
    ball = s.geometry(shapes.sphere())
    floor = s.geometry(shapes.sheet((0, 0, 0), (4.0, 0, 0), (0, 0, 4.0), (4, 4)))
    ring = s.geometry(shapes.torus())
    s.node(name="floor", mesh=s.mesh("floor", floor, bricks))
    s.node(name="ring", mesh=s.mesh("ring", ring, cobbles), translation=[0.0, 1.22, 0.0], rotation=turn((1, 0, 0), 62))
    s.node(name="ball in the ring", mesh=s.mesh("teal ball", ball, teal), translation=[0.05, 1.24, 0.02], scale=[0.70] * 3)
    s.node(name="amber ball", mesh=s.mesh("amber ball", ball, amber), translation=[1.42, 0.20, 0.92], scale=[0.36] * 3)
    s.node(name="ivory ball", mesh=s.mesh("ivory ball", ball, ivory), translation=[-1.22, 0.10, 0.98], scale=[0.26] * 3)
    s.camera((1.6, 2.45, 5.1), (0.04, 1.0, 0.0), 36)
    s.sun((-0.75, 0.95, 0.62))
    return s


def procedural():
    """A brick well on cobbles, with water in it and a ball afloat: every height is a function."""
    s = Scene("procedural")
    bricks = s.procedural("bricks", linear("#a0543a"), 0.8, 0.03, 1.0)
    cobbles = s.procedural("cobbles", linear("#8d8578"), 0.7, 0.06, 1.0)
    waves = s.procedural("waves", linear("#1d5a63"), 0.16, 0.055, 0.5)
    amber = s.plain("amber glaze", linear("#c98a2b"), 0.32)
    floor = s.geometry(shapes.sheet((0, 0, 0), (2.2, 0, 0), (0, 0, 2.2), (4, 4)))
    s.node(name="floor", mesh=s.mesh("floor", floor, cobbles))
    s.node(name="well", mesh=s.mesh("well", s.geometry(shapes.well()), bricks))
    water = s.geometry(shapes.disc(0.92, repeat=0.9))
    s.node(name="water", mesh=s.mesh("water", water, waves), translation=[0.0, 0.36, 0.0])
    ball = s.geometry(shapes.sphere(48, 24))
    s.node(name="ball", mesh=s.mesh("ball", ball, amber), translation=[0.22, 0.4, 0.12], scale=[0.24] * 3)
    s.camera((1.35, 1.7, 2.75), (0.0, 0.12, 0.05), 40)
    s.sun((-0.8, 0.75, 0.45))
    return s


def shadows():
    """A cobbled ring leans over a plain floor; it casts on a brick block and on plain balls, and they on it."""
    s = Scene("shadows")
    bricks = s.displaced("bricks", 0.12, 0.5)
    cobbles = s.displaced("cobbles", 0.10, 0.5)
    plaster = s.plain("plaster", linear("#cfc6b4"), 0.9)
    amber = s.plain("amber glaze", linear("#c98a2b"), 0.32)
    ball = s.geometry(shapes.sphere())
    floor = s.geometry(shapes.sheet((0, 0, 0), (4.5, 0, 0), (0, 0, 4.5)))
    ring, block = s.geometry(shapes.torus()), s.geometry(shapes.cube())
    s.node(name="floor", mesh=s.mesh("floor", floor, plaster))
    s.node(name="ring", mesh=s.mesh("ring", ring, cobbles), translation=[-0.55, 1.3, 0.1], rotation=turn((1, 0, 0), 55))
    s.node(name="block", mesh=s.mesh("block", block, bricks), translation=[1.35, 0.5, -0.35], scale=[0.5] * 3)
    s.node(name="ball", mesh=s.mesh("ball", ball, amber), translation=[-0.35, 0.32, 1.05], scale=[0.32] * 3)
    s.node(name="ball in the ring", mesh=s.mesh("small ball", ball, amber), translation=[-0.75, 2.1, 0.75], scale=[0.2] * 3)
    s.camera((1.7, 3.3, 5.9), (0.35, 0.95, 0.1), 36)
    s.sun((-0.9, 0.85, 0.2))
    return s


def self_shadow():
    """A floor of cobbles, two triangles, under a low sun."""
    s = Scene("self_shadow")
    floor = s.geometry(shapes.sheet((0, 0, 0), (1.0, 0, 0), (0, 0, 1.0)))
    s.node(name="cobbles", mesh=s.mesh("cobbles", floor, s.displaced("cobbles", 0.12, 1.0)))
    s.camera((0.0, 1.15, 1.75), (0.0, -0.1, 0.05), 38)
    s.sun((-0.9, 0.28, 0.3))
    return s


def techniques():
    """A cube and a torus: a flat and a curved surface for every technique."""
    s = Scene("techniques")
    cube = s.mesh("cube", s.geometry(shapes.cube()), s.displaced("bricks", 0.12, 0.5))
    torus = s.mesh("torus", s.geometry(shapes.torus()), s.displaced("cobbles", 0.08, 0.5))
    s.node(name="cube", mesh=cube, translation=[-1.25, 0.0, 0.0], rotation=turn((0, 1, 0), 25))
    s.node(name="torus", mesh=torus, translation=[1.5, 0.0, 0.3], rotation=turn((1, 0, 0), 35))
    s.camera((0.2, 2.6, 7.2), (0.2, -0.1, 0.0), 34)
    s.sun((-0.6, 0.9, 0.8))
    return s


def silhouette():
    """Plane, cylinder and sphere in a row."""
    s = Scene("silhouette")
    cobbles = s.displaced("cobbles", 0.08, 0.5)
    dense = s.displaced("cobbles", 0.08, 0.5, tiling=(5, 2.5))
    plane = s.geometry(shapes.sheet((0, 0, 0), (0.8, 0, 0), (0, -0.8, 0), (2, 2)))
    s.node(name="plane", mesh=s.mesh("plane", plane, cobbles), translation=[-1.9, 0.0, 0.0], rotation=turn((0, 1, 0), -50))
    s.node(name="cylinder", mesh=s.mesh("cylinder", s.geometry(shapes.cylinder()), cobbles))
    ball = s.geometry(shapes.sphere(32, 16))
    s.node(name="sphere", mesh=s.mesh("sphere", ball, dense), translation=[1.8, 0.0, 0.0], scale=[0.8] * 3)
    s.camera((0.0, 0.9, 6.2), (0.0, 0.0, 0.0), 30)
    s.sun((-0.6, 0.9, 0.8))
    return s


def depth_offset():
    """Rocks in rippled sand: three with a depth offset, one without."""
    s = Scene("depth_offset")
    sand = s.procedural("waves", linear("#c2a878"), 0.95, 0.05, 1.0)
    bare = s.displaced("rock", 0.0, 0.5, tiling=(2, 1))
    soft = s.displaced("rock", 0.0, 0.5, tiling=(2, 1))
    del s.doc["materials"][bare]["extras"]
    s.doc["materials"][soft]["name"] = "rock in sand"
    s.doc["materials"][soft]["extras"] = {"depthOffset": {"distance": 0.3, "dither": True}}
    floor = s.geometry(shapes.sheet((0, 0, 0), (2.6, 0, 0), (0, 0, 2.6), (5, 5)))
    s.node(name="sand", mesh=s.mesh("sand", floor, sand))
    ball = s.geometry(shapes.sphere(48, 24))
    rock, hard = s.mesh("rock in sand", ball, soft), s.mesh("rock on sand", ball, bare)
    s.node(name="left", mesh=rock, translation=[-0.75, -0.1, 0.2], scale=[0.7, 0.5, 0.6], rotation=turn((0, 1, 0), 20))
    s.node(name="small", mesh=rock, translation=[0.1, -0.05, 0.95], scale=[0.3, 0.25, 0.35], rotation=turn((0, 1, 0), 70))
    s.node(name="far", mesh=rock, translation=[0.3, -0.1, -1.1], scale=[0.55, 0.6, 0.5], rotation=turn((0, 1, 0), 50))
    s.node(name="bare", mesh=hard, translation=[1.0, -0.1, 0.3], scale=[0.6, 0.45, 0.55], rotation=turn((0, 1, 0), 10))
    s.camera((0.3, 1.7, 3.6), (0.1, 0.0, 0.0), 36)
    s.sun((-0.8, 0.7, 0.5))
    return s


def wall():
    """A brick wall that is a function: 6 bricks by 12 courses, two triangles, seen at 60 degrees."""
    s = Scene("wall")
    bricks = s.procedural("bricks", linear("#a0543a"), 0.8, 0.08, 1.0, "wall")
    sheet = s.geometry(shapes.sheet((0, 0, 0), (1.5, 0, 0), (0, -1.0, 0), (1.5, 1.5)))
    s.node(name="wall", mesh=s.mesh("wall", sheet, bricks))
    s.camera((0.0, -6.062, 3.5), (0.0, 0.0, 0.0), 18)
    s.sun((-0.7, -0.25, 0.5))
    return s


def photo():
    """A ball of photographed grass on a pavement of photographed bricks; heights and colours are invented."""
    s = Scene("photo")
    rough = dict(wrap=MIRROR, orm=False, roughness=0.95)
    brick = s.displaced("photo_brick", 0.05, 1.0, **rough)
    grass = s.displaced("photo_grass", 0.08, 0.5, tiling=(2, 1), **rough)
    floor = s.geometry(shapes.sheet((0, 0, 0), (1.9, 0, 0), (0, 0, 1.9)))
    ball = s.geometry(shapes.sphere(32, 16))
    s.node(name="pavement", mesh=s.mesh("pavement", floor, brick))
    s.node(name="ball", mesh=s.mesh("ball", ball, grass), translation=[0.0, 0.72, 0.0], scale=[0.85] * 3, rotation=turn((1, 0, 0), -25))
    s.camera((0.9, 1.7, 4.0), (0.0, 0.5, 0.0), 34)
    s.sun((-0.8, 0.7, 0.5))
    return s


def ground():
    """The elevation model's half extents and the scale of its heights, mesh units: the longer side is 2."""
    width, depth, relief = maps_terrain.extent()
    unit = max(width, depth) / 2
    return width / 2 / unit, depth / 2 / unit, round(EXAGGERATION * relief / unit, 6)


def planet():
    """The elevation model twice: flat on the left, as on `terrain`, and on a patch of a small planet."""
    s = Scene("planet")
    x, z, scale = ground()
    land = s.displaced("terrain", scale, 0.0, wrap=CLAMP, orm=False, roughness=0.95)
    flat = s.geometry(shapes.sheet((0, 0, 0), (x, 0, 0), (0, 0, z), (1, 1), 2, 2))
    patch = s.geometry(shapes.patch(1.6, 2 * x, 2 * z))
    s.node(name="flat", mesh=s.mesh("flat", flat, land), translation=[-2.0, 0.0, 0.0])
    s.node(name="curved", mesh=s.mesh("curved", patch, land), translation=[2.0, 0.0, 0.0])
    s.camera((0.0, 3.0, 6.2), (0.0, -0.1, 0.0), 32, near=0.002)
    s.sun((-0.85, 0.55, -0.15))
    return s


def make():
    x, z, scale = ground()
    flat = shapes.sheet((0, 0, 0), (x, 0, 0), (0, 0, z), (1, 1), 2, 2)
    return [
        wall(),
        photo(),
        planet(),
        prism_shell(),
        procedural(),
        shadows(),
        self_shadow(),
        techniques(),
        silhouette(),
        depth_offset(),
        one("torus", shapes.torus(), dict(maps="cobbles", scale=0.08, midlevel=0.5), (1.6, 2.05, 2.9), (0.0, -0.2, 0), 36, (-0.75, 0.85, 0.6)),
        one(
            "suzanne",
            shapes.suzanne(),
            dict(maps="cobbles", scale=0.05, midlevel=0.5, tiling=(4, 4)),
            (1.1, 0.5, 4.05),
            (0.1, -0.07, 0.1),
            34,
            (-0.6, 0.7, 0.75),
        ),
        one(
            "stack",
            shapes.stack(),
            dict(maps="rock", scale=0.14, midlevel=0.5),
            (1.6, 1.5, 4.6),
            (0, 1.04, 0),
            34,
            (-0.7, 0.6, 0.7),
        ),
        one("cube", shapes.cube(), dict(maps="bricks", scale=0.12, midlevel=0.5), (2.7, 2.2, 4.4), (-0.03, -0.16, 0), 34, (-0.45, 0.9, 0.8)),
        one(
            "cloth",
            shapes.cloth(),
            dict(maps="cloth", scale=0.04, midlevel=0.5, double_sided=True),
            (1.5, 0.7, 3.7),
            (0.13, -0.03, 0),
            36,
            (-0.9, 0.75, 0.6),
        ),
        one(
            "plane",
            shapes.sheet((0, 0, 0), (1, 0, 0), (0, 0, 1)),
            dict(maps="bricks", scale=0.12, midlevel=1.0),
            (1.0, 1.25, 2.3),
            (-0.14, -0.22, 0.12),
            40,
            (-0.8, 0.6, 0.45),
        ),
        one(
            "terrain",
            flat,
            dict(maps="terrain", scale=scale, midlevel=0.0, wrap=CLAMP, orm=False, roughness=0.95),
            (1.0, 1.5, 2.4),
            (-0.09, -0.09, 0.15),
            38,
            (-0.85, 0.55, -0.15),
        ),
    ]
