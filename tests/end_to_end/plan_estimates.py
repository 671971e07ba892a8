"""What `plan` says of bytes and processor time, against what a build wrote and took."""
import json
import unittest

from program import CONFIGS, FolderTest, long, run, run_json

# All that a build may write: modes of both solvers, sounds as shards and WAV files, views.
SMALL = """
name: small
seed: 3
materials: [steel, plastic]
objects:
  - {shape: bar, parameters: {length: 16 cm, width: 25 mm, height: 10 mm}}
  - {shape: bowl}
modes: {max_frequency: 10 kHz, max_modes: 60}
strikes: {per_object: 8}
noise: {kind: white, snr: 40 dB}
mel: {bands: 64, frames: 25}
voxels: {resolution: 24}
camera: {width: 128, height: 128}
files: {wav: true, png: true}
"""
RSAUDIO = ("strikes.per_object=10",
           "objects=[{shape: plate, count: 2}, {shape: bowl, count: 2}, {shape: cup, count: 2}, {shape: vase}, "
           "{shape: bell}, {shape: wrench, count: 2}, {shape: bar, count: 2}, {shape: tile}, {shape: block, "
           "parameters: {length: [15 cm, 25 cm], width: [8 cm, 15 cm], height: [4 cm, 8 cm]}}, "
           "{shape: disc, count: 2}, {shape: tube, count: 2}, {shape: ring}]")


def bytes_of(folder):
    """By the kinds that `plan` tells of; voxels and pictures in modes files count as modes."""
    kinds = {"sounds": "samples", "modes": "modes", "wav": "sounds", "pictures": "pictures"}
    found = {kind: sum(file.stat().st_size for file in (folder / name).rglob("*") if file.is_file())
             for kind, name in kinds.items()}
    found["index"] = (folder / "index.h5").stat().st_size
    found["total"] = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return found


class PlanEstimates(FolderTest):
    def build(self, config, *changes):
        """The plan's estimate, and bytes and seconds of the dataset that is built."""
        sets = [word for change in changes for word in ("--set", change)]
        planned = run_json("plan", config, *sets)["estimate"]
        folder = self.folder / f"built-{config.stem}"
        built = run("build", config, *sets, "-o", folder, "--cache", "", timeout=7200)
        self.assertEqual(built.returncode, 0, built.stderr)
        tasks = json.loads((folder / "trace.json").read_text())["tasks"]
        self.assertAlmostEqual(sum(task["estimate_s"] * task["width"] for task in tasks) / planned["rank_seconds"],
                               1, 6)
        return planned, bytes_of(folder), sum(task["cpu_s"] for task in tasks)

    def test_bytes_and_seconds_of_a_small_build(self):
        config = self.write("small.yaml", SMALL)
        planned, held, seconds = self.build(config)
        disk = planned["disk"]
        self.assertAlmostEqual(sum(disk.values()), planned["disk_bytes"], 0)
        for kind, tolerance in (("sounds", 0.1), ("wav", 0.01), ("index", 0.15)):
            self.assertLess(abs(disk[kind] / held[kind] - 1), tolerance, (kind, disk[kind], held[kind]))
        modes = disk["modes"] + disk["voxels"] + disk["pictures"]
        self.assertLess(abs(modes / (held["modes"] + held["pictures"]) - 1), 0.4, (modes, held))
        self.assertLess(abs(planned["disk_bytes"] / held["total"] - 1), 0.1, (planned, held))
        # Machines differ, and are busy.
        self.assertLess(seconds / planned["rank_seconds"], 3)
        self.assertLess(planned["rank_seconds"] / seconds, 3)
        text = run("plan", config).stdout
        for word in ("on disk: sounds ", ", modes ", ", voxels ", ", pictures ", ", wav ", ", index ", ", records "):
            self.assertIn(word, text)

    def test_sounds_take_room_by_their_number(self):
        config = self.write("few.yaml", SMALL)
        few, many = (run_json("plan", config, "--set", f"strikes.per_object={count}")["estimate"]["disk"]
                     for count in (10, 100))
        self.assertEqual(few["modes"], many["modes"])
        for kind in ("sounds", "wav"):
            self.assertLess(abs(many[kind] / few[kind] / 10 - 1), 0.02, kind)
        for key, kind in (("files", "wav"), ("camera", "pictures"), ("voxels", "voxels")):
            without = self.write("without.yaml", "".join(
                line for line in SMALL.splitlines(keepends=True)
                if not line.startswith(f"{key}:") and not (key == "camera" and line.startswith("files:"))))
            self.assertEqual(run_json("plan", without)["estimate"]["disk"][kind], 0, key)

    @long
    def test_published_configurations(self):
        """The table of docs/scaling.md."""
        for config, *changes in (("smoke.yaml",), ("kitchen.yaml",), ("rsaudio.yaml", *RSAUDIO)):
            with self.subTest(config):
                planned, held, seconds = self.build(CONFIGS / config, *changes)
                print(f"| {config} | {planned['disk_bytes'] / 1e6:.1f} MB | {held['total'] / 1e6:.1f} MB | "
                      f"{planned['rank_seconds']:.1f} s | {seconds:.1f} s |", flush=True)
                self.assertLess(abs(planned["disk_bytes"] / held["total"] - 1), 0.1, (planned, held))
                self.assertLess(seconds / planned["rank_seconds"], 3)
                self.assertLess(planned["rank_seconds"] / seconds, 3)


if __name__ == "__main__":
    unittest.main()
