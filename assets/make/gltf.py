"""A small glTF 2.0 writer: one scene, one buffer, textures by relative URI."""

import json
import math
import os

import numpy as np

REPEAT, MIRROR, CLAMP = 10497, 33648, 33071  # wrap modes


def look_at(eye, target, up=(0.0, 1.0, 0.0)):
    """The quaternion (x, y, z, w) that turns -Z from eye to target."""
    z = np.subtract(eye, target).astype(np.float64)
    z /= np.linalg.norm(z)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    m = np.stack([x, np.cross(z, x), z], 1)
    q = np.empty(4)
    k = int(np.argmax([m[0, 0], m[1, 1], m[2, 2], m.trace()]))
    if k == 3:
        q[:] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1 + m.trace()
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        q[k], q[i], q[j] = 1 + m[k, k] - m[i, i] - m[j, j], m[i, k] + m[k, i], m[j, k] + m[k, j]
        q[3] = m[j, i] - m[i, j]
    q /= np.linalg.norm(q)
    return tidy(q if q[3] >= 0 else -q)


def turn(axis, degrees):
    a = math.radians(degrees) / 2
    axis = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    return tidy([*(axis * math.sin(a)), math.cos(a)])


def tidy(values):
    return [float("%.9g" % (v + 0.0)) for v in values]


class Scene:
    def __init__(self, name, model=None):
        """`model`: another scene of the same mesh, whose buffer file serves both."""
        self.name = name
        self.model = model or name
        self.bytes = bytearray()
        self.doc = {
            "asset": {"version": "2.0", "generator": "Prism Shell assets/make"},
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": []}},
            "scene": 0,
            "scenes": [{"name": name, "nodes": []}],
        }

    def add(self, kind, item):
        items = self.doc.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def node(self, **node):
        self.doc["scenes"][0]["nodes"].append(self.add("nodes", node))

    # Geometry.

    def accessor(self, array, kind, target, bounds=False):
        component = {"float32": 5126, "uint16": 5123}[str(array.dtype)]
        while len(self.bytes) % 4:
            self.bytes.append(0)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": array.nbytes, "target": target})
        self.bytes += array.tobytes()
        accessor = {"bufferView": view, "componentType": component, "count": len(array), "type": kind}
        if bounds:
            accessor["min"], accessor["max"] = ([float(x) for x in f(array, 0)] for f in (np.min, np.max))
        return self.add("accessors", accessor)

    def geometry(self, mesh):
        """Attributes and indices, to be shared by several meshes."""
        position, normal, uv, index = mesh
        used, index = np.unique(np.asarray(index).ravel(), return_inverse=True)
        position, normal, uv = ((np.asarray(a)[used] + 0.0).astype("<f4") for a in (position, normal, uv))
        assert index.max() < len(position) <= 65535
        return {
            "attributes": {
                "POSITION": self.accessor(position, "VEC3", 34962, True),
                "NORMAL": self.accessor(normal, "VEC3", 34962),
                "TEXCOORD_0": self.accessor(uv, "VEC2", 34962),
            },
            "indices": self.accessor(index.astype("<u2"), "SCALAR", 34963),
        }

    def mesh(self, name, geometry, material, *more):
        """`more`: further primitives, as pairs of geometry and material."""
        primitives = [{**g, "material": m} for g, m in ((geometry, material), *more)]
        return self.add("meshes", {"name": name, "primitives": primitives})

    # Materials.

    def texture(self, file, wrap):
        sampler = {"magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap}
        samplers = self.doc.setdefault("samplers", [])
        if sampler not in samplers:
            samplers.append(sampler)
        image = self.add("images", {"name": os.path.splitext(file)[0], "uri": "maps/" + file})
        return self.add("textures", {"name": os.path.splitext(file)[0], "sampler": samplers.index(sampler), "source": image})

    def displaced(self, maps, scale, midlevel, tiling=None, wrap=REPEAT, orm=True, roughness=1.0, double_sided=False):
        """A material of the maps `maps`_albedo, _orm and _height, with the displacement request of the engine."""

        def info(kind):
            t = {"index": self.texture("%s_%s.png" % (maps, kind), wrap), "texCoord": 0}
            if tiling:
                t["extensions"] = {"KHR_texture_transform": {"scale": list(tiling)}}
                if "KHR_texture_transform" not in self.doc["extensionsUsed"]:
                    self.doc["extensionsUsed"].append("KHR_texture_transform")
            return t

        pbr = {"baseColorTexture": info("albedo"), "metallicFactor": 0.0, "roughnessFactor": roughness}
        material = {"name": maps, "pbrMetallicRoughness": pbr}
        if orm:
            pbr["metallicRoughnessTexture"] = info("orm")
            material["occlusionTexture"] = dict(pbr["metallicRoughnessTexture"])
        if double_sided:
            material["doubleSided"] = True
        material["extras"] = {
            "displacement": {"texture": info("height"), "scale": scale, "relative": False, "midlevel": midlevel, "border": "open"}
        }
        return self.add("materials", material)

    def bare(self, name, linear_rgb, scale, midlevel, wrap=REPEAT, border="open"):
        """A material of one colour and the height map `name`_height: what only the shape is looked at for."""
        material = self.plain(name, linear_rgb, 0.8)
        texture = {"index": self.texture("%s_height.png" % name, wrap), "texCoord": 0}
        request = {"texture": texture, "scale": scale, "relative": False, "midlevel": midlevel, "border": border}
        self.doc["materials"][material]["extras"] = {"displacement": request}
        return material

    def procedural(self, name, linear_rgb, roughness, scale, midlevel, border="open"):
        """A material of one colour whose heights are the engine's function `name`."""
        material = self.plain(name, linear_rgb, roughness)
        request = {"procedural": name, "scale": scale, "relative": False, "midlevel": midlevel, "border": border}
        self.doc["materials"][material]["extras"] = {"displacement": request}
        return material

    def plain(self, name, linear_rgb, roughness):
        pbr = {"baseColorFactor": tidy([*np.round(linear_rgb, 4), 1.0]), "metallicFactor": 0.0, "roughnessFactor": roughness}
        return self.add("materials", {"name": name, "pbrMetallicRoughness": pbr})

    # Camera and light.

    def camera(self, eye, target, fov_degrees, near=0.05, far=100.0):
        perspective = {"aspectRatio": 16 / 9, "yfov": tidy([math.radians(fov_degrees)])[0], "znear": near, "zfar": far}
        camera = self.add("cameras", {"type": "perspective", "perspective": perspective})
        self.node(name="camera", camera=camera, translation=list(eye), rotation=look_at(eye, target))

    def sun(self, towards, intensity=3.0, colour=(1.0, 0.96, 0.90)):
        """A directional light that shines from the direction `towards` onto the origin."""
        lights = self.doc["extensions"]["KHR_lights_punctual"]["lights"]
        lights.append({"type": "directional", "name": "sun", "intensity": intensity, "color": list(colour)})
        light = {"KHR_lights_punctual": {"light": len(lights) - 1}}
        self.node(name="sun", rotation=look_at(towards, (0, 0, 0)), extensions=light)

    def write(self, folder):
        uri = "models/%s.bin" % self.model
        self.doc["buffers"] = [{"uri": uri, "byteLength": len(self.bytes)}]
        order = ["asset", "extensionsUsed", "extensions", "scene", "scenes", "nodes", "cameras", "meshes", "materials"]
        order += ["textures", "images", "samplers", "accessors", "bufferViews", "buffers"]
        doc = {k: self.doc[k] for k in order if k in self.doc}
        with open(os.path.join(folder, uri), "wb") as f:
            f.write(self.bytes)
        with open(os.path.join(folder, self.name + ".gltf"), "w", newline="\n") as f:
            json.dump(doc, f, indent=1)
            f.write("\n")
