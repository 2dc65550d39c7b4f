"""Writes suzanne.obj: Blender's own Suzanne, her own UV layout, triangulated, smooth normals, Y up.

She has a fin under the chin, two triangles back to back, and their shared point has no normal (the faces
cancel out): such a corner takes its triangle's normal instead.

Needs the `bpy` wheel (requirements-suzanne.txt) and, on a machine without a desktop, the libraries that
README.md names. make.py does not need it: it reads the .obj that stands in the repository.
"""

import os

import bpy  # first: it makes bmesh importable
import bmesh

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_monkey_add(size=2.0, calc_uvs=True)
mesh = bpy.context.object.data
quads = len(mesh.polygons)

work = bmesh.new()
work.from_mesh(mesh)
bmesh.ops.triangulate(work, faces=work.faces[:], quad_method="BEAUTY", ngon_method="BEAUTY")
work.to_mesh(mesh)
work.free()
mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
mesh.update()

uv = mesh.uv_layers.active.data
here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, "suzanne.obj"), "w", newline="\n") as out:
    out.write("# Blender %s, primitive_monkey_add(size=2, calc_uvs=True), triangulated; Y up. Made by suzanne_bpy.py.\n" % bpy.app.version_string)
    for v in mesh.vertices:
        out.write("v %.9g %.9g %.9g\n" % (v.co.x, v.co.z, -v.co.y))
    normals = [v.normal.copy() for v in mesh.vertices]
    instead = {}
    for face in mesh.polygons:
        for vertex in face.vertices:
            if mesh.vertices[vertex].normal.length < 0.5:
                instead[face.index, vertex] = len(normals)
                normals.append(face.normal.copy())
    for n in normals:
        out.write("vn %.9g %.9g %.9g\n" % (n.x, n.z, -n.y))
    seen = {}
    for loop in uv:
        key = "%.9g %.9g" % (loop.uv.x, loop.uv.y)
        if key not in seen:
            seen[key] = len(seen) + 1
            out.write("vt %s\n" % key)
    for face in mesh.polygons:
        corners = []
        for loop, vertex in zip(face.loop_indices, face.vertices):
            key = "%.9g %.9g" % (uv[loop].uv.x, uv[loop].uv.y)
            corners.append("%d/%d/%d" % (vertex + 1, seen[key], instead.get((face.index, vertex), vertex) + 1))
        out.write("f %s\n" % " ".join(corners))
print("faces before", quads, "triangles", len(mesh.polygons), "vertices", len(mesh.vertices), "corners without a normal", sorted(instead))
