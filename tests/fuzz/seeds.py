"""Well-formed inputs of each parser, in each of its formats' variants, for the fuzzer to start from, and
words that it may put in."""
import io
import json
import pathlib
import shutil
import struct
import sys

import numpy
import soundfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "end_to_end"))
from msh_files import msh_2, msh_4, two_part_bar  # noqa: E402

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]


def obj():
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    yield "mtllib a.mtl\no cube\n" + vertices + "vn 0 0 1\nvt 0 0\ng side\nusemtl a\ns off\n" + "".join(
        "f " + " ".join(f"{i + 1}/1/1" for i in quad) + "\n" for quad in QUADS)
    yield vertices + "".join("f " + " ".join(f"{i - 8}//1" for i in t) + "\n" for t in TRIANGLES)
    yield "# one\nv 0 0 0 1 0 0\nv 1e-3 .5 +2\nv 0 1 0\nf 1 2 \\\n 3\nl 1 2\np 1\n"


def off():
    body = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
        f"4 {a} {b} {c} {d}\n" for a, b, c, d in QUADS)
    yield "OFF\n8 6 12\n" + body
    yield "OFF8 6 0\n" + body
    yield "COFF\n# colours\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n0 1 0 0 0 1 1\n3 0 1 2 255 0 0\n"


def ply():
    header = ("ply\nformat {} 1.0\ncomment a cube\nelement vertex 8\nproperty float x\nproperty float y\n"
              "property double z\nelement face 6\nproperty list uchar int vertex_indices\n"
              "property uchar red\nend_header\n")
    yield header.format("ascii") + "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
        "4 {} {} {} {} 7\n".format(*quad) for quad in QUADS)
    for name, order in (("binary_little_endian", "<"), ("binary_big_endian", ">")):
        yield (header.format(name).encode() +
               b"".join(struct.pack(order + "ffd", *p) for p in CORNERS) +
               b"".join(struct.pack(order + "B4iB", 4, *quad, 7) for quad in QUADS))


def stl():
    yield "solid cube\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*CORNERS[i]) for i in t) +
        "endloop\nendfacet\n" for t in TRIANGLES) + "endsolid cube\n"
    yield b"\0" * 80 + struct.pack("<I", len(TRIANGLES)) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for i in t for x in CORNERS[i]), 0) for t in TRIANGLES)


def msh():
    bar = two_part_bar(1)
    yield msh_2(*bar)
    yield msh_4(*bar)
    nodes, tetrahedra = bar
    yield (b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n" +
           f"$Nodes\n{len(nodes)}\n".encode() +
           b"".join(struct.pack("<i3d", i + 1, *p) for i, p in enumerate(nodes)) +
           f"\n$EndNodes\n$Elements\n{len(tetrahedra)}\n".encode() +
           struct.pack("<3i", 4, len(tetrahedra), 2) +
           b"".join(struct.pack("<7i", i + 1, 1, 1, *(t + 1 for t in tet))
                    for i, (_, tet) in enumerate(tetrahedra)) + b"\n$EndElements\n")


def svg():
    for data in ("M0 0H30V100H0Z", "m 0,0 c 10,0 30,20 30,50 s -10,50 -30,50 z",
                 "M0 0 Q 40 20 30 60 T 20 90 A 20 10 30 0 1 0 100", "M0,0L3e1,0L30 50-.5.5Z"):
        yield ('<?xml version="1.0"?><!-- a vase --><svg xmlns="http://www.w3.org/2000/svg">'
               f'<g id="a"><path style="fill:none" d="{data}"/></g></svg>')


def audio():
    random = numpy.random.default_rng(1)
    for channels in (1, 2):
        sound = 0.5 * random.standard_normal((64, channels)).clip(-1, 1)
        for kind, subtypes in (("WAV", ("PCM_16", "PCM_24", "PCM_U8", "FLOAT", "DOUBLE", "ULAW", "IMA_ADPCM")),
                               ("WAVEX", ("PCM_16",)), ("RF64", ("PCM_16",)), ("W64", ("FLOAT",)),
                               ("AIFF", ("PCM_16", "FLOAT")), ("AU", ("PCM_16",)), ("CAF", ("PCM_16",)),
                               ("FLAC", ("PCM_16",)), ("OGG", ("VORBIS",))):
            for subtype in subtypes:
                file = io.BytesIO()
                soundfile.write(file, sound, 8000, format=kind, subtype=subtype)
                yield file.getvalue()


def csv():
    yield "x_m,y_m,z_m,impulse_ns,contact_time_s\n0,0,0.1,0.01,0.0002\n1e-2,0,0,0.02,0.0003\n"
    yield '\ufeffshape,x_m,y_m,z_m,peak_force_n,contact_time_s,dx,dy,dz\r\n"a, ""b""",0,0,0,5,1e-3,0,0,-1\r\n'
    yield "# features\nfrequency_hz,decay_rate_per_s,frequency_error_hz,reverberant\n440,3.5,0.1,0\n880,7,,1\n"


def numpy_files():
    for type_name in ("<f4", "<f8", "<i2", "|u1", ">f4"):
        for version in ((1, 0), (2, 0), (3, 0)):
            for fortran in (False, True):
                file = io.BytesIO()
                numpy.lib.format.write_array(
                    file, numpy.array([[1, 2, 3], [4, 5, 6]], type_name, order="F" if fortran else "C"), version)
                yield file.getvalue()


def journal():
    line = json.dumps({"task": "modes/bar-000", "ok": True, "seconds": 0.25, "files": ["modes/bar-000.h5"]})
    yield line + "\n" + line.replace("true", "false") + "\n"
    yield line + "\n[1, 2]\nno json\n" + line[:20]


def configuration():
    for path in sorted((ROOT / "configs").glob("*.yaml")):
        text = path.read_text()
        if "texture" not in text:  # those are made while they are read: a tenth of a second each time
            yield text
    yield "--set audio.duration=0.5 s\n" + (ROOT / "configs" / "smoke.yaml").read_text()
    yield "--set sweep=\n" + "sweep: {mode: grid, keys: {modes.order: [2, 3], strikes.per_object: [1, 2]}}\n"


def answers():
    yield bytes([1, 1, 2, 65, 66] + 2 * ([1] + 5 * [5, 1, 2, 0, 1]))
    yield bytes(range(64))


SEEDS = {"obj": obj, "off": off, "ply": ply, "stl": stl, "msh": msh, "svg": svg, "audio": audio, "csv": csv,
         "numpy": numpy_files, "journal": journal, "configuration": configuration,
         "answers": answers}
WORDS = {
    "obj": ["v ", "vn ", "vt ", "f ", "\nf ", "/", "//", "-1", "\\\n", "1e308", "nan"],
    "off": ["OFF", "COFF", "NOFF", "STOFF", "4OFF", "OFF BINARY", "#", "2147483647", "1e308"],
    "ply": ["element ", "property ", "property list ", "uchar", "int8", "uint32", "double", "vertex", "face",
            "vertex_index", "end_header\n", "4294967295", "obj_info "],
    "stl": ["solid", "facet normal", "outer loop", "vertex ", "endloop", "endfacet", "endsolid", "\n", "nan"],
    "msh": ["$MeshFormat", "$Nodes", "$Elements", "$Entities", "$PhysicalNames", "$EndNodes", "4.1 0 8",
            "4.1 1 8", "2.2 1 8", "$PartitionedEntities", "9223372036854775807", "-1", "11", "29"],
    "svg": ["<path ", "d=\"", "transform=\"", "<g>", "</g>", "<!--", "-->", "<![CDATA[", "]]>", "M", "A", "Q",
            "1e308", "e-", "/>"],
    "csv": ["shape", "impulse_ns", "peak_force_n", "contact_time_s", "frequency_hz", "decay_rate_per_s",
            "amplitude", "\"", "\"\"", ",", "inf", "nan", "1e-320"],
    "numpy": ["descr", "fortran_order", "shape", "True", "False", "'<f8'", "'|b1'", "'<c16'", "18446744073709551615"],
    "configuration": ["objects:", "modes:", "sweep:", "evaluate:", "&a ", "*a", "<<: ", "- ", "{", "[", "!!str ",
                      "? ", "|", ">", "1e308", ".nan", ".inf", " km", " kHz", "off", "auto"],
    "journal": ["{", "}", "[", "\"", "\\u0000", "\\ud800", "null", "1e999", "-"],
}


def write(folder):
    """Seeds into folder/TARGET/, words into folder/TARGET.dict; returns the targets."""
    shutil.rmtree(folder, ignore_errors=True)
    for target, make in SEEDS.items():
        (folder / target).mkdir(parents=True, exist_ok=True)
        for number, seed in enumerate(make()):
            (folder / target / f"{number:02}").write_bytes(seed if isinstance(seed, bytes) else seed.encode())
        if target not in WORDS:
            continue
        words = "".join('"' + "".join(f"\\x{byte:02x}" for byte in word.encode()) + '"\n'
                        for word in WORDS[target])
        (folder / f"{target}.dict").write_text(words)
    return list(SEEDS)
