"""A small dataset with rooms and recorded noise, for tests that damage or repeat it."""
import wave

import numpy

CONFIG = """
name: small
seed: 4
objects:
  - shape: bar
    count: 4
    parameters: {length: [10 cm, 12 cm], width: [2 cm, 3 cm], height: [8 mm, 12 mm]}
    materials: [steel, clay]
  - mesh: meshes/*.obj
    length: 6 cm
    materials: [clay]
materials_file: own.yaml
modes: {max_modes: 12, max_frequency: 9 kHz, order: 2, max_elements: 6000}
audio: {seconds: 0.15 s, sample_rate: 22050 Hz, gain: 0.05}
strikes: {per_object: 6}
listeners:
  - position: [0 m, 0 m, 0.8 m]
radiation: {model: monopole}
room: {dimensions: [[4, 6], [3, 5], [2.5, 3]], absorption: 0.4, count: 2, image_order: 1}
noise: {folder: noise, snr: [10, 30]}
mel: {bands: 16, frames: 5}
split: {validation: 0.35, test: 0.35}
"""
OWN = """
clay: {youngs_modulus: 3 GPa, poisson_ratio: 0.3, density: 1800, alpha1: 20, alpha2: 1.0e-7}
"""
BOX = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(1, 3, 2), (2, 3, 4), (5, 6, 7), (6, 8, 7), (1, 2, 5), (2, 6, 5), (3, 7, 4), (4, 7, 8),
         (1, 5, 3), (3, 5, 7), (2, 4, 6), (4, 8, 6)]


def write_obj(path, sides, turned=False):
    """A block; `turned` by 30 degrees, moved, three times the size, its vertices the other way."""
    points = numpy.array(BOX, float) * sides
    order = list(range(8))
    if turned:
        c, s = numpy.sqrt(3) / 2, 0.5
        points = 3 * points @ numpy.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) + [5, -2, 1]
        order = order[::-1]
    place = {old: new for new, old in enumerate(order)}
    lines = ["v %.9f %.9f %.9f" % tuple(points[i]) for i in order]
    lines += ["f %d %d %d" % tuple(place[i - 1] + 1 for i in face) for face in FACES]
    path.write_text("\n".join(lines) + "\n")


def write_wav(path, samples, rate=22050):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((samples * 20000).astype("<i2").tobytes())


def write_inputs(folder):
    """The configuration and what it names; returns the configuration's path."""
    (folder / "meshes").mkdir()
    (folder / "noise").mkdir()
    write_obj(folder / "meshes" / "block.obj", [0.06, 0.03, 0.02])
    write_obj(folder / "meshes" / "copy.obj", [0.06, 0.03, 0.02], turned=True)
    random = numpy.random.default_rng(1)
    for name in ("a", "b"):
        write_wav(folder / "noise" / f"{name}.wav", random.uniform(-1, 1, 22050 * 6))
    (folder / "own.yaml").write_text(OWN)
    config = folder / "small.yaml"
    config.write_text(CONFIG)
    return config
