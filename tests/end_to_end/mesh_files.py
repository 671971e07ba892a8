"""Mesh files of the kinds that modellers write, made by hand: bodies of triangles in nodes with
transforms."""
import base64
import json
import struct
import zipfile
import zlib

import numpy

BOX = numpy.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
FACES = numpy.array([(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3),
                     (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)])


def block(sides):
    """Vertices and triangles, z up, a corner at the origin."""
    return BOX * sides, FACES


def lens(radius, height, around=16):
    """A double cone: another body than a block of the same box."""
    turn = 2 * numpy.pi * numpy.arange(around) / around
    rim = numpy.stack([radius * numpy.cos(turn), radius * numpy.sin(turn), 0 * turn], axis=1)
    vertices = numpy.concatenate([rim, [(0, 0, height / 2), (0, 0, -height / 2)]])
    after = (numpy.arange(around) + 1) % around
    top = numpy.stack([numpy.arange(around), after, numpy.full(around, around)], axis=1)
    bottom = numpy.stack([after, numpy.arange(around), numpy.full(around, around + 1)], axis=1)
    return vertices, numpy.concatenate([top, bottom])


def y_up(vertices):
    """z up as the formats have it whose y is up."""
    return numpy.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=1)


def png(pixels):
    """Bytes of rows of (red, green, blue)."""
    rows = numpy.asarray(pixels, numpy.uint8)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw))
            + chunk(b"IEND", b""))


def gltf(nodes, colour=None, picture=None):
    """A glTF document and the bytes of its buffer.

    nodes: dicts of name, vertices and triangles (z up), and any of translation, rotation, scale, matrix.
    picture: PNG bytes of a base colour texture; (u, v) are the vertices' first two coordinates of 0 to 1.
    """
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
                "meshes": [], "accessors": [], "bufferViews": [], "materials": [{"name": "coat"}]}
    data = b""

    def view(values, target):
        nonlocal data
        data += b"\0" * (-len(data) % 4)
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(data),
                                        "byteLength": len(values), **target})
        data += values
        return len(document["bufferViews"]) - 1

    def accessor(array, kind, component):
        entry = {"bufferView": view(array.tobytes(), {}), "componentType": component,
                 "count": len(array), "type": kind}
        if kind == "VEC3":
            entry.update(min=array.min(axis=0).tolist(), max=array.max(axis=0).tolist())
        document["accessors"].append(entry)
        return len(document["accessors"]) - 1

    if colour:
        document["materials"][0]["pbrMetallicRoughness"] = {"baseColorFactor": [*colour, 1]}
    if picture:
        document["images"] = [{"bufferView": view(picture, {}), "mimeType": "image/png"}]
        document["textures"] = [{"source": 0}]
        document["materials"][0].setdefault("pbrMetallicRoughness", {})["baseColorTexture"] = {"index": 0}
    for node in nodes:
        vertices, triangles = y_up(node["vertices"]), node["triangles"]
        attributes = {"POSITION": accessor(vertices.astype("<f4"), "VEC3", 5126)}
        if picture:
            low, high = node["vertices"].min(axis=0), node["vertices"].max(axis=0)
            places = ((node["vertices"] - low) / (high - low))[:, :2]
            attributes["TEXCOORD_0"] = accessor(places.astype("<f4"), "VEC2", 5126)
        indices = accessor(numpy.asarray(triangles).ravel().astype("<u4"), "SCALAR", 5125)
        document["meshes"].append({"primitives": [{"attributes": attributes, "indices": indices,
                                                   "material": 0}]})
        entry = {k: v for k, v in node.items() if k not in ("vertices", "triangles")}
        document["nodes"].append({**entry, "mesh": len(document["meshes"]) - 1})
        document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    document["buffers"] = [{"byteLength": len(data)}]
    return document, data


def write_glb(path, nodes, **options):
    document, data = gltf(nodes, **options)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def write_gltf(path, nodes, embedded=False, **options):
    """With the buffer inside, or in a file beside it whose name has a blank."""
    document, data = gltf(nodes, **options)
    if embedded:
        document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    else:
        document["buffers"][0]["uri"] = path.stem + "%20data.bin"
        (path.parent / (path.stem + " data.bin")).write_bytes(data)
    path.write_text(json.dumps(document))


def numbers(array):
    return " ".join("%.9g" % value for value in numpy.asarray(array, float).ravel())


def write_dae(path, vertices, triangles, metre=1.0, up="Z_UP", translation=(0, 0, 0)):
    path.write_text(f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="own" meter="{metre}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * len(vertices)}">{numbers(vertices)}</float_array>
<technique_common><accessor source="#pa" count="{len(vertices)}" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(triangles)}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(map(str, numpy.asarray(triangles).ravel()))}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="Body" name="Body">
<translate>{numbers(translation)}</translate><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""")


def write_x3d(path, vertices, triangles, metre=1.0):
    index = " ".join("%d %d %d -1" % tuple(t) for t in triangles)
    path.write_text(f"""<?xml version="1.0" encoding="UTF-8"?>
<X3D profile="Interchange" version="3.3"><head><unit category="length" name="own" conversionFactor="{metre}"/></head>
<Scene><Transform DEF="Body"><Shape><IndexedFaceSet coordIndex="{index}"><Coordinate point="{numbers(y_up(vertices))}"/>
</IndexedFaceSet></Shape></Transform></Scene></X3D>""")


def write_3mf(path, vertices, triangles, unit="millimeter", transforms=("1 0 0 0 1 0 0 0 1 0 0 0",)):
    points = "".join('<vertex x="%.9g" y="%.9g" z="%.9g"/>' % tuple(v) for v in vertices)
    faces = "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % tuple(t) for t in triangles)
    items = "".join(f'<item objectid="1" transform="{t}"/>' for t in transforms)
    said = f'unit="{unit}"' if unit else ""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", """<?xml version="1.0"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>""")
        archive.writestr("_rels/.rels", """<?xml version="1.0"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>""")
        archive.writestr("3D/3dmodel.model", f"""<?xml version="1.0" encoding="UTF-8"?>
<model {said} xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>
<object id="1" type="model"><mesh><vertices>{points}</vertices><triangles>{faces}</triangles></mesh></object>
</resources><build>{items}</build></model>""")


def write_fbx(path, vertices, triangles, centimetres=1.0, up=1):
    """In text; lengths are in so many centimetres, axis number `up` is up."""
    flat = ",".join("%.9g" % value for value in numpy.asarray(vertices).ravel())
    index = ",".join("%d,%d,%d" % (a, b, -c - 1) for a, b, c in triangles)
    path.write_text(f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}}
GlobalSettings:  {{
	Version: 1000
	Properties70:  {{
		P: "UpAxis", "int", "Integer", "",{up}
		P: "UpAxisSign", "int", "Integer", "",1
		P: "UnitScaleFactor", "double", "Number", "",{centimetres}
	}}
}}
Definitions:  {{
	Version: 100
	Count: 2
	ObjectType: "Model" {{
		Count: 1
	}}
	ObjectType: "Geometry" {{
		Count: 1
	}}
}}
Objects:  {{
	Geometry: 1001, "Geometry::body", "Mesh" {{
		Vertices: *{3 * len(vertices)} {{
			a: {flat}
		}}
		PolygonVertexIndex: *{3 * len(triangles)} {{
			a: {index}
		}}
		GeometryVersion: 124
	}}
	Model: 1002, "Model::Body", "Mesh" {{
		Version: 232
	}}
}}
Connections:  {{
	C: "OO",1002,0
	C: "OO",1001,1002
}}
""")
