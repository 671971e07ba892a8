"""The Python module: the same numbers as the program's, arrays in and out, errors with the same words."""
import copy
import json
import pickle
import unittest

import numpy
from commands import read_float_wav
from module_test import BAND, BARS, OPTIONS, WEDGE, ModuleTest, ca
from program import run, run_json


class Modes(ModuleTest):
    def test_of_arrays_are_those_of_the_same_triangles_in_a_file(self):
        vertices, faces = WEDGE
        lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
        path = self.write("wedge.obj", "\n".join(lines) + "\n")
        band = {"max_frequency": 100e3, "max_modes": 5, "pitch_cents": "off"}
        known = run_json("modes", path, "-m", "glass", "--max-modes", "5", "--max-frequency", "100 kHz",
                         "--pitch-cents", "off", "--cache", "")
        for made in (ca.Object(*WEDGE), ca.Object.load(path)):
            modes = made.modes("glass", **band)
            self.assertEqual(list(modes.frequencies), self.column(known, "frequency_hz"))
            self.assertEqual(list(modes.errors), self.column(known, "pitch_error_cents"))
            self.assertEqual(list(modes.decay_rates), self.column(known, "decay_rate_per_s"))
            self.assertEqual(modes.mass, known["mass_kg"])
            self.assertEqual(vars(modes.certificate), known["certificate"])

    def test_tuned_to_a_pitch(self):
        bell = ca.shape("bell")
        for tuned, mode in ((bell.modes("iron", tune="440 Hz", max_frequency="6 kHz"), 0),
                            (bell.modes("iron", tune=880, tune_mode=3, max_frequency="6 kHz"), 2)):
            pitch = 440 if mode == 0 else 880
            self.assertLess(abs(1200 * numpy.log2(tuned.frequencies[mode] / pitch)), 1e-6)
            known = bell.modes("iron", max_frequency=1.1 * 6e3 * tuned.document["size"])
            ratio = known.frequencies[:len(tuned)] / tuned.frequencies
            self.assertLess(numpy.abs(ratio / tuned.document["size"] - 1).max(), 1e-4)
        for wrong, words in (({"tune": 0}, "no pitch"), ({"tune": "3 m"}, "tune: "),
                             ({"tune": 440, "tune_mode": 0}, "tune_mode"), ({"tune": 50e3}, "outside the band")):
            with self.assertRaisesRegex(ca.InputError, words):
                bell.modes("iron", **wrong)
        with self.assertRaisesRegex(ca.InputError, "length and tune"):
            ca.shape("bell", longest_side=0.1).modes("iron", tune=440)

    def test_shapes_are_mass_normalised_at_the_nodes_of_the_surface(self):
        modes = ca.shape("block", longest_side=0.05).modes("steel", max_frequency="60 kHz", pitch_cents="off")
        self.assertEqual(modes.shapes.shape, (len(modes), len(modes.nodes), 3))
        self.assertEqual(modes.shapes.dtype, numpy.float32)
        self.assertLess(modes.triangles.max(), len(modes.nodes))
        # Moved as a whole a body has 1 / sqrt(mass); its modes are of that order.
        rms = numpy.sqrt((modes.shapes ** 2).sum(2).mean(1))
        self.assertTrue(numpy.all((rms > 0.5 / modes.mass ** 0.5) & (rms < 5 / modes.mass ** 0.5)), rms)

    def test_parameters_are_those_of_the_command_line(self):
        known = run_json("modes", "bowl:radius=70mm", "-m", "ceramic", *OPTIONS, "--cache", "")
        modes = ca.shape("bowl", radius=0.07).modes("ceramic", **BAND)
        self.assertEqual(list(modes.frequencies), self.column(known, "frequency_hz"))
        self.assertLess(modes.errors.max(), 5)
        self.assertIn("bowl", repr(modes))
        self.assertIn("<table>", modes._repr_html_())

    def test_a_length_is_the_familys_where_it_has_one(self):
        known = run_json("modes", "bar:length=0.2,width=0.02,height=0.01", "-m", "steel", *OPTIONS, "--cache", "")
        modes = ca.shape("bar", length=0.2, width=0.02, height=0.01).modes("steel", **BAND)
        self.assertEqual(list(modes.frequencies), self.column(known, "frequency_hz"))
        scaled = ca.shape("bar", longest_side=0.1).modes("steel", max_modes=3, pitch_cents="off")
        self.assertAlmostEqual(numpy.ptp(scaled.nodes, axis=0).max(), 0.1, places=6)
        with self.assertRaisesRegex(ca.InputError, "bowl.*length"):
            ca.shape("bowl", length=0.1)

    def test_a_pitch_target_that_is_missed_is_warned_of(self):
        with self.assertWarnsRegex(ca.CarillonWarning, "target of 0.02 cents is missed"):
            ca.shape("bar").modes("steel", max_modes=4, pitch_cents=0.02, max_unknowns=8000)

    def test_of_grain_follow_the_materials_axes(self):
        along, across = (ca.shape("bar", first_axis=axis).modes("spruce", **BAND, pitch_cents="off").frequencies[0]
                         for axis in ((1, 0, 0), (0, 1, 0)))
        self.assertGreater(along, 2 * across)
        known = run_json("modes", "bar", "-m", "spruce", "--first-axis", "0,1,0", "--pitch-cents", "off", *OPTIONS,
                         "--cache", "")
        self.assertEqual(across, self.column(known, "frequency_hz")[0])
        with self.assertRaisesRegex(ca.InputError, "follows from its stiffness"):
            ca.materials["spruce"].replace(youngs_modulus=1e9)

    def test_are_saved_and_loaded_and_rescaled(self):
        modes = ca.shape("bar").modes("steel", **BAND)
        modes.save(self.folder / "bar.h5")
        again = ca.Modes.load(self.folder / "bar.h5", "steel")
        numpy.testing.assert_array_equal(again.frequencies, modes.frequencies)
        steel = ca.material("steel")
        stiffer = modes.in_material(steel.replace(youngs_modulus=4 * steel.youngs_modulus), size=2)
        numpy.testing.assert_allclose(stiffer.frequencies, modes.frequencies, rtol=1e-12)
        with self.assertRaisesRegex(ca.InputError, "same Poisson's ratio"):
            modes.in_material("wood")

    def test_of_a_file_that_sounds(self):
        path = self.folder / "bar.glb"
        made = run("export-gltf", "bar", "-m", "steel", "--audio-modes", "6", "-o", path)
        self.assertEqual(made.returncode, 0, made.stderr)
        modes = ca.Modes.load(path)
        known = run_json("modes", path)
        self.assertEqual(list(modes.frequencies), self.column(known, "frequency_hz"))
        self.assertEqual(list(modes.decay_rates), self.column(known, "decay_rate_per_s"))
        struck = self.folder / "bar.wav"
        self.assertEqual(run("strike", path, "--at", "0,0,0", "-o", struck).returncode, 0)
        sound = modes.strike(at=(0, 0, 0))
        numpy.testing.assert_array_equal(numpy.asarray(sound), read_float_wav(struck))
        again = pickle.loads(pickle.dumps(modes))
        self.assertEqual(list(again.decay_rates), list(modes.decay_rates))
        for arguments, words in (((path, "steel"), "brings its own material"), ((path,), "no node \"lid\""),
                                 ((self.folder / "bar.h5",), "does not say its material")):
            with self.assertRaisesRegex(ca.InputError, words):
                ca.Modes.load(*arguments, **({"node": "lid"} if "lid" in words else {}))

    def test_of_a_bell_are_of_bell_bronze_where_no_material_is_named(self):
        self.assertEqual(ca.shapes()["bell"]["usual_material"], "bell_bronze")
        usual = ca.shape("bell").modes(**BAND, pitch_cents="off")
        self.assertEqual([m.name for m in usual.materials], ["bell_bronze"])
        named = ca.shape("bell").modes("bell_bronze", **BAND, pitch_cents="off")
        self.assertEqual(list(usual.frequencies), list(named.frequencies))
        with self.assertRaisesRegex(ca.InputError, "no material of bowl"):
            ca.shape("bowl").modes()

    def test_materials_are_objects(self):
        ceramic = ca.materials["ceramic"]
        self.assertIn("Hiner", ceramic.source)
        self.assertEqual(ca.material(ceramic.text()).replace(name="ceramic", source=ceramic.source, group="ceramic"),
                         ceramic)
        self.assertEqual(list(ca.materials), [m["name"] for m in run_json("list", "materials")])
        self.assertEqual({m.group for m in ca.materials.values() if "bronze" in m.name}, {"metal"})
        for preset in ca.materials.values():
            again = ca.material(preset.text())
            for name in ("density", "damping", "alphas"):
                numpy.testing.assert_equal(getattr(again, name), getattr(preset, name), preset.name)
            for name in ("youngs_modulus", "poisson_ratio"):  # of an anisotropic solid, means of the stiffness
                numpy.testing.assert_allclose(getattr(again, name), getattr(preset, name), err_msg=preset.name,
                                              rtol=0 if preset.stiffness is None else 1e-14)
        heavier = ceramic.replace(density=2 * ceramic.density)
        one, two = (ca.shape("bar").modes(m, **BAND, pitch_cents="off").frequencies[0] for m in (ceramic, heavier))
        self.assertAlmostEqual(one / two, 2 ** 0.5, places=9)

    def test_of_stored_sets_say_what_is_known_of_them(self):
        modes = ca.shape("bar").modes("steel", **BAND)
        modes.save(self.folder / "stored.h5")
        stored = ca.Modes.load(self.folder / "stored.h5", "steel")
        self.assertEqual(stored.certificate, modes.certificate)
        self.assertTrue({"mesh", "solver", "timing"}.isdisjoint(stored.document))
        dataset = ca.build(BARS, output=self.folder / "bars")
        path = next((self.folder / "bars" / "modes").glob("*.h5"))
        of_build = ca.Modes.load(path, "steel", group="set-000")
        self.assertEqual(len(of_build), len(of_build.frequencies))
        self.assertEqual(dataset.samples, 12)

    def test_and_objects_are_copied_and_pickled(self):
        for made in (ca.Object(*WEDGE, length=0.2), ca.shape("bar", longest_side=0.1), ca.shape("bar", length=0.2),
                     ca.shape("turned", profile=[(0, 0), (0.02, 0), (0.02, 0.05), (0, 0.05)])):
            numpy.testing.assert_array_equal(*(
                one.modes("glass", max_frequency=1e5, max_modes=3, pitch_cents="off").frequencies
                for one in (made, pickle.loads(pickle.dumps(made)))))
        modes = ca.shape("bar").modes("steel", **BAND)
        for again in (pickle.loads(pickle.dumps(modes)), copy.deepcopy(modes)):
            numpy.testing.assert_array_equal(again.shapes, modes.shapes)
            self.assertEqual(again.document, modes.document)
            self.assertEqual((repr(again), again.materials), (repr(modes), modes.materials))
            numpy.testing.assert_array_equal(again.strike((0.01, 0, 0)), modes.strike((0.01, 0, 0)))

    def test_take_quantities_with_units(self):
        numpy.testing.assert_array_equal(*(
            ca.shape("bowl", longest_side=length).modes("steel", **BAND, pitch_cents="off").frequencies
            for length in (0.12, "12 cm")))
        self.assertEqual(ca.materials["steel"].replace(density="7.9 g/cm^3").density, 7900)
        with self.assertRaisesRegex(ca.InputError, "longest_side: .*kg"):
            ca.shape("bar", longest_side="12 kg")

    def test_a_doubtful_mesh_is_warned_of(self):
        vertices = numpy.array(WEDGE[0]) * 1000
        with self.assertRaisesRegex(ca.InputError, "millimetres"):
            ca.Object(vertices, WEDGE[1]).modes("glass", **BAND)
        self.assertEqual(len(ca.Object(vertices, WEDGE[1], unit="mm").modes("glass", max_frequency=1e5, max_modes=3,
                                                                            pitch_cents="off")), 3)


class Sounds(ModuleTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.modes = ca.shape("bowl").modes("ceramic", **BAND)

    def test_a_strike_is_the_command_lines(self):
        from_program = self.folder / "program.wav"
        known = run_json("strike", "bowl", "-m", "ceramic", *OPTIONS, "--at", "0.06,0,0.02", "--seconds", "0.4 s",
                         "--listener", "0,0,1", "--set", "room.dimensions=[5, 4, 3]", "--set", "room.rt60=0.6",
                         "-o", from_program, "--cache", "")
        sound = self.modes.strike((0.06, 0, 0.02), seconds=0.4, listeners=[(0, 0, 1)],
                                  room={"dimensions": [5, 4, 3], "rt60": 0.6})
        sound.save(self.folder / "module.wav")
        self.assertEqual((self.folder / "module.wav").read_bytes(), from_program.read_bytes())
        for name in ("modes", "unit", "peak", "position_m", "direction", "impulse_ns", "record"):
            self.assertEqual(sound.document[name], known[name], name)
        self.assertEqual(set(sound.document["effects"]), set(known["effects"]))
        self.assertEqual(*([(e["name"], e["enabled"]) for e in made["scene"]] for made in (sound.document, known)))
        self.assertEqual((sound.shape, sound.dtype, sound.rate, sound.unit), ((17640,), numpy.float32, 44100, "Pa"))

    def test_features_fits_comparisons_and_estimates_are_the_command_lines(self):
        at = (0.06, 0, 0.02)
        one, two = self.modes.strike(at), self.modes.strike(at, contact_time="0.4 ms", impulse="0.01 N s")
        one.save(self.folder / "one.wav")
        two.save(self.folder / "two.wav")
        features = ca.features(one)
        known = run_json("features", self.folder / "one.wav")
        self.assertEqual(features.document["features"], known["features"])
        self.assertEqual(list(features.frequencies), [f["frequency_hz"] for f in known["features"]])
        fit = ca.fit(features, model="rayleigh")
        known = run_json("fit", self.folder / "one.wav")
        self.assertEqual(fit.parameters, {name: known["parameters"][name] for name in fit.parameters})
        self.assertEqual(sorted(fit.parameters), ["alpha1", "alpha2"])
        self.assertTrue(fit.confidence95["alpha1"][0] <= fit.parameters["alpha1"] <= fit.confidence95["alpha1"][1])
        pairs = ca.fit((features.frequencies, features.decay_rates), estimator="least_squares")
        self.assertEqual(pairs.estimator, "least_squares")
        comparison = ca.compare(one, two)
        known = run_json("compare", self.folder / "one.wav", self.folder / "two.wav")
        self.assertEqual(comparison.document["jnd"], known["jnd"])
        self.assertEqual(comparison.matched, known["matched"])
        estimate = ca.estimate(one, ca.shape("bowl"), at, poisson_ratio=0.2, density=2700, metric="hybrid", **BAND)
        known = run_json("estimate", self.folder / "one.wav", "bowl", "--at", "0.06,0,0.02", "--poisson-ratio", "0.2",
                         "--density", "2700", "--metric", "hybrid", *OPTIONS, "--cache", "")
        self.assertEqual(estimate.specific_modulus, known["specific_modulus_m2_per_s2"])
        self.assertEqual(estimate.youngs_modulus, known["youngs_modulus_pa"])
        self.assertEqual(len(estimate.resynthesis), len(one))
        pitches = ca.estimate([one, two], ca.shape("bowl"), poisson_ratio=0.2, **BAND)
        document = run("estimate", self.folder / "one.wav", "bowl", self.folder / "two.wav", "--poisson-ratio", "0.2",
                       *OPTIONS, "--cache", "", "--json")
        known = json.loads(document.stdout)
        self.assertEqual(pitches.specific_modulus, known["specific_modulus_m2_per_s2"])
        self.assertEqual(pitches.undetermined, known["undetermined"])
        self.assertIsNone(pitches.resynthesis)
        for result in (features, fit, comparison, estimate, pitches):
            self.assertIn("<table>", result._repr_html_())

    def test_force_over_time(self):
        contact, rate = 1e-3, 384000
        pulse = 20 * (1 - numpy.cos(2 * numpy.pi * numpy.arange(385) / 384))  # 0.02 N s over 1 ms
        sound = self.modes.strike((0.0616, -0.0005, 0.0139), force=pulse, force_rate="384 kHz")
        expected = self.modes.strike((0.0616, -0.0005, 0.0139), contact_time=contact)
        self.assertLess(abs(sound - expected).max(), 1e-3 * abs(expected).max())
        self.assertAlmostEqual(sound.document["impulse_ns"], 0.02, 6)
        numpy.testing.assert_array_equal(
            self.modes.strike((0.0616, -0.0005, 0.0139), force=ca.Sound(pulse.astype(numpy.float32), rate)),
            self.modes.strike((0.0616, -0.0005, 0.0139), force=pulse.astype(numpy.float32), force_rate=rate))
        for wrong, words in (({"force": pulse}, "rate is missing"), ({"force": pulse, "force_rate": 0}, "sample rate"),
                             ({"force": [0, 0], "force_rate": 1}, "nothing would sound"),
                             ({"force": [[1.0]], "force_rate": 1}, "one row"),
                             ({"force": pulse, "force_rate": rate, "impulse": 1}, "impulse or contact_time"),
                             ({"force": pulse, "force_rate": rate, "striker": {"kind": "metal"}}, "striker")):
            with self.assertRaisesRegex((ca.InputError, TypeError), words):
                self.modes.strike(**wrong)

    def test_keys_of_a_scene_and_arguments_are_one_scene(self):
        for sound in (self.modes.strike(rate="22.05 kHz"), self.modes.strike(scene={"audio": {"sample_rate": 22050}})):
            self.assertEqual((sound.rate, len(sound)), (22050, 22050))
        numpy.testing.assert_array_equal(self.modes.strike(contact_time=0, seed=3),
                                         self.modes.strike(contact_time="0 s", seed=3))
        for twice, words in (({"rate": 8000, "scene": {"audio": {"sample_rate": 16000}}}, "sample_rate is an argument"),
                             ({"room": {"rt60": 1}, "scene": {"room": {"rt60": 2}}}, "room is an argument"),
                             ({"impulse": 1, "scene": {"strikes": {"impulse": 2}}}, "impulse is an argument"),
                             ({"striker": {"kind": "wood"}, "contact_time": "1 ms"}, "striker gives")):
            with self.assertRaisesRegex(ca.InputError, words):
                self.modes.strike(**twice)

    def test_a_sound_is_an_array_and_keeps_its_rate(self):
        sound = self.modes.strike(listeners=[(0, 0, 1), (0, 1, 0)])
        self.assertEqual((sound[0].rate, (2 * sound).rate, sound[:, 100:].rate), (44100, 44100, 44100))
        for number in (sound.max(), sound.sum(), sound[0, 3], numpy.abs(sound).max()):
            self.assertIs(type(number), numpy.float32)
        (sound / numpy.float64(3) + numpy.zeros(sound.shape)).save(self.folder / "third.wav")
        self.assertEqual((self.folder / "third.wav").read_bytes()[22], 2)  # channels
        numpy.testing.assert_array_equal(ca.Sound(numpy.array([16384, -32768], numpy.int16), 8000), [0.5, -1])
        self.assertTrue(numpy.isnan(sound[0, ::2].rate) and numpy.isnan(sound[0][[3, 5]].rate))
        for wrong in (sound[None], ca.Sound(sound, numpy.nan), sound[:, ::2]):
            with self.assertRaisesRegex(ca.InputError, "is no sound"):
                wrong.save(self.folder / "wrong.wav")

    def test_whole_numbers_are_parts_of_full_scale(self):
        sound = self.modes.strike((0.06, 0, 0.02))
        sound /= numpy.abs(sound).max() / 0.9
        floats, words = ca.features(sound), ca.features(numpy.round(sound * 32768).astype(numpy.int16), 44100)
        self.assertAlmostEqual(words.amplitudes.max() / floats.amplitudes.max(), 1, places=2)
        for wrong in (sound.astype(numpy.int64), sound.astype(complex), ["a"]):
            with self.assertRaisesRegex(ca.InputError, "samples"):
                ca.features(wrong, 44100)

    def test_what_is_shown_is_short(self):
        sound = self.modes.strike((0.06, 0, 0.02))
        for made in (ca.features(sound), ca.fit(ca.features(sound)), ca.compare(sound, sound), ca.plan(BARS)):
            self.assertLess(len(repr(made)), 5000, type(made))

    def test_mel_is_a_datasets(self):
        spectrogram = ca.mel(self.modes.strike())
        self.assertEqual((spectrogram.shape, spectrogram.dtype), ((64, 25), numpy.float32))
        self.assertEqual(ca.mel(numpy.zeros((3, 44100)), 44100).shape, (3, 64, 25))

    def test_plots_are_drawn_where_there_is_matplotlib(self):
        try:
            import matplotlib
        except ImportError:
            self.skipTest("needs python3-matplotlib")
        matplotlib.use("Agg")
        sound = self.modes.strike()
        features = ca.features(sound)
        for made in (self.modes.plot(), self.modes.plot_shape(0), sound.plot(), features.plot(),
                     ca.fit(features).plot()):
            path = self.folder / "plot.png"
            made.figure.savefig(path)
            self.assertGreater(path.stat().st_size, 5000)


class Errors(ModuleTest):
    def words(self, *arguments):
        """What the program says, without its name."""
        result = run(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        return result.stderr.strip().removeprefix("carillon: ")

    def test_have_the_command_lines_words(self):
        with self.assertRaises(ca.InputError) as raised:
            ca.shape("bowl", radus=0.07)
        self.assertEqual(str(raised.exception), self.words("modes", "bowl:radus=70mm", "-m", "glass"))
        self.assertIsInstance(raised.exception, ValueError)
        with self.assertRaises(ca.InputError) as raised:
            ca.shape("bowl").modes("glas")
        self.assertEqual(str(raised.exception), self.words("modes", "bowl", "-m", "glas"))
        with self.assertRaises(ca.FileError):
            ca.Object.load("missing.obj")
        modes = ca.shape("bar").modes("steel", max_modes=3)
        with self.assertRaisesRegex(ca.InputError, "use estimator least_squares"):
            ca.fit(ca.features(modes.strike()))

    def test_name_the_argument(self):
        modes = ca.shape("bar").modes("steel", **BAND, pitch_cents="off")
        for wrong, words in (({"at": (1, 2)}, "at must be three numbers"), ({"direction": (0, 0, 0)}, "no length"),
                             ({"room": {"dimension": [1, 2, 3]}}, "dimension"), ({"rate": -1}, "rate: must lie"), ({"scene": {"audio": {"sample_rate": -1}}}, "sample_rate: must"),
                             ({"scene": {"strikes": {"impulse": "2 kg"}}}, "strikes.impulse")):
            with self.assertRaisesRegex(ca.InputError, words):
                modes.strike(**wrong)
        for wrong, words in (({"order": 7}, "order"), ({"min_frequency": 1e4, "max_frequency": 1e3}, "max_frequency"),
                             ({"solver": "guess"}, "solver: unknown value")):
            with self.assertRaisesRegex(ca.ConfigError, words):
                ca.shape("bar").modes("steel", **wrong)
        with self.assertRaisesRegex(ca.InputError, "face 1 names vertex 9 of 4"):
            ca.Object(WEDGE[0], [[0, 1, 2], [0, 1, 9]])
        with self.assertRaisesRegex(ca.InputError, "is nan"):
            ca.features(numpy.full(44100, numpy.nan), 44100)
        with self.assertRaisesRegex(TypeError, "sample rate"):
            ca.features(numpy.zeros(44100))

    def test_arguments_out_of_range_are_errors_that_name_them(self):
        modes = ca.shape("bar").modes("steel", **BAND, pitch_cents="off")
        sound = modes.strike((0.01, 0, 0))
        bar = ca.shape("bar")
        nan = float("nan")
        for call, words in (
                (lambda: ca.estimate(sound, bar, (0, 0, 0), poisson_ratio=0.3, starts=0), "starts: 0"),
                (lambda: ca.estimate(sound, bar, (0, 0, 0), poisson_ratio=0.3, density="7 m"), "density: "),
                (lambda: ca.features(numpy.zeros((0, 44100)), 44100), "channels, samples"),
                (lambda: ca.features(sound, max_features=0), "max_features: 0"),
                (lambda: ca.features(sound, min_level=3), "min_level: 3"),
                (lambda: ca.features(sound, method="guess"), "method: there is no guess"),
                (lambda: ca.features(sound, rt60=[0.4, "1 m"]), "rt60: "),
                (lambda: ca.mel(numpy.zeros((0, 44100)), 44100), "channels, samples"),
                (lambda: ca.mel(sound, bands=10**9), "bands"),
                (lambda: ca.compare(sound, sound, loudest_level=200), "loudest_level"),
                (lambda: ca.fit(([100, nan], [1, 2])), "not finite"),
                (lambda: ca.fit(([100, 200], [1, -2])), "feature 1"),
                (lambda: ca.fit(), "nothing to fit"),
                (lambda: ca.fit([100, 200, 300], [1, 2, 3]), "no pair"),
                (lambda: ca.fit(([100, 200], [1])), "no pair"),
                (lambda: ca.features(sound, max_features=2.5), "max_features must be a whole"),
                (lambda: ca.features(sound, min_level=nan), "min_level is nan"),
                (lambda: ca.features(sound, onset=-1), "onset must be"),
                (lambda: ca.features(sound, contact_time=-1), "contact_time must be"),
                (lambda: ca.features(sound, rt60=-1), "rt60"),
                (lambda: ca.mel([1.0, nan], 44100), "not finite"),
                (lambda: ca.compare(sound, numpy.asarray(sound), other_rate="2 m"), "other_rate: "),
                (lambda: ca.estimate(sound, "bar", (0, 0, 0), poisson_ratio=0.3), "object must be"),
                (lambda: ca.estimate(sound, bar, (0, 0, 0), poisson_ratio=0.3, seed=-1), "seed: -1"),
                (lambda: bar.modes(None), "a material is"),
                (lambda: bar.modes("steel", solver="fast"), "solver"),
                (lambda: ca.shape(5), "family must be a text"),
                (lambda: ca.shape("bowl", profile=[(0, 0), (1, 0), (1, 1)]), "a profile is all"),
                (lambda: modes.strike(repeat=10**9), "repeat: "),
                (lambda: modes.strike(seed=1.5), "seed must be a whole"),
                (lambda: modes.strike(scene=[]), "scene must be a mapping"),
                (lambda: modes.strike(scene={"audio": 5}), "scene's audio must be a mapping"),
                (lambda: modes.strike(listeners=(0, 0, 1)), "listener 0 must be three"),
                (lambda: modes.strike(rate=44100.5), "rate must be whole"),
                (lambda: ca.plan(BARS, set=["a=1"]), "set must be a mapping"),
                (lambda: ca.build(BARS, ranks="2"), "ranks must be a whole"),
                (lambda: ca.Object(WEDGE[0], [[0, 1, 2.5]]), "faces must be whole"),
                (lambda: ca.Object(WEDGE[0], [[True, False, True]]), "faces must be whole"),
                (lambda: ca.Object(*WEDGE, length=-1), "must not be negative"),
                (lambda: ca.Object(*WEDGE, thickness=nan), "thickness is nan"),
                (lambda: ca.shape("turned", profile=[(0, 0), (nan, 0), (1, 1)]), "profile: row 1"),
                (lambda: modes.in_material("steel", size=0), "size of 0"),
                (lambda: modes.strike(interval="2 m"), "interval: "),
                (lambda: ca.build(BARS, ranks=0), "ranks: 0")):
            with self.assertRaisesRegex(ca.InputError, words):
                call()
        self.assertEqual(ca.mel(numpy.zeros((2, 0)), 44100).shape[:2], (2, 64))

if __name__ == "__main__":
    unittest.main()
