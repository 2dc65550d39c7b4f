"""Checks the assets as they stand on disk: python check.py [FOLDER]. Exits 1 and lists what is wrong."""

import json
import os
import sys

import numpy as np
from PIL import Image

ASSETS = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIMIT = 12 << 20  # bytes, everything together (the project's limit is 30 MB)
HARD = ("cliffs_height.png", "needles_height.png")
wrong = []


def expect(ok, *what):
    if not ok:
        wrong.append(" ".join(str(w) for w in what))


def check_map(path):
    name = os.path.basename(path)
    with open(path, "rb") as f:
        head = f.read(26)
    depth, colour = head[24], head[25]
    if name.endswith("_height.png"):
        expect((depth, colour) == (16, 0), name, "is not 16-bit grey")
    else:
        expect((depth, colour) == (8, 2), name, "is not 8-bit RGB")
    image = np.asarray(Image.open(path)).astype(np.int64)
    hard = name in HARD  # steps of one texel, and few heights: that is what they are for
    photo = name.startswith("photo_")
    tile = not hard and not photo and not name.startswith("terrain")
    expect(not hard or image.shape == (64, 64), name, image.shape)
    expect(not tile or image.shape[:2] == (512, 512), name, image.shape)
    if name.endswith("_height.png"):
        expect(image.min() == 0 and image.max() == 65535, name, "does not fill the range")
        expect(len(np.unique(image)) > (1 if hard else 5000 if tile or photo else 800), name, "has few values")
    if name.endswith("_orm.png"):
        expect((image[..., 2] == 0).all(), name, "is metallic")
    if tile:
        # A seam would show as differences across the border that the inside does not have.
        for axis in (0, 1):
            steps = np.abs(np.diff(image, axis=axis))
            inside = steps.reshape(*image.shape[:2] - np.eye(2, dtype=int)[axis], -1).mean((1 - axis, 2)).max()
            ends = np.abs(np.take(image, 0, axis) - np.take(image, -1, axis))
            expect(ends.mean() <= inside and ends.max() <= steps.max(), name, "has a seam on axis", axis, ends.mean(), inside)
    if tile and name.endswith("_height.png"):
        # No spikes of a single texel: each one lies near the span of its neighbours.
        around = np.stack([np.roll(image, s, a) for s, a in ((1, 0), (-1, 0), (1, 1), (-1, 1))])
        spike = np.maximum(image - around.max(0), around.min(0) - image).max() / 65535
        expect(spike < 0.03, name, "has a spike of", spike)


def check_scene(path):
    name = os.path.basename(path)
    with open(path) as f:
        g = json.load(f)
    buffers = []
    for b in g["buffers"]:
        with open(os.path.join(ASSETS, b["uri"]), "rb") as f:
            buffers.append(f.read())
        expect(len(buffers[-1]) == b["byteLength"], name, "buffer length")
    for item in g.get("images", []) + g["buffers"]:
        expect(".." not in item["uri"] and os.path.isfile(os.path.join(ASSETS, item["uri"])), name, item["uri"])

    def read(k):
        a = g["accessors"][k]
        v = g["bufferViews"][a["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[a["type"]]
        kind = {5126: "<f4", 5123: "<u2"}[a["componentType"]]
        data = np.frombuffer(buffers[v["buffer"]], kind, a["count"] * width, v["byteOffset"])
        expect(data.nbytes == v["byteLength"], name, "accessor", k, "length")
        data = data.reshape(-1, width)
        if "min" in a:
            expect(a["min"] == data.min(0).tolist() and a["max"] == data.max(0).tolist(), name, "accessor", k, "bounds")
        return data

    triangles = 0
    for mesh in g["meshes"]:
        for prim in mesh["primitives"]:
            position, normal, uv = (read(prim["attributes"][k]).astype(np.float64) for k in ("POSITION", "NORMAL", "TEXCOORD_0"))
            index = read(prim["indices"]).ravel()
            triangles += len(index) // 3
            what = (name, mesh["name"])
            expect("min" in g["accessors"][prim["attributes"]["POSITION"]], *what, "no bounds")
            expect(len(position) == len(normal) == len(uv) and index.max() < len(position), *what, "counts")
            expect(len(np.unique(index)) == len(position), *what, "unused vertices")
            for a in (position, normal, uv):
                expect(np.isfinite(a).all(), *what, "not finite")
                expect(not (np.signbit(a) & (a == 0)).any(), *what, "negative zero (welding is by bits)")
            expect(np.abs(np.linalg.norm(normal, axis=1) - 1).max() < 1e-5, *what, "normals are not unit")
            p = position[index].reshape(-1, 3, 3)
            face = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
            expect((np.linalg.norm(face, axis=1) > 0).all(), *what, "empty triangles")
            agree = np.einsum("ij,ij->i", face, normal[index].reshape(-1, 3, 3).sum(1)) > 0
            if mesh["name"] != "suzanne":
                expect(agree.all(), *what, "wound against its normals")
            # Positions nearly equal but not so to the bit would leave the shell open.
            order = np.unique(position, axis=0)
            near = np.unique(np.round(position, 5), axis=0)
            expect(len(order) == len(near), *what, "seams that do not close to the bit")
            if name == "stability_seams.gltf":
                continue  # its UVs are mirrored on purpose
            # Not mirrored: u to the right and v down, seen from outside.
            t = uv[index].reshape(-1, 3, 2)
            e, f = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
            expect((e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0] <= 0).all(), *what, "mirrored UVs")

    for m in g["materials"]:
        d = m.get("extras", {}).get("displacement")
        if d is None:
            continue
        source = "procedural" if "procedural" in d else "texture"
        expect(sorted(d) == sorted(["border", "midlevel", "relative", "scale", source]), name, m["name"], "displacement keys")
        if source == "procedural":
            expect(d["procedural"] == m["name"] and d["scale"] > 0 and 0 <= d["midlevel"] <= 1, name, m["name"], "displacement")
            continue
        image = g["images"][g["textures"][d["texture"]["index"]]["source"]]["uri"]
        expect(image.endswith("_height.png") and d["scale"] > 0 and 0 <= d["midlevel"] <= 1, name, m["name"], "displacement")
        used = [d["texture"], m["pbrMetallicRoughness"].get("baseColorTexture", d["texture"])]
        expect(len({json.dumps(t.get("extensions")) for t in used}) == 1, name, m["name"], "maps do not lie together")
    expect(len(g.get("cameras", [])) == 1, name, "camera")
    expect([l["type"] for l in g["extensions"]["KHR_lights_punctual"]["lights"]] == ["directional"], name, "light")
    print("%-26s %6d triangles" % (name, triangles))


def main():
    for f in sorted(os.listdir(os.path.join(ASSETS, "maps"))):
        check_map(os.path.join(ASSETS, "maps", f))
    for f in sorted(os.listdir(ASSETS)):
        if f.endswith(".gltf"):
            check_scene(os.path.join(ASSETS, f))
    size = sum(os.path.getsize(os.path.join(d, f)) for d, _, fs in os.walk(ASSETS) for f in fs)
    expect(size < LIMIT, size, "bytes are too many")
    print("check: %.1f MB, %d things wrong" % (size / 1e6, len(wrong)))
    for w in wrong:
        print("  " + w)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
