"""--tune: an object is scaled to a pitch, and is what a body of that size is."""
import json
import re
import unittest

import h5py
import numpy
from program import FolderTest, run, run_json

# One of each solver; of tetrahedra the same elements at every size.
BODIES = {"bell": ("bell", "--max-frequency", "8 kHz"),
          "block": ("block:length=60mm,width=40mm,height=20mm", "--order", "2", "--element-size", "15 mm",
                    "--max-frequency", "4 kHz", "--max-modes", "12")}
GLASS = "youngs_modulus=6.2e10,poisson_ratio=0.2,density=2600,alpha1=3,alpha2=2e-8"


def frequencies(modes):
    return numpy.array([mode["frequency_hz"] for mode in modes["modes"]])


def cents(a, b):
    return 1200 * numpy.log2(numpy.asarray(a) / b)


class Tuning(FolderTest):
    def test_a_mode_is_at_the_pitch(self):
        for name, body in BODIES.items():
            for material in ("steel", GLASS):
                with self.subTest(name, material=material):
                    tuned = run_json("modes", *body, "-m", material, "--tune", "440Hz")
                    self.assertLess(abs(cents(frequencies(tuned)[0], 440)), 1e-6)
                    self.assertGreater(len(tuned["modes"]), 5)
        third = run_json("modes", *BODIES["block"], "-m", "steel", "--tune", "440 Hz", "--tune-mode", "3")
        self.assertLess(abs(cents(frequencies(third)[2], 440)), 1e-6)

    def test_is_the_body_of_that_size(self):
        """Solved anew with every length of the shape times the factor."""
        tuned = run_json("modes", "bell", "-m", "iron", "--tune", "660 Hz", "--max-frequency", "8 kHz")
        lengths = {"radius": 0.0625, "shoulder_radius": 0.0325, "height": 0.1, "wall": 0.004, "lip_wall": 0.007}
        scaled = "bell:" + ",".join(f"{name}={value * tuned['size']!r}" for name, value in lengths.items())
        known = run_json("modes", scaled, "-m", "iron", "--max-frequency", "8 kHz", "--cache", "")
        self.assertEqual(len(known["modes"]), len(tuned["modes"]))
        self.assertLess(numpy.abs(cents(frequencies(tuned), frequencies(known))).max(), 0.1)
        self.assertAlmostEqual(tuned["mass_kg"] / known["mass_kg"], 1, 6)
        for ours, theirs in zip(tuned["modes"], known["modes"]):
            self.assertAlmostEqual(ours["decay_rate_per_s"] / theirs["decay_rate_per_s"], 1, 4)

    def test_each_material_has_a_size_of_its_own(self):
        """By Poisson's ratio alike, sizes go with the speed of sound."""
        sizes = []
        for youngs_modulus in (7e10, 2.8e11):
            material = f"youngs_modulus={youngs_modulus},poisson_ratio=0.2,density=2500"
            sizes.append(run_json("modes", *BODIES["bell"], "-m", material, "--tune", "500 Hz")["size"])
        self.assertAlmostEqual(sizes[1] / sizes[0], 2, 4)

    def test_sounds_at_the_pitch(self):
        path = self.folder / "bell.wav"
        struck = run_json("strike", "bell", "-m", GLASS, "--tune", "880 Hz", "--seconds", "0.5", "-o", path)
        found = run_json("features", path, "--max-frequency", "1 kHz")["features"]
        self.assertLess(abs(cents(found[0]["frequency_hz"], 880)), 1)
        self.assertGreater(struck["size"], 1)
        spoken = run("strike", "bell", "-m", GLASS, "--tune", "880 Hz", "-o", path)
        self.assertEqual(spoken.returncode, 0, spoken.stderr)
        self.assertRegex(spoken.stdout, r"tuned to 880 Hz: every length times")
        program = self.folder / "bell.dsp"
        run_json("export-faust", "bell", "-m", GLASS, "--tune", "880 Hz", "--max-frequency", "4 kHz",
                 "--pitch-mode", "1", "-o", program)
        pitch = re.search(r"freq/(\S+?)/size", program.read_text())[1]
        self.assertLess(abs(cents(float(pitch), 880)), 1e-6)

    def test_of_a_file(self):
        """Whatever its unit: a tetrahedron with sides of 3 to 5."""
        path = self.write("wedge.obj", "v 0 0 0\nv 3 0 0\nv 0 4 0\nv 0 0 5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        tuned = [run_json("modes", path, "-m", "steel", "--tune", "2 kHz", "--max-frequency", "5 kHz", "--order",
                          "2", *unit) for unit in ((), ("--unit", "mm"))]
        for modes in tuned:
            self.assertLess(abs(cents(frequencies(modes)[0], 2000)), 1e-6)
            self.assertEqual(modes["warnings"], [])
        # Meshes are as fine as sound in a body of the size before asks for: a cent.
        self.assertAlmostEqual(tuned[1]["size"] / tuned[0]["size"] / 1000, 1, 2)
        self.assertAlmostEqual(tuned[0]["mesh"]["volume"] * 7850 / tuned[0]["mass_kg"], 1, 2)

    def test_says_what_is_wrong(self):
        path = self.write("wedge.obj", "v 0 0 0\nv 3 0 0\nv 0 4 0\nv 0 0 5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        for arguments, said in (((path, "--tune", "440 Hz", "--length", "10 cm"), ("--length", "--tune")),
                                (("bell", "--tune", "0 Hz"), ("--tune", "positive")),
                                (("bell", "--tune", "440 kg"), ("440 kg",)),
                                (("bell", "--tune-mode", "2"), ("--tune-mode", "--tune")),
                                (("bell", "--tune", "440 Hz", "--tune-mode", "301"), ("mode 301",)),
                                (("bell", "--tune", "30 kHz"), ("outside the band",)),
                                (("bell", "--tune", "440 Hz", "--min-frequency", "1 kHz"), ("outside the band",)),
                                (("sphere", "--tune", "100 Hz"), ("outside 1 mm to 10 m",))):
            result = run("modes", *arguments, "-m", "steel")
            self.assertEqual(result.returncode, 2, result.stderr)
            for word in said:
                self.assertIn(word, result.stderr)

    BUILD = ("name: %s\nmaterials: [steel, glass]\nmodes: {max_frequency: 5 kHz}\nstrikes: {per_object: 2}\n"
             "audio: {seconds: 0.5 s}\nvoxels: {resolution: 12}\nobjects:\n"
             "  - {shape: bell, tune: [440 Hz, 660 Hz]}\n"
             "  - {shape: block, tune: 2 kHz, tune_mode: 2}\n")

    def test_a_build_tunes_its_objects(self):
        config = self.write("tuned.yaml", self.BUILD % "tuned")
        self.assertIn("tuned ", run("plan", config).stdout)
        built = run("build", config, "-o", self.folder / "tuned", "--quiet")
        self.assertEqual(built.returncode, 0, built.stderr)
        with h5py.File(self.folder / "tuned/index.h5") as index:
            keys, sizes = index["key"].asstr()[:], index["size"][:]
            errors = index["pitch_error"][:]
            points = index["position"][:]
        self.assertEqual(len(set(zip((key.rsplit("/", 1)[0] for key in keys), sizes))), 6)
        self.assertIn("bell-000/glass/440Hz/strike-0001", keys)
        self.assertIn("block-000/steel/2000Hz-mode-2/strike-0000", keys)
        self.assertTrue((self.folder / "tuned/samples/bell-000-0000.h5").exists())
        for body in ("bell-000", "block-000"):
            with h5py.File(self.folder / f"tuned/modes/{body}.h5") as modes:
                tuned = modes["tuned_sizes"][:]
                half = numpy.abs(modes["set-000/surface/nodes"][:]).max(0)
            own = [(key, size) for key, size in zip(keys, sizes) if key.startswith(body)]
            self.assertEqual({size for _, size in own}, set(tuned))
            for place, (key, size) in enumerate(zip(keys, sizes)):
                if key.startswith(body):
                    self.assertTrue((numpy.abs(points[place]) <= half * size * (1 + 1e-9)).all(), key)
        # What one size rings at, another command finds: the object solved in that size.
        bell = {"radius", "shoulder_radius", "height", "wall", "lip_wall"}
        for body, family, pitch, mode in (("bell-000", "bell", 440, 1), ("block-000", "block", 2000, 2)):
            request = json.loads(h5py.File(self.folder / f"tuned/modes/{body}.h5").attrs["request"])
            for material in ("steel", "glass"):
                place = next(i for i, key in enumerate(keys) if key.startswith(f"{body}/{material}/{pitch}Hz"))
                lengths = {name: value * sizes[place] for name, value in request["shape"]["parameters"].items()}
                if family == "bell":
                    self.assertEqual(set(lengths), bell)
                shape = family + ":" + ",".join(f"{name}={value!r}" for name, value in lengths.items())
                found = run_json("modes", shape, "-m", material, "--max-frequency", "5 kHz", "--pitch-cents", "5")
                away = abs(cents(frequencies(found)[mode - 1], pitch))
                self.assertLess(away, errors[place] + found["modes"][mode - 1]["pitch_error_cents"] + 0.1, body)
        checked = run("check", self.folder / "tuned")
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        regenerated = ("regenerate", self.folder / "tuned", "--sample", "bell-000/glass/660Hz/strike-0001", "--cache", "")
        self.assertEqual(run_json(*regenerated)["modes"], [])
        file = self.folder / "tuned/modes/bell-000.h5"
        kept = file.read_bytes()
        file.unlink()
        self.assertEqual(len(run_json(*regenerated)["modes"]), 1)  # solved again, and the same to the last bit
        file.write_bytes(kept)
        # Another material changes no other one's size, and the dataset grows.
        grown = self.write("tuned.yaml", (self.BUILD % "tuned").replace("glass]", "glass, iron]"))
        self.assertEqual(run("build", grown, "-o", self.folder / "tuned", "--quiet").returncode, 0)
        with h5py.File(self.folder / "tuned/index.h5") as index:
            now = dict(zip(index["key"].asstr()[:], index["size"][:]))
        for key, size in zip(keys, sizes):
            self.assertLess(abs(cents(now[key], size)), 0.2, key)

    def test_a_configuration_says_what_is_wrong(self):
        for entry, said in (("tune: 440 kg", ("objects[0].tune", "440 kg")),
                            ("tune: 0 Hz", ("tune", "positive")),
                            ("tune: [440 Hz, 440 Hz]", ("tune", "twice")),
                            ("tune: 440 Hz, sizes: [1, 2]", ("`tune` and `sizes`",)),
                            ("tune: 440 Hz, length: 10 cm", ("`tune` and `length`",)),
                            ("tune: 440 Hz, drawn_size: {mean: 1, deviation: 0.1}", ("`tune` and `drawn_size`",)),
                            ("tune_mode: 2", ("tune_mode", "no `tune`")),
                            ("tune: 440 Hz, tune_mode: 0", ("tune_mode", "out of range")),
                            ("tune: 440 Hz, tune_mode: 500", ("mode 500", "max_modes")),
                            ("tune: 30 kHz", ("outside the band", "modes.max_frequency"))):
            path = self.write("wrong.yaml", "materials: [steel]\nobjects: [{shape: bell, %s}]\n" % entry)
            result = run("plan", path)
            self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
            for word in said:
                self.assertIn(word, result.stderr)
        moving = self.write("moving.yaml", "materials: [steel]\nobjects: [{shape: bell, tune: 440 Hz}]\n"
                            "motion: {bodies: [{object: bell}]}\nlisteners: [{position: [1, 1, 1]}]\n")
        result = run("plan", moving)
        self.assertEqual(result.returncode, 2, result.stdout)
        self.assertIn("tuned", result.stderr)

    def test_by_two_ranks(self):
        """What one rank finds wrong ends both, and both find the same modes."""
        one = run_json("modes", *BODIES["block"], "-m", "steel", "--tune", "440 Hz")
        two = run_json("modes", *BODIES["block"], "-m", "steel", "--tune", "440 Hz", "--cache", "", ranks=2)
        self.assertLess(numpy.abs(cents(frequencies(two), frequencies(one))).max(), 1e-4)
        wrong = run("modes", *BODIES["block"], "-m", "steel", "--tune", "30 kHz", ranks=2)
        self.assertEqual(wrong.returncode, 2, wrong.stderr)
        self.assertNotIn("MPI_ABORT", wrong.stderr)


if __name__ == "__main__":
    unittest.main()
