"""A dataset as h5py sees it: complete, the same for every number of ranks, and resumable."""
import hashlib
import json
import re
import signal
import subprocess
import time
import unittest

import h5py
import numpy
from program import CARILLON, CONFIGS, FolderTest, run, run_json

CONFIG = """
name: little
seed: 0
materials: [steel, glass]
objects:
  - shape: bar
    parameters: {length: [15 cm, 20 cm]}
    sizes: [1, 1.5]
  - shape: disc
    count: 2
  - shape: tube
modes: {max_modes: 40, max_frequency: 12 kHz, order: 2, element_size: 4 cm}
audio: {seconds: 0.5 s, sample_rate: 22050 Hz}
strikes: {per_object: 3, spread: 15 deg}
mel: {bands: 32, frames: 9}
voxels: {resolution: 16}
camera: {width: 64, height: 48, views: 3}
files: {wav: true, png: true}
split: {validation: 0.3, test: 0.3}
"""
SAMPLES = 3 * (4 + 2 + 2 + 2)


def datasets(path):
    """Every dataset of a file by name."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.__setitem__(
            name, item[()]) if isinstance(item, h5py.Dataset) else None)
    return found


class Build(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = cls.folder / "little.yaml"
        cls.config.write_text(CONFIG)
        cls.output = cls.folder / "two"
        cls.summary = run_json("--cache", cls.folder / "cache-two", "build", cls.config, "-o",
                               cls.output, ranks=2)

    def test_everything_is_there(self):
        self.assertEqual(self.summary["samples"], SAMPLES)
        self.assertEqual(self.summary["failed_tasks"], 0)
        with h5py.File(self.output / "index.h5") as index:
            self.assertEqual(index["audio"].shape, (SAMPLES, 11025))
            self.assertEqual(index["audio"].dtype, numpy.float32)
            self.assertEqual(index["audio"].attrs["unit"], "m/s")
            self.assertEqual(index["mel"].shape, (SAMPLES, 32, 9))
            self.assertEqual(index["mel"].attrs["fft_size"], 2048)
            self.assertEqual(index["shapes/voxels"].shape, (4, 16, 16, 16))
            # Each object in both materials, seen from three sides.
            frames = index["appearances/frame"]
            self.assertEqual(frames.shape, (8, 3, 48, 64, 3))
            own = index["appearance_index"][()]
            for column in ("shape", "material"):
                of_frames = index[f"appearances/{column}"].asstr()[()]
                self.assertEqual(list(index[column].asstr()[()]), [of_frames[i] for i in own])
            pictures = {frames[i, v].tobytes() for i in range(8) for v in range(3)}
            self.assertGreaterEqual(len(pictures), 8 * 2)  # discs and tubes look alike from all sides
            names = index["shapes/shape"].asstr()[()]
            rows = index["shape_index"][()]
            self.assertEqual(list(index["shape"].asstr()[()]), [names[i] for i in rows])
            self.assertEqual(set(index["material"].asstr()[()]), {"steel", "glass"})
            for split in ("split_shape", "split_strike"):
                self.assertLessEqual(set(index[split].asstr()[()]), {"train", "validation", "test"})
        self.assertEqual(len(list((self.output / "sounds").rglob("*.wav"))), SAMPLES)
        names = {path.name for path in (self.output / "pictures").iterdir()}
        self.assertEqual(len(names), 4 * 2 * 3)
        self.assertLessEqual({"bar-000.steel.png", "bar-000.glass.png", "bar-000.glass.2.png"}, names)

    def test_sounds_ring_and_decay(self):
        with h5py.File(self.output / "index.h5") as index:
            for audio, peak in zip(index["audio"][()], index["peak"][()]):
                self.assertTrue(numpy.isfinite(audio).all())
                self.assertGreater(peak, 0)
                self.assertAlmostEqual(float(numpy.abs(audio).max()) / peak, 1, 5)
                early, late = audio[:2000], audio[-2000:]
                self.assertLess((late**2).sum(), (early**2).sum())

    def test_splits_hold_out_whole_shapes_and_whole_strikes(self):
        with h5py.File(self.output / "index.h5") as index:
            shape = index["shape"].asstr()[()]
            parts = {}
            for name, part in zip(shape, index["split_shape"].asstr()[()]):
                self.assertEqual(parts.setdefault(name, part), part)
            strikes = {}
            for key, part in zip(zip(shape, index["strike"][()]), index["split_strike"].asstr()[()]):
                self.assertEqual(strikes.setdefault(key, part), part)

    def test_spectrograms_belong_to_their_sounds(self):
        with h5py.File(self.output / "index.h5") as index:
            mel, audio = index["mel"][()], index["audio"][()]
            energy = (audio.astype(float)**2).sum(axis=1)
            loudest, softest = energy.argmax(), energy.argmin()
            self.assertGreater(mel[loudest].sum(), mel[softest].sum())

    def test_ids_keys_and_checksums(self):
        with h5py.File(self.output / "index.h5") as index:
            keys = index["key"].asstr()[()]
            self.assertEqual(len(set(keys)), SAMPLES)
            self.assertEqual(len(set(index["id"][()])), SAMPLES)
            digest = hashlib.sha256(keys[0].encode()).digest()
            self.assertEqual(int.from_bytes(digest[:8], "big"), int(index["id"][0]))
        description = json.loads((self.output / "dataset.json").read_text())
        for file in description["files"]:
            data = (self.output / file["path"]).read_bytes()
            self.assertEqual(hashlib.sha256(data).hexdigest(), file["sha256"])
        self.assertEqual(json.loads((self.output / "failures.json").read_text()), [])

    def test_every_name_is_in_the_document(self):
        document = (CONFIGS.parent / "docs" / "format.md").read_text()
        named = set(re.findall(r"`([^`\s]+)`", document))
        written = set()

        def note(name, item):
            path = re.sub(r"^(set-\d+|shapes)(/|$)", "", name)
            if isinstance(item, h5py.Dataset):
                written.add(path)
            written.update(item.attrs)

        turned = self.folder / "turned.h5"
        run_json("modes", "ring", "-m", "steel", "--solver", "axisymmetric", "-o", turned)
        for file in (self.output / "index.h5", turned, *self.output.rglob("modes/*.h5"),
                     *self.output.rglob("samples/*.h5")):
            with h5py.File(file) as opened:
                written.update(opened.attrs)
                opened.visititems(note)
        # Attributes that belong to datasets of a kind.
        written -= {"", "unit", "scale", "norm", "power", "window", "padding", "fft_size", "hop"}
        self.assertEqual(written - named, set())
        # And the way back: what the tables of a set promise is written.
        table = document[document.index("Fields of"):]
        promised = {name for row in re.findall(r"^\| (`[^|]*`) \|", table, re.M)
                    for name in re.findall(r"`([^`]+)`", row)}
        self.assertGreater(len(promised), 20)
        self.assertEqual(promised - written, set())

    def test_trace_shows_what_ran_and_nothing_else(self):
        effects = json.loads((self.output / "trace.json").read_text())["effects"]
        self.assertEqual(effects["mel"]["calls"], SAMPLES)
        self.assertEqual(effects["voxels"]["calls"], 4)
        self.assertEqual(effects["frames"]["calls"], 4)
        self.assertNotIn("radiation", effects)

    def test_1_2_and_4_ranks_give_the_same_values(self):
        for ranks in (1, 4):
            output = self.folder / f"ranks-{ranks}"
            run_json("--cache", "", "build", self.config, "-o", output, ranks=ranks)
            names = sorted(p.relative_to(self.output) for p in self.output.rglob("*.h5"))
            self.assertEqual(names, sorted(p.relative_to(output) for p in output.rglob("*.h5")))
            for name in names:
                here, there = datasets(self.output / name), datasets(output / name)
                self.assertEqual(here.keys(), there.keys())
                for key in here:
                    numpy.testing.assert_array_equal(here[key], there[key], f"{name}: {key}")

    def test_three_eigensolves_serve_every_material(self):
        config = self.write("materials.yaml", "materials: [ceramic, glass, wood, plastic, iron,"
                            " polycarbonate, steel, sterling_porcelain, sterling_glass]\n"
                            "objects:\n  - shape: bar\n    sizes: [1, 1.2]\n"
                            "modes: {max_frequency: 8 kHz}\nsolver: {pitch_cents: off}\n"
                            "strikes: {per_object: 1}\naudio: {seconds: 0.1 s}\n")
        output = self.folder / "materials"
        self.assertEqual(run_json("--cache", "", "build", config, "-o", output)["samples"], 18)
        stages = json.loads((output / "trace.json").read_text())["stages"]
        # A bar's modes fall into the four classes of two planes.
        self.assertEqual(stages["solve"]["calls"], 3 * 4)
        # Glass and sterling_glass have the same ratio of Poisson.
        self.assertEqual(stages["ritz"]["calls"], 8 * 4)
        with h5py.File(next((output / "modes").glob("*.h5"))) as file:
            sets = [file[name] for name in file if name.startswith("set-")]
            self.assertEqual(len(sets), 8)
            for one in sets:
                certificate = one["certificate"].attrs
                self.assertEqual(certificate["complete"], 1)
                self.assertEqual(certificate["snapshots"], 3)
                self.assertEqual(certificate["mirror_planes"], 2)
                self.assertLess(certificate["basis_error_cents"], 0.1)

    def test_second_run_does_nothing(self):
        before = {p: p.stat().st_mtime_ns for p in self.output.rglob("*.h5") if p.name != "index.h5"}
        result = run("build", self.config, "-o", self.output, ranks=2)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("nothing to do", result.stdout)
        for path, written in before.items():
            self.assertEqual(path.stat().st_mtime_ns, written)

    def test_lost_shard_is_made_again(self):
        output = self.folder / "lost"
        run_json("build", self.config, "-o", output)
        shard = next((output / "samples").glob("*.h5"))
        before = shard.read_bytes()
        shard.unlink()
        summary = run_json("build", self.config, "-o", output)
        self.assertEqual(summary["tasks_run"], 1)
        self.assertEqual(shard.read_bytes(), before)

    def test_other_configuration_is_refused_with_the_difference(self):
        result = run("build", self.config, "-o", self.output, "--set", "strikes.per_object=2")
        self.assertEqual(result.returncode, 2)
        self.assertIn("+   per_object: 2", result.stderr)

    def test_names_stay_inside_the_dataset(self):
        config = self.write("names.yaml", "objects:\n  - shape: disc\n    name: ../../escape\n"
                            "    materials: ['youngs_modulus=7e10,poisson_ratio=0.2,density=2500,"
                            "alpha1=5,alpha2=1e-7']\n"
                            "modes: {max_modes: 5, order: 2, element_size: 4 cm}\n"
                            "strikes: {per_object: 1}\naudio: {seconds: 0.1 s}\n"
                            "files: {wav: true, png: true}\ncamera: {width: 32, height: 32}\n")
        output = self.folder / "a" / "b" / "names"
        run_json("build", config, "-o", output)
        self.assertEqual([p.name for p in (self.folder / "a").iterdir()], ["b"])
        self.assertEqual([p.name for p in (self.folder / "a" / "b").iterdir()], ["names"])
        self.assertEqual(len(list((output / "sounds").rglob("*.wav"))), 1)

    def test_the_next_run_goes_on_after_an_interrupt(self):
        output = self.folder / "interrupted"
        command = [CARILLON, "--cache", "", "build", str(self.config), "-o", str(output), "--json"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        journal = output / "journal.jsonl"
        for _ in range(600):  # until a first task is in the journal
            if journal.exists() and journal.read_text().count("\n") >= 1:
                break
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        summary = json.loads(process.communicate(timeout=120)[0])
        self.assertEqual(process.returncode, 130)
        self.assertTrue(summary["interrupted"])
        self.assertEqual(summary["tasks_run"], journal.read_text().count("\n"))
        rest = run_json("build", self.config, "-o", output)
        self.assertEqual(rest["tasks_run"], 8 - summary["tasks_run"])
        here, there = datasets(self.output / "index.h5"), datasets(output / "index.h5")
        for key in here:
            numpy.testing.assert_array_equal(here[key], there[key], key)

    def test_changed_inputs_are_refused(self):
        table = "x_m,y_m,z_m,impulse_ns,contact_time_s\n0,0,0,%s,0.0002\n"
        self.write("hits.csv", table % 0.01)
        config = self.write("hits.yaml", "objects:\n  - shape: disc\n    materials: [steel]\n"
                            "modes: {max_modes: 5, order: 2, element_size: 4 cm}\n"
                            "strikes: {csv: hits.csv}\naudio: {seconds: 0.1 s}\n")
        output = self.folder / "hits"
        run_json("build", config, "-o", output)
        self.write("hits.csv", table % 0.02)
        result = run("build", config, "-o", output)
        self.assertEqual(result.returncode, 2)
        self.assertIn("built from other files", result.stderr)

    def test_a_sample_does_not_depend_on_its_neighbours(self):
        # The band's bottom counts for each size on its own, though one solve serves both.
        text = ("objects:\n  - shape: bar\n    materials: [steel]\n    sizes: %s\n"
                "modes: {min_frequency: 2 kHz, max_modes: 6}\nstrikes: {per_object: 1}\n"
                "audio: {seconds: 0.1 s}\n")
        sounds = []
        for name, sizes in (("alone", "[3]"), ("both", "[1, 3]")):
            config = self.write(f"{name}.yaml", text % sizes)
            run_json("build", config, "-o", self.folder / name)
            with h5py.File(self.folder / name / "index.h5") as index:
                self.assertEqual(index["modes"][-1], 6)
                sounds.append(index["audio"][-1])
        numpy.testing.assert_allclose(sounds[0], sounds[1], atol=1e-6 * abs(sounds[0]).max())

    def test_growing_leaves_what_exists_alone(self):
        output = self.folder / "more"
        run_json("build", self.config, "-o", output, "--set", "strikes.per_object=4", "--set",
                 "objects[1].count=3")
        with h5py.File(self.output / "index.h5") as small, h5py.File(output / "index.h5") as large:
            rows = {key: i for i, key in enumerate(large["key"].asstr()[()])}
            for i, key in enumerate(small["key"].asstr()[()]):
                numpy.testing.assert_array_equal(small["audio"][i], large["audio"][rows[key]])
                self.assertEqual(small["split_strike"].asstr()[i],
                                 large["split_strike"].asstr()[rows[key]])

    def test_int16_and_listeners(self):
        output = self.folder / "listeners"
        config = self.write("listeners.yaml", CONFIG + "listeners:\n"
                            "  - position: [0 m, 0 m, 1 m]\n  - position: [2 m, 0 m, 0 m]\n")
        run_json("build", config, "-o", output, "--set", "audio.dtype=int16", "--set",
                 "audio.gain=10", "--set", "strikes.per_object=1", "--set",
                 "radiation={model: monopole}")
        with h5py.File(output / "index.h5") as index:
            self.assertEqual(index["audio"].shape[1:], (2, 11025))
            self.assertEqual(index["audio"].dtype, numpy.int16)
            self.assertEqual(index["audio"].attrs["unit"], "Pa")
            self.assertEqual(index["mel"].shape[1:], (2, 32, 9))
            self.assertEqual(index["gain"][0], 10)

    def test_given_strikes(self):
        self.write("strikes.csv", "shape,x_m,y_m,z_m,peak_force_n,contact_time_s\n"
                   "bar-000,0.05,0,0.01,100,0.0002\n*,0.01,0,0.05,50,0.001\n")
        output = self.folder / "given"
        config = self.write("given.yaml", CONFIG.replace("{per_object: 3, spread: 15 deg}",
                                                         "{csv: strikes.csv}"))
        run_json("build", config, "-o", output)
        with h5py.File(output / "index.h5") as index:
            self.assertEqual(len(index["audio"]), 2 * 4 + 2 + 2 + 2)
            strikes = index["strike"][()]
            impulse = index["impulse"][()]
            numpy.testing.assert_allclose(impulse[strikes == 0], 100 * 0.0002 / 2)
            numpy.testing.assert_allclose(impulse[strikes == 1], 50 * 0.001 / 2)

    def test_negative_damping_is_told_once_when_a_build_begins(self):
        material = ("youngs_modulus=70 GPa,poisson_ratio=0.2,density=2500,"
                    "damping=1e-3*(f-800)*(f-3000)")
        config = self.write("dip.yaml", f"""
name: dip
objects: [{{shape: block, materials: ["{material}"]}}]
modes: {{max_modes: 5, max_frequency: 20 kHz}}
strikes: {{per_object: 1}}
negative_damping: clamp
""")
        told = "800 to 3000 Hz; modes there will be undamped"
        result = run("build", config, "-o", self.folder / "dip", ranks=2)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr.count(told), 1, result.stderr)
        again = run("build", config, "-o", self.folder / "dip")
        self.assertNotIn(told, again.stderr)  # nothing is left to do
        self.assertIn(told, run("plan", config).stdout)

    def test_failed_object_does_not_stop_the_others(self):
        self.write("soup.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n")
        config = self.write("broken.yaml", CONFIG.replace(
            "objects:", "objects:\n  - mesh: soup.obj\n    name: broken"))
        output = self.folder / "broken"
        result = run("build", config, "-o", output, ranks=2)
        self.assertEqual(result.returncode, 3, result.stderr)
        failures = json.loads((output / "failures.json").read_text())
        self.assertEqual([f["task"] for f in failures], ["modes/broken-soup"])
        self.assertTrue(failures[0]["message"])
        self.assertEqual(failures[0]["skipped"], ["samples/broken-soup-0000"])
        self.assertEqual(json.loads((output / "dataset.json").read_text())["samples"], SAMPLES)
        with h5py.File(output / "index.h5") as index:
            self.assertEqual(len(index["audio"]), SAMPLES)
        again = run("build", config, "-o", output, ranks=2)
        self.assertEqual(again.returncode, 3)
        self.assertIn("nothing to do", again.stdout)


if __name__ == "__main__":
    unittest.main()
