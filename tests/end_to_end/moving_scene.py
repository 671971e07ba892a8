"""A scene with everything in it that several tests build: meshes from files beside generated shapes,
a texture, strings, a stylus and a camera; two listeners in a room, noise and a recorder."""
import shutil

from program import FolderTest, run_json

CONFIG = """
name: moving
seed: 5
objects:
  - {shape: tile, name: floor, materials: [ceramic],
     parameters: {length: 300 mm, width: 200 mm, thickness: 20 mm}}
  - {mesh: 'meshes/*.obj', name: crate, length: 50 mm, materials: [wood, steel]}
  - {mesh: meshes/top.stl, name: top, length: 40 mm, materials: [glass, wood]}
  - {shape: bar, name: chime, count: 2, materials: [steel],
     parameters: {length: [80 mm, 100 mm], width: 12 mm, height: 8 mm}}
  - {shape: sphere, name: ball, materials: [steel, glass], parameters: {radius: 10 mm}}
modes: {max_modes: 8, order: 1, element_size: 20 mm}
audio: {sample_rate: 16 kHz, seconds: 0.4 s, dtype: int16, gain: 0.02}
listeners:
  - {position: [0, -0.3 m, 0.2 m]}
  - {position: [0.3 m, -1.2 m, 0.4 m]}
room: {dimensions: [4 m, 5 m, 2.5 m], rt60: 0.3 s, image_order: 1, count: 2}
noise: {kind: [white, pink], snr: [25 dB, 40 dB]}
recording: {shift: [0 s, 2 ms], gain: [-3 dB, 0 dB]}
mel: {bands: 16, frames: 9}
files: {wav: true}
motion:
  simulations: 7
  bodies:
    - object: floor
      fixed: true
      at: [0, 0, -10 mm]
      texture: {map: tiles, parameters: {side: 50 mm}, texels: 128}
    - {object: crate, at: [[-60 mm, -40 mm], 40 mm, 60 mm], velocity: [0, 0, -1 m/s]}
    - {object: crate, name: other, at: [60 mm, [30 mm, 50 mm], 60 mm], velocity: [0, 0, -1 m/s]}
    - {object: top, at: [-60 mm, -50 mm, 50 mm], velocity: [0, 0, -1 m/s], spin: [0, 0, [10, 20]]}
    - {object: chime, at: [50 mm, -30 mm, 80 mm], rests: string}
    - {object: ball, at: [50 mm, -80 mm, 80 mm], velocity: [0, [0.5 m/s, 1 m/s], 0]}
  strings:
    - {body: chime, at: [-30 mm, 0, 4 mm], anchor: [20 mm, -30 mm, 0.3 m]}
    - {body: chime, at: [30 mm, 0, 4 mm], anchor: [80 mm, -30 mm, 0.3 m]}
  stylus:
    body: floor
    path: [{u: [20 mm, 40 mm], v: 20 mm}, {u: 200 mm, v: 20 mm}]
    speed: [0.1 m/s, 0.2 m/s]
    radius: 0.5 mm
  camera: {width: 40, height: 30, rate: 10 Hz, eye: [0.3 m, -0.5 m, 0.3 m], target: [0, 0, 20 mm],
           movie: true}
split: {validation: 0.2, test: 0.2}
"""
SIMULATIONS = 7
SHAPES = 7
SHARDS = 2  # of up to four simulations
MOVIE = ".mp4" if shutil.which("ffmpeg") else ""  # else a folder of frames
# Boxes that may narrow upwards: length (width and height are 1), and how far each side leans in.
BOXES = {"a": (1.7, 0), "b": (1.4, 0.2)}


def write_meshes(folder):
    """meshes/a.obj, meshes/b.obj and meshes/top.stl, an octahedron."""
    folder.mkdir()
    for name, (x, lean) in BOXES.items():
        corners = [(0, 0, 0), (x, 0, 0), (x, 1, 0), (0, 1, 0), (lean, lean, 1), (x - lean, lean, 1),
                   (x - lean, 1 - lean, 1), (lean, 1 - lean, 1)]
        faces = ["4 3 2 1", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"]
        (folder / f"{name}.obj").write_text(
            "".join("v %g %g %g\n" % c for c in corners) + "".join(f"f {f}\n" for f in faces))
    around = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    text = "solid top\n"
    for k in range(4):
        for corners in ((around[k], around[k - 3], (0, 0, 1)), (around[k - 3], around[k], (0, 0, -1))):
            lines = "".join("vertex %g %g %g\n" % c for c in corners)
            text += f"facet normal 0 0 0\nouter loop\n{lines}endloop\nendfacet\n"
    (folder / "top.stl").write_text(text + "endsolid top\n")


def written(folder, *parts):
    """When each file of these folders was written, and which one it is."""
    return {str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_ino)
            for part in parts for path in folder.glob(f"{part}/*")}


class MovingTest(FolderTest):
    """Has the configuration in `config` and a build of it on one rank in `whole`."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        write_meshes(cls.folder / "meshes")
        cls.config = cls.folder / "moving.yaml"
        cls.config.write_text(CONFIG)
        cls.whole = cls.folder / "whole"
        cls.summary = run_json("build", cls.config, "-o", cls.whole)
