"""modes, strike, inspect, list, plan and preview, and what they say of objects that cannot be solved; mistakes.py
has what is wrong with a command line."""
import json
import math
import os
import unittest
import unittest.mock

import numpy
from msh_files import msh_2, msh_4, two_part_bar
from program import CONFIGS, NO_PICTURES, FolderTest, pictures, run, run_json

CUBE = """OFF
8 6 0
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
4 3 2 1 0
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
"""


TILE = ("tile:length=100mm,width=80mm,thickness=6mm", "-m", "steel", "--max-modes", "8", "--order",
        "2", "--element-size", "20 mm")
# Between what the matrices of TILE take and what their factor would take beside them.
LIMIT = "10 MiB"


def cents(a, b):
    return 1200 * math.log2(a / b)


def read_float_wav(path):
    """Samples of a 32-bit float WAV with one channel."""
    data = path.read_bytes()
    at = 12
    while data[at:at + 4] != b"data":
        at += 8 + int.from_bytes(data[at + 4:at + 8], "little")
    return numpy.frombuffer(data[at + 8:], dtype="<f4")


class Modes(FolderTest):
    def test_steel_bar_has_the_pitch_of_beam_theory(self):
        # Slender free bar: f1 = 22.3733 / (2 pi L^2) sqrt(E I / (rho A)); Timoshenko's shear and
        # rotary inertia lower it by well under 1 % at L / h = 50.
        result = run_json("modes", "bar:length=500mm,width=20mm,height=10mm", "-m", "steel",
                          "--max-frequency", "1kHz")
        f1 = 22.3733 / (2 * math.pi * 0.5**2) * math.sqrt(2e11 / 7850) * 0.01 / math.sqrt(12)
        self.assertLess(abs(cents(result["modes"][0]["frequency_hz"], f1)), 10)
        self.assertTrue(result["certificate"]["complete"])
        self.assertEqual(result["certificate"]["rigid_modes"], 6)

    def test_decay_follows_rayleigh(self):
        result = run_json("modes", "tile", "-m", "steel", "--max-modes", "5")
        for mode in result["modes"]:
            omega = 2 * math.pi * mode["frequency_hz"]
            self.assertAlmostEqual(mode["decay_rate_per_s"] / (0.5 * (5 + 3e-8 * omega**2)), 1, 9)

    def test_length_scales_a_mesh(self):
        mesh = self.write("cube.off", CUBE)
        small = run_json("modes", mesh, "-m", "steel", "--length", "50 mm", "--max-frequency",
                         "60 kHz", "--order", 2)
        large = run_json("modes", mesh, "-m", "steel", "--length", "100 mm", "--max-frequency",
                         "30 kHz", "--order", 2)
        self.assertGreater(len(small["modes"]), 10)
        for a, b in zip(small["modes"], large["modes"]):
            self.assertAlmostEqual(a["frequency_hz"] / b["frequency_hz"], 2, 6)

    def test_ranks_agree(self):
        one = run_json("--cache", "", "modes", "ring", "-m", "steel", ranks=1)
        two = run_json("--cache", "", "modes", "ring", "-m", "steel", ranks=2)
        for a, b in zip(one["modes"], two["modes"], strict=True):
            self.assertLess(abs(a["frequency_hz"] / b["frequency_hz"] - 1), 1e-8)

    def test_a_body_of_revolution_is_solved_by_harmonics_too(self):
        solid = run_json("modes", "ring", "-m", "steel", "--order", "4")
        for ranks in (1, 2):
            turned = run_json("modes", "ring", "-m", "steel", ranks=ranks)
            self.assertEqual(turned["solver"], {"name": "axisymmetric", "reason": "ring is a body of revolution"})
            self.assertEqual(len(turned["modes"]), len(solid["modes"]))
            for a, b in zip(turned["modes"], solid["modes"]):
                self.assertLess(abs(cents(a["frequency_hz"], b["frequency_hz"])), 5)
                self.assertLess(a["pitch_error_cents"], 1)
            finer = run_json("modes", "ring", "-m", "steel", "--pitch-cents", "0.05", ranks=ranks)
            self.assertLess(max(mode["pitch_error_cents"] for mode in finer["modes"]), 0.05)
            self.assertEqual([m["harmonic"] for m in turned["modes"][:2]], [2, 2])
        answer = run("modes", "bar", "-m", "steel", "--solver", "axisymmetric")
        self.assertEqual(answer.returncode, 2)
        self.assertIn("bar is no body of revolution", answer.stderr)
        self.assertEqual(solid["solver"], {"name": "tetrahedra", "reason": "--order is given"})

    def test_second_run_comes_from_the_cache(self):
        arguments = ("modes", "disc", "-m", "glass", "--max-modes", "10")
        first = run_json(*arguments)
        second = run_json(*arguments)
        self.assertIn("modes from cache_s", second["timing"])
        self.assertNotIn("solve_s", second["timing"])
        self.assertEqual(first["modes"], second["modes"])



class Solvers(FolderTest):
    """Switches of the solve as a user types them, and what the certificate says of them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.usual = run_json("modes", *TILE)

    def compare(self, eigen_solver, linear_solver, tolerance, *arguments):
        result = run_json("modes", *TILE, *arguments)
        for a, b in zip(result["modes"], self.usual["modes"], strict=True):
            self.assertLess(abs(a["frequency_hz"] / b["frequency_hz"] - 1), tolerance)
        certificate = result["certificate"]
        self.assertEqual(certificate["eigen_solver"], eigen_solver)
        self.assertEqual(certificate["linear_solver"], linear_solver)
        self.assertEqual(certificate["count_verified"], linear_solver == "direct")

    def test_usual_solvers(self):
        certificate = self.usual["certificate"]
        self.assertEqual(certificate["eigen_solver"], "block_lanczos")
        self.assertEqual(certificate["linear_solver"], "direct")
        self.assertTrue(certificate["count_verified"])

    def test_krylov_schur(self):
        self.compare("krylov_schur", "direct", 1e-9, "--cache", "", "--eigen-solver", "krylov_schur")

    def test_iterative(self):
        self.compare("lobpcg", "iterative", 1e-7, "--linear-solver", "iterative")

    def test_a_small_limit_makes_automatic_iterative(self):
        self.compare("lobpcg", "iterative", 1e-7, "--memory-limit", LIMIT)

    def test_few_unknowns_are_solved_densely_and_say_so(self):
        mesh = self.write("few.msh", msh_2(*two_part_bar(2)))
        result = run_json("modes", mesh, "-m", "steel", "--order", "1", "--eigen-solver", "krylov_schur")
        self.assertEqual(result["certificate"]["eigen_solver"], "dense")

    def test_pitch_targets_that_are_missed_show(self):
        wav = self.folder / "missed.wav"
        for command, *more in (["modes"], ["strike", "-o", wav]):
            result = run(command, *TILE, "--max-elements", "400", "--pitch-cents", "0.01", *more,
                         "--json")
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertIn("pitch target of 0.01 cents is not met", result.stderr)
            self.assertFalse(json.loads(result.stdout)["pitch_target"]["met"])
        self.assertTrue(wav.exists())
        met = run("modes", *TILE, "--pitch-cents", "1000")
        self.assertEqual((met.returncode, met.stderr), (0, ""))


class Tetrahedra(FolderTest):
    """MSH files: used as they are, physical groups have materials."""

    def test_versions_agree_and_groups_have_materials(self):
        bar = two_part_bar()
        old = self.write("old.msh", msh_2(*bar))
        new = self.write("new.msh", msh_4(*bar))
        steel = run_json("modes", old, "-m", "steel")
        self.assertEqual(steel["mesh"]["elements"], 48)
        both = run_json("modes", new, "-m", "left=steel,right=steel")
        for a, b in zip(steel["modes"], both["modes"], strict=True):
            self.assertAlmostEqual(a["frequency_hz"] / b["frequency_hz"], 1, 9)
        mixed = run_json("modes", new, "-m", "left=steel,right=wood", "--max-frequency", "5kHz")
        rho = [7850, 750]
        self.assertAlmostEqual(mixed["mass_kg"], 0.1 * 0.02 * 0.02 * sum(rho), 6)
        # Damping lies between that of the two materials at every mode.
        for mode in mixed["modes"]:
            omega = 2 * math.pi * mode["frequency_hz"]
            d = [0.5 * (a1 + a2 * omega**2) for a1, a2 in ((5, 3e-8), (60, 2e-6))]
            self.assertGreater(mode["decay_rate_per_s"], d[0])
            self.assertLess(mode["decay_rate_per_s"], d[1])

    def test_groups_in_a_build(self):
        mesh = self.write("bar.msh", msh_4(*two_part_bar()))
        config = self.write("groups.yaml", f"objects:\n  - mesh: {mesh}\n"
                            "    materials: {left: steel, right: glass}\n"
                            "strikes: {per_object: 2}\naudio: {seconds: 0.1 s}\n")
        summary = run_json("build", config, "-o", self.folder / "groups")
        self.assertEqual((summary["samples"], summary["failed_tasks"]), (2, 0))

    def test_wrong_groups_are_named(self):
        mesh = self.write("wrong.msh", msh_2(*two_part_bar(2)))
        for text in ("left=steel", "left=steel,right=glass,middle=wood"):
            result = run("modes", mesh, "-m", text)
            self.assertEqual(result.returncode, 2)
            self.assertIn("physical group", result.stderr)


class Strike(FolderTest):
    def test_peaks_lie_at_the_modes(self):
        # Listening by measuring: the strongest partials of the sound are modes of the object.
        body = ("disc:radius=80mm,thickness=4mm", "-m", "steel")
        wav = self.folder / "disc.wav"
        run_json("strike", *body, "-o", wav, "--seconds", "2", "--at", "0.07,0.01,0.002")
        modes = [m["frequency_hz"] for m in run_json("modes", *body)["modes"]]
        sound = read_float_wav(wav)
        self.assertEqual(len(sound), 88200)
        spectrum = numpy.abs(numpy.fft.rfft(sound * numpy.hanning(len(sound))))
        frequency = numpy.fft.rfftfreq(len(sound), 1 / 44100)
        strongest = [i for i in range(1, len(spectrum) - 1)
                     if spectrum[i] > 0.05 * spectrum.max() and spectrum[i] > spectrum[i - 1]
                     and spectrum[i] > spectrum[i + 1]]
        self.assertGreater(len(strongest), 2)
        for peak in strongest:
            self.assertLess(min(abs(frequency[peak] - f) for f in modes), 1.0)

    def test_listener_gives_pressure(self):
        wav = self.folder / "bowl.wav"
        result = run_json("strike", "sphere:radius=30mm", "-m", "glass", "-o", wav, "--listener",
                          "0,0,1", "--max-frequency", "40kHz", "--sample-rate", "96000")
        self.assertEqual(result["unit"], "Pa")
        sound = read_float_wav(wav)
        flight = int((1 - 0.03) / 343 * 96000)  # from the surface
        self.assertEqual(numpy.abs(sound[:flight - 1]).max(), 0)
        self.assertGreater(numpy.abs(sound).max(), 0)


class Errors(FolderTest):
    def expect(self, code, text, *arguments):
        result = run(*arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(text, result.stderr + result.stdout)
        self.assertNotIn("terminate", result.stderr)

    def test_with_json_are_one_document_too(self):
        for ranks in (None, 2):
            result = run("--json", "modes", "bar", "-m", "stel", ranks=ranks)
            self.assertEqual(result.returncode, 2)
            error = json.loads(result.stdout)["error"]
            self.assertEqual(error["kind"], "InputError")
            self.assertIn("stel", error["message"])
            self.assertIn("did you mean \"steel\"?", error["message"])
            self.assertIn("carillon list materials", error["hint"])
            self.assertIn(f"carillon: {error['message']}\n  hint: {error['hint']}\n", result.stderr)
        missing = json.loads(run("--json", "features", "missing.wav").stdout)["error"]
        self.assertEqual((missing["kind"], "missing.wav" in missing["message"]), ("FileError", True))

    def test_units_are_suggested(self):
        header, corners, faces = CUBE[:10], CUBE[10:-60], CUBE[-60:]
        mesh = self.write("mm.off", header + corners.replace("1", "120") + faces)
        self.expect(2, "--unit mm or --length 0.12m", "modes", mesh, "-m", "steel")

    def test_limits_end_with_the_remedy(self):
        self.expect(2, "would fit", "modes", *TILE, "--max-elements", "10")
        self.expect(2, "the iterative linear solver", "modes", *TILE, "--linear-solver", "direct",
                    "--memory-limit", "1MB")
        self.expect(2, "raise the memory limit", "modes", *TILE, "--memory-limit", "1MB")
        self.expect(2, "976.6 KiB", "modes", *TILE, "--memory-limit", "1MB")
        mesh = self.write("large.msh", msh_2(*two_part_bar()))
        self.expect(2, "raise --max-elements", "modes", mesh, "-m", "steel", "--max-elements", "3")

    def test_refused_meshes(self):
        # Two bars that meet in one edge alone.
        nodes, tetrahedra = two_part_bar(2)
        turned = [(-x, y, -z) for x, y, z in nodes]
        number = {p: i for i, p in enumerate(nodes)}
        for p in turned:
            number.setdefault(p, len(number))
        second = [(part, [number[turned[t]] for t in tet]) for part, tet in tetrahedra]
        mesh = self.write("edge.msh", msh_2(list(number), tetrahedra + second))
        self.expect(2, "edge", "modes", mesh, "-m", "steel")

    def test_options_that_would_do_nothing_are_refused(self):
        for option, value in (("--length", "3 cm"), ("--thickness", "2 mm")):
            self.expect(2, f"{option} does not apply", "modes", *TILE, option, value)
        mesh = self.write("given.msh", msh_2(*two_part_bar(2)))
        for option, value in (("--element-size", "3 cm"), ("--thickness", "2 mm")):
            self.expect(2, f"{option} does not apply", "modes", mesh, "-m", "steel", option, value)
        for option, value in (("--order", "3"), ("--linear-solver", "automatic"),
                              ("--memory-limit", "16 GiB"), ("--max-elements", "200000")):
            self.expect(2, f"{option} does not apply", "modes", "ring", "-m", "steel",
                        "--solver", "axisymmetric", option, value)

    def test_one_bad_file_does_not_hide_the_others(self):
        good = self.write("good.off", CUBE)
        result = run("inspect", self.write("bad.off", "OFF\n1 2\n"), good, "--json")
        self.assertEqual(result.returncode, 2)
        self.assertIn("error", json.loads(result.stdout)[0])
        self.assertTrue(json.loads(result.stdout)[1]["clean"])


class Others(FolderTest):
    def test_inspect_tells_what_is_wrong(self):
        mesh = self.write("open.off", CUBE.replace("8 6 0", "8 5 0").rsplit("4 3 0", 1)[0])
        diagnosis = run_json("inspect", mesh)[0]
        self.assertFalse(diagnosis["closed"])
        self.assertEqual(diagnosis["boundary_edges"], 4)
        self.assertTrue(run_json("inspect", self.write("cube.off", CUBE))[0]["clean"])

    def test_lists(self):
        for what in ("materials", "shapes", "effects", "models", "strikers", "supports", "noises"):
            self.assertGreater(len(run_json("list", what)), 0)
            self.assertEqual(run("list", what).returncode, 0)
        steel = {m["name"]: m for m in run_json("list", "materials")}["steel"]
        self.assertEqual(steel["youngs_modulus_pa"], 2e11)

    def test_lists_are_searched_by_words(self):
        found = run_json("list", "materials", "bronze")
        self.assertEqual({m["name"] for m in found}, {"phosphor_bronze", "aluminium_bronze", "bell_bronze"})
        self.assertTrue(all(m["group"] == "metal" and m["source"] for m in found))
        for m in found:
            self.assertAlmostEqual(m["bar_speed_m_per_s"] ** 2, m["youngs_modulus_pa"] / m["density_kg_m3"], places=3)
        woods = run_json("list", "materials", "wood handbook", "MAPLE")
        self.assertEqual([m["name"] for m in woods], ["maple"])
        table = run("list", "materials", "bell_bronze").stdout
        self.assertIn("C91300", table)
        self.assertNotIn("C91300", run("list", "materials").stdout)
        self.assertEqual(len(run("list", "materials").stdout.splitlines()), len(run_json("list", "materials")) + 3)
        self.assertEqual(run_json("list", "materials", "unobtainium"), [])
        self.assertIn("no materials with unobtainium", run("list", "materials", "unobtainium").stdout)
        self.assertEqual([s["name"] for s in run_json("list", "shapes", "sound bow")], ["bell"])
        carpets = run_json("list", "walls", "carpet")
        self.assertEqual({w["name"] for w in carpets}, {"carpet_thin", "carpet", "carpet_heavy"})
        self.assertTrue(all(len(w["absorption"]) == 8 for w in carpets))
        self.assertIn("Everest", run("list", "walls", "brick_painted").stdout)

    def test_a_bell_is_of_bell_bronze_where_no_material_is_named(self):
        options = ["--pitch-cents", "off", "--max-frequency", "5 kHz"]
        usual, bronze, iron = (run_json("modes", "bell", *options, *material)
                               for material in ([], ["-m", "bell_bronze"], ["-m", "iron"]))
        self.assertEqual(usual["materials"], ["bell_bronze"])
        self.assertEqual(usual["modes"], bronze["modes"])
        self.assertEqual(iron["materials"], ["iron"])
        self.assertIn("material: bell_bronze, the usual one of the family bell", run("modes", "bell", *options).stdout)
        self.assertNotIn("usual", run("modes", "bell", *options, "-m", "iron").stdout)
        struck = run_json("strike", "bell", *options, "-o", self.folder / "bell.wav")
        self.assertEqual(struck["materials"], ["bell_bronze"])
        refused = run("modes", "bowl")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("no material of bowl is given", refused.stderr)
        plan = self.write("bells.yaml", "objects: [{shape: bell}, {shape: bell, name: cast, materials: [iron]}]\n"
                          "modes: {max_frequency: 5 kHz}\naudio: {seconds: 0.1}\n")
        self.assertEqual(run("plan", plan).returncode, 0)

    def test_walls_of_a_room_have_names(self):
        options = ["bar", "-m", "steel", "--pitch-cents", "off", "--max-frequency", "5 kHz", "--listener", "0,0,1",
                   "--set", "room.dimensions=[5, 4, 3]", "--set", "room.source=[2, 2, 1]"]
        def tail(*walls):
            heard = run_json("strike", *options, *walls, "-o", self.folder / "room.wav")
            return heard["record"]["room_rt60"][3]
        bare = tail("--set", "room.walls=concrete")
        carpeted = tail("--set", "room.walls={others: concrete, floor: carpet_heavy}")
        self.assertGreater(bare, 4 * carpeted)
        self.assertEqual(bare, tail("--set", "room.absorption=[0.01, 0.01, 0.02, 0.02, 0.02, 0.05]"))
        refused = run("strike", *options, "--set", "room.walls=conkrete", "-o", self.folder / "none.wav")
        self.assertEqual(refused.returncode, 2)
        self.assertIn('did you mean "concrete"?', refused.stderr)

    def test_effects_are_listed_with_key_and_stage(self):
        effects = {e["name"]: e for e in run_json("list", "effects")}
        self.assertEqual((effects["tail"]["key"], effects["tail"]["stage"]), ("room", "audio"))
        self.assertEqual(effects["recording"]["stage"], "full scale")

    def test_presets_of_scenes_are_listed_with_values_and_sources(self):
        strikers = {s["name"]: s for s in run_json("list", "strikers")}
        self.assertEqual(strikers["metal"]["youngs_modulus_pa"], 2e11)
        self.assertIn("assumed", strikers["finger"]["source"])
        supports = {s["name"]: s for s in run_json("list", "supports")}
        self.assertGreater(supports["table"]["coefficient_s_per_m"],
                           supports["string"]["coefficient_s_per_m"])
        self.assertTrue(all(s["source"] for s in supports.values()))
        noises = {n["name"]: n for n in run_json("list", "noises")}
        self.assertIn("-3 dB", noises["pink"]["spectrum"])

    def test_plan_says_what_runs_and_why(self):
        plan = run_json("plan", CONFIGS / "smoke.yaml", "--set", "effects.frames=off")
        effects = {e["name"]: e for e in plan["effects"]}
        self.assertFalse(effects["radiation"]["enabled"])
        self.assertIn("listener", effects["radiation"]["reason"])
        self.assertTrue(effects["mel"]["enabled"])
        solver = {e["name"]: e for e in plan["solver"]}
        self.assertEqual(solver["eigen_solver"]["value"], "block_lanczos")
        self.assertEqual(solver["memory_limit"]["value"], 16 << 30)
        text = run("plan", CONFIGS / "smoke.yaml", "--set", "effects.frames=off",
                   "--set", "solver.pitch_cents=5").stdout
        self.assertIn("5 cents", text)
        self.assertIn("16.0 GiB", text)

    @unittest.skipUnless(NO_PICTURES, "the program draws pictures")
    def test_pictures_are_refused_by_their_key_where_none_are_drawn(self):
        for name, key in (("smoke", "camera"), ("dominoes", "motion.camera")):
            result = run("plan", CONFIGS / f"{name}.yaml")
            self.assertEqual(result.returncode, 2)
            self.assertRegex(result.stderr, rf"{name}.yaml:\d+:\d+: {key}: .*without pictures")
            self.assertIn("-DCARILLON_RENDER=ON", result.stderr)

    @pictures
    def test_preview_makes_its_three_files(self):
        out = self.folder / "preview"
        run_json("preview", CONFIGS / "smoke.yaml", "--sample", "0", "-o", out)
        self.assertGreater(len(read_float_wav(out / "sound.wav")), 1000)
        self.assertTrue((out / "spectrogram.png").exists())
        self.assertEqual(len(list((out / "pictures").glob("*.png"))), 1)

    def test_help_and_version(self):
        self.assertEqual(run("--help").returncode, 0)
        first, *libraries = run("--version").stdout.splitlines()
        self.assertRegex(first, r"^carillon \d+\.\d+\.\d+(\+\S+)?$")
        names = {line.split(" ", 1)[0] for line in libraries}
        self.assertLessEqual({"cgal", "gmsh", "hdf5", "mpi", "petsc", "slepc"}, names)
        [offscreen] = [line.split()[1] for line in libraries if line.startswith("offscreen ")]
        self.assertIn(offscreen, ("none",) if NO_PICTURES else ("osmesa", "egl"))
        self.assertEqual(run("build", "--help").returncode, 0)


class Start(FolderTest):
    """What a command line starts."""

    def starts_mpi(self, *arguments):
        with unittest.mock.patch.dict(os.environ, OMPI_MCA_mpi_show_mca_params="enviro"):
            result = run(*arguments)
        return "mpi_show_mca_params" in result.stdout + result.stderr

    def test_nothing_starts_mpi_that_needs_none(self):
        if not self.starts_mpi("plan", CONFIGS / "smoke.yaml", "--set", "effects.frames=off"):
            self.skipTest("this MPI does not tell that it starts")
        cube = self.write("cube.off", CUBE)
        for words in (["--version"], ["--help"], ["build", "--help"], ["train", "--help"], [],
                      ["modes"], ["modes", "bar", "-m", "steel", "--order", "9"],
                      ["train", "--no-such-option"], ["list", "materials"],
                      ["completion", "bash"], ["manual"], ["inspect", cube, "--length", "10cm"]):
            self.assertFalse(self.starts_mpi(*words), words)

    def test_one_rank_tells_what_is_wrong_with_a_command_line(self):
        result = run("modes", "bar", "-m", "steel", "--order", "9", ranks=2)
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stderr.count("--order"), 1, result.stderr)

    def test_one_rank_helps(self):
        for words, part in ((["--version"], "petsc "), (["modes", "--help"], "--max-modes")):
            result = run(*words, ranks=2)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stdout.count(part), 1, result.stdout)

    def test_one_rank_does_what_needs_no_ranks(self):
        result = run("list", "materials", "--json", ranks=2)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertGreater(len(json.loads(result.stdout)), 3)
        missing = run("inspect", "no-such.obj", ranks=2)
        self.assertEqual(missing.returncode, 2)
        self.assertEqual(missing.stderr.count("carillon: no-such.obj"), 1, missing.stderr)


if __name__ == "__main__":
    unittest.main()
