"""Rebuilds every asset.   python make.py [--out FOLDER] [--only maps|scenes] [--verify]

--out     where to write (default: assets/, the folder above this one)
--verify  writes to a temporary folder and compares, byte by byte, with what stands in the repository
"""

import argparse
import filecmp
import os
import sys
import tempfile

sys.dont_write_bytecode = True
import image
import maps_bricks
import maps_cloth
import maps_cobbles
import maps_hard
import maps_photo
import maps_rock
import maps_terrain
import scenes
import stability

ASSETS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def build(out, only):
    for folder in ("maps", "models"):
        os.makedirs(os.path.join(out, folder), exist_ok=True)
    if only != "scenes":
        for module in (maps_bricks, maps_cobbles, maps_rock, maps_cloth, maps_terrain, maps_hard, maps_photo):
            for name, pixels in module.make().items():
                image.write_png(os.path.join(out, "maps", name + ".png"), pixels)
                print("maps/%s.png" % name, pixels.shape, pixels.dtype, flush=True)
    if only != "maps":
        for scene in scenes.make() + stability.make():
            scene.write(out)
            print(scene.name + ".gltf", len(scene.bytes), "bytes of mesh", flush=True)


def files(folder):
    found = []
    for sub in ("", "maps", "models"):
        for f in os.listdir(os.path.join(folder, sub)):
            if f.endswith((".png", ".bin", ".gltf")):
                found.append(os.path.join(sub, f))
    return sorted(found)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", default=ASSETS)
    p.add_argument("--only", choices=("maps", "scenes"))
    p.add_argument("--verify", action="store_true")
    args = p.parse_args()
    if not args.verify:
        return build(args.out, args.only)
    with tempfile.TemporaryDirectory() as tmp:
        build(tmp, None)
        if files(tmp) != files(ASSETS):
            sys.exit("make: other files: %s" % sorted(set(files(tmp)) ^ set(files(ASSETS))))
        other = [f for f in files(tmp) if not filecmp.cmp(os.path.join(tmp, f), os.path.join(ASSETS, f), False)]
        if other:
            sys.exit("make: not the same bytes: " + ", ".join(other))
    print("make: all", len(files(ASSETS)), "files repeat to the byte")


if __name__ == "__main__":
    main()
