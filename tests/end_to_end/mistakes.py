"""What people get wrong at the command line, and what they are told: at once, in a line or three, with the place
and what would be right."""
import time
import typing
import unittest

from program import TIMEOUT_FACTOR, FolderTest, run, run_json

TILE = ("tile:length=100mm,width=80mm,thickness=6mm", "-m", "steel", "--order", "2", "--element-size", "20 mm",
        "--max-modes", "5", "--max-frequency", "8kHz")
# Half a minute and more, if anything of it were done before the mistake is found.
LONG = ("bar:length=50cm,width=10cm,height=10cm", "-m", "steel", "--order", "3", "--element-size", "5mm",
        "--max-elements", "10000000", "--max-unknowns", "100000000")
SMALL = """name: small
seed: 3
materials: [steel]
objects:
  - {shape: tile, parameters: {length: 10 cm, width: 8 cm, thickness: 6 mm}}
modes: {max_modes: 5, max_frequency: 8 kHz, order: 2, element_size: 2 cm}
strikes: {per_object: 2}
audio: {seconds: 0.1 s, sample_rate: 22050 Hz}
"""
CUBE = "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n" \
       "4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"
# Of a program that broke, not of one that answers.
NEVER = ("terminate", "what():", "Traceback", "PETSC ERROR", "MPI_ABORT", "Segmentation", "internal", "std::", "Error:",
         "basic_string", "nlohmann", "YAML::", "System error", "--length m")


class Row(typing.NamedTuple):
    name: str
    words: str  # of the command line, split at blanks; a blank within a word is written ~
    says: tuple  # parts of what standard error has
    code: int = 2
    seconds: float = 8  # on a busy machine; a start of the program under MPI is most of it
    lines: int = 3


STRIKE = "strike {tile} -o x.wav"
COMMANDS = (
    Row("a command with a slip", "stirke bar", ('"stirke" is no command', 'did you mean "strike"?', "carillon --help")),
    Row("help of a command with a slip", "stirke --help", ('"stirke" is no command', 'did you mean "strike"?')),
    Row("a command that there is not", "help", ('"help" is no command', "carillon --help lists the commands")),
    Row("no command", "", ("a command is missing", "carillon --help")),
    Row("an option with a slip", "modes bar --matrial steel",
        ("--matrial: carillon modes has no such option", 'did you mean "--material"?', "carillon modes --help")),
    Row("an option with a slip and a value", "modes bar -m steel --max-mdes=3", ("--max-mdes", 'did you mean "--max-modes"?')),
    Row("a common option with a slip", "modes bar -m steel --jsn", ('did you mean "--json"?',)),
    Row("an option that there is not", "check small --xyzzy", ("--xyzzy: carillon check has no such option",)),
    Row("an option twice", "modes bar -m steel -m glass", ("--material is given 2 times", "once")),
    Row("a number twice", "modes bar -m steel --order 2 --order 3", ("--order is given 2 times",)),
    Row("no value", "modes bar -m", ("--material: its value is missing",)),
    Row("a word too many", "plan small.yaml other.yaml", ('"other.yaml": one word more than carillon plan takes',)),
    Row("two datasets", "check small small", ('"small": one word more',)),
    Row("no mesh", "modes -m steel", ("mesh is required", "carillon modes --help")),
    Row("no material", "modes bar", ("no material of bar is given", "add -m NAME")),
    Row("no output", "strike bar -m steel", ("--output is required",)),
    Row("a word of no set", "modes bar -m steel --solver tetrahedral",
        ('--solver: "tetrahedral" is none of automatic, tetrahedra, axisymmetric', 'did you mean "tetrahedra"?')),
    Row("a format of no set", "export small --format wave", ('"wave" is none of wav, webdataset, lhotse', 'mean "wav"?')),
    Row("a list that there is not", "list material", ("is none of", 'did you mean "materials"?')),
    Row("options that exclude each other", "export-faust {tile} --at 0,0,0.01 --points 3 -o x.dsp",
        ("--at and --points both say where", "give one of them")),
    Row("an option that needs another", "identify sound.wav -m trained --at 0,0,1", ("--at", "--scene")),
)
NUMBERS = (
    Row("a mass for a length", "modes cube.off -m steel --length 5kg",
        ('--length: "5kg" is a mass; a length is wanted', "m, cm, mm, um, km, in")),
    Row("a time for a frequency", "modes bar -m steel --max-frequency 5s",
        ('--max-frequency: "5s" is a time; a frequency is wanted', "Hz, kHz, MHz")),
    Row("an unknown unit", "modes cube.off -m steel --length 5ft", ('--length: "5ft": unknown unit "ft"',)),
    Row("a unit with a slip", "modes bar -m steel --max-frequency 5kHZz", ('did you mean "kHz"?',)),
    Row("no number", "modes bar -m steel --max-frequency nan", ('--max-frequency: "nan" is not a finite number',)),
    Row("an infinite number", "modes bar -m steel --element-size inf", ('--element-size: "inf" is not a finite number',)),
    Row("a number beyond all", "{strike} --at 1e400,0,0", ('--at: "1e400" is beyond the range of a double',)),
    Row("a negative frequency", "modes bar -m steel --max-frequency=-5", ("-5 Hz is empty", "--min-frequency is 0 or more")),
    Row("a negative length", "modes cube.off -m steel --length=-5cm", ("--length -5cm: a length is positive",)),
    Row("no length of a file", "modes cube.off -m steel --length 0", ("--length 0: a length is positive",)),
    Row("a negative element size", "modes bar -m steel --element-size=-5mm", ("--element-size -5mm: a length is positive",)),
    Row("no length", "modes bar -m steel --element-size 0", ("--element-size 0: a length is positive",)),
    Row("a parameter of no length", "modes bar:length=0,width=1cm -m steel", ("bar: length must be a positive length",)),
    Row("a parameter's kind", "modes bar:length=3kg -m steel", ('bar:length: "3kg" is a mass; a length is wanted',)),
    Row("an order out of range", "modes bar -m steel --order 9", ("--order: Value 9 not in range 1 to 4",)),
    Row("an order in words", "modes bar -m steel --order two", ("--order", "1 to 4")),
    Row("no strike", "{strike} --repeat 0", ("--repeat: Value 0 not in range 1 to 10000",)),
    Row("a negative seed", "{strike} --seed=-1", ("--seed", "a whole number from 0 on is wanted")),
    Row("a seed in words", "{strike} --seed abc", ('--seed: a whole number from 0 on is wanted, not "abc"',)),
    Row("a size in millimetres", "modes bar:length=120,width=20,height=10 -m steel", ("120 m", "millimetres")),
    Row("a size too small", "modes bar:length=0.2mm,width=0.1mm,height=0.05mm -m steel", ("outside 1 mm to 10 m",)),
    Row("a memory limit", "modes {tile} --memory-limit=-1~GiB", ("--memory-limit", "between 1 B and 2^60 B")),
    Row("no limit of memory", "modes {tile} --memory-limit 1e12GiB", ("--memory-limit", "between 1 B and 2^60 B")),
    Row("no memory", "modes {tile} --memory-limit 0", ("--memory-limit", "between 1 B and 2^60 B")),
    Row("more memory than there is", "modes {tile} --memory-limit 1e300", ("--memory-limit", "between 1 B and 2^60 B")),
    Row("a mass for a memory", "modes {tile} --memory-limit 3kg", ("--memory-limit", "units of a memory size")),
    Row("a negative time", "{strike} --seconds=-1", ("seconds",)),
    Row("a negative impulse", "{strike} --impulse=-1Ns", ("impulse",)),
    Row("a broken rate", "{strike} --sample-rate 44100.7", ("--sample-rate", "whole")),
    Row("Poisson's ratio", "modes bar -m youngs_modulus=7e10,poisson_ratio=0.9,density=2700",
        ("Poisson's ratio must lie between -1 and 0.5", "0.9")),
)
POINTS = (
    Row("a point far off", "{strike} --at 5,2,0",
        ("the point struck, (5, 2, 0) m, is", "m off the object", "the nearest on it is (0.05, 0.04, 0) m",
         "metres in the object's own coordinates")),
    Row("a point far off a turned object", "strike bowl -m steel -o x.wav --at 10,0,0", ("m off the object", "metres")),
    Row("units on some", "{strike} --at 5cm,2,0", ("--at", "some of these have a unit and others none", "5 cm, 2 cm, 0 cm")),
    Row("two coordinates", "{strike} --at 5,2cm", ("--at 5,2cm: 2 values instead of three", "5,2,0cm")),
    Row("four coordinates", "{strike} --listener 0,0,0,1", ("--listener 0,0,0,1: 4 values instead of three",)),
    Row("words for coordinates", "{strike} --at a,b,c", ('--at: "a" is not a finite number',)),
    Row("a time for coordinates", "{strike} --at 5,2,0s", ("--at:", "is a time; a length is wanted")),
    Row("no direction", "{strike} --direction 0,0,0", ("--direction has no length",)),
    Row("a listener in the object", "{strike} --listener 0,0,0", ("listener 0 is inside the object", "off the surface")),
    Row("a point of an instrument far off", "export-faust {tile} --at 1,1,1 -o x.dsp", ("m off the object",)),
    Row("a point of a recording far off", "estimate sound.wav {tile} --at 5,2,0", ("m off the object",)),
)
NAMES = (
    Row("a material with a slip", "modes bar -m stel", ('unknown material "stel"', 'did you mean "steel"?')),
    Row("a shape with a slip", "modes bowel -m steel", ('there is no shape family "bowel"', 'did you mean "bowl"?')),
    Row("a parameter with a slip", "modes bar:widht=2cm -m steel", ('bar has no parameter "widht"', "width")),
    Row("a material's field with a slip", "modes bar -m youngs_modulus=7e10,poisson_ratio=0.19,densty=2700",
        ("densty", 'did you mean "density"?')),
    Row("a material's field that is missing", "modes bar -m youngs_modulus=7e10,poisson_ratio=0.19", ("density",)),
    Row("a column of strikes", "plan strikes.yaml", ("impulse_n", 'did you mean "impulse_ns"?')),
    Row("a row that there is not", "regenerate small --sample 99", ('small has no sample "99"', "from 0 to 1", "keys look like")),
    Row("a key with a slip", "regenerate small --sample tile-000/stel/1/strike-0000",
        ("did you mean tile-000/steel/1/strike-0000?",)),
    Row("a sample that is not planned", "preview small.yaml --sample tile-000/steel/1/strike-0009",
        ("no sample", "did you mean tile-000/steel/1/strike-000")),
)
PATHS = (
    Row("no such mesh", "modes not/there.obj -m steel", ("not/there.obj: no such file",)),
    Row("a folder for a mesh", "modes folder -m steel", ("folder", "is a folder, and a mesh is wanted")),
    Row("a picture for a mesh", "modes picture.png -m steel", (".png is no kind of mesh file", ".obj, .off, .ply, .stl")),
    Row("an empty mesh", "modes empty.stl -m steel", ("empty.stl",)),
    Row("no such recording", "features missing.wav", ("missing.wav: no such file",)),
    Row("a folder for a recording", "features folder", ("folder is a folder", "a recording is wanted")),
    Row("a picture for a recording", "features picture.png", ("picture.png is a PNG picture", "a recording is wanted")),
    Row("a picture to fit", "fit picture.png", ("picture.png is a PNG picture",)),
    Row("no such configuration", "build missing.yaml", ("missing.yaml: no such file",)),
    Row("a recording for a configuration", "plan sound.wav",
        ("sound.wav is a WAV file; a YAML configuration is wanted", "features")),
    Row("a picture for a configuration", "build picture.png", ("picture.png is a PNG picture; a YAML configuration",)),
    Row("a program for a configuration", "plan program", ("program is a program; a YAML configuration is wanted",)),
    Row("bytes for a configuration", "plan bytes.yaml", ("bytes.yaml:1:2: a control character", "UTF-8")),
    Row("a folder for a configuration", "plan folder", ("folder is a folder; a YAML configuration is wanted",)),
    Row("a dataset to build", "build small",
        ("small is a dataset; a YAML configuration is wanted", "check, regenerate, export and report take it",
         "small/configuration.yaml")),
    Row("a dataset to train", "train small", ("small is a dataset; a YAML configuration is wanted",)),
    Row("a dataset to evaluate", "evaluate small", ("small is a dataset; a YAML configuration is wanted",)),
    Row("a dataset to identify with", "identify sound.wav -m small", ("small is a dataset: no trained network", "carillon train")),
    Row("classifiers to check", "check trained",
        ("trained is no dataset: it is a folder of trained classifiers", "carillon identify CLIP.wav --models trained")),
    Row("classifiers to regenerate", "regenerate trained --sample 0", ("it is a folder of trained classifiers",)),
    Row("classifiers to export", "export trained --format wav", ("it is a folder of trained classifiers",)),
    Row("classifiers to train", "train trained", ("trained is a folder of trained classifiers; a YAML",)),
    Row("a configuration to check", "check small.yaml",
        ("small.yaml is no dataset: it is a configuration", "carillon build small.yaml makes a dataset")),
    Row("a configuration to export", "export small.yaml --format wav", ("it is a configuration", "carillon build small.yaml")),
    Row("a folder to check", "check folder", ("folder is no dataset", "that `carillon build` made")),
    Row("no folder to check", "check missing", ("missing is no dataset: there is no such folder",)),
    Row("a configuration to report", "report small.yaml -o r.html", ("small.yaml is a configuration, and a folder is wanted",)),
    Row("nothing to report", "report folder -o r.html", ("folder: nothing to report",)),
)
# Whatever stands in the way is found before the solve, which would take LONG.
OUTPUTS = (
    Row("a file of the kernel's", "strike {long} -o /proc/x.wav", ("/proc/x.wav: cannot be written", "name a place")),
    Row("a file in a file", "strike {long} -o text.txt/x.wav", ("text.txt/x.wav: cannot be written: text.txt is no folder",)),
    Row("a folder for a file", "strike {long} -o folder", ("folder: cannot be written: it is a folder", "folder/NAME")),
    Row("a device for a file", "strike {long} -o /dev/null", ("/dev/null: cannot be written: it is no regular file",)),
    Row("modes in a file", "modes {long} -o text.txt/x.h5", ("text.txt is no folder",)),
    Row("an instrument", "export-faust {long} -o text.txt/x.dsp", ("text.txt is no folder",)),
    Row("a model", "export-gltf {long} --modes 3 -o /proc/x.glb", ("/proc/x.glb: cannot be written",)),
    Row("an estimate", "estimate sound.wav {long} --at 0,0,5cm -o text.txt/x.wav --metric hybrid --poisson-ratio 0.2", ("text.txt is no folder",)),
    Row("a texture", "texture brick -o text.txt/x.png", ("text.txt is no folder",)),
    Row("a sample", "regenerate small --sample 0 -o folder", ("folder: cannot be written: it is a folder",)),
    Row("a preview", "preview small.yaml -o text.txt", ("text.txt: cannot be written: it is a file, and a folder is wanted",)),
    Row("a report", "report small -o folder", ("folder: cannot be written: it is a folder",)),
    Row("an export", "export small --format wav -o text.txt", ("text.txt",)),
    Row("a dataset", "build small.yaml -o /proc/x", ("/proc/x",)),
    Row("a dataset in a file", "build small.yaml -o text.txt/x", ("text.txt/x",)),
    Row("a study", "accuracy study.yaml -o text.txt/x", ("text.txt is no folder",)),
)
CONFIGURATIONS = (
    Row("a key with a slip", "plan slip.yaml", ("slip.yaml:4:5: objects[0].cuont", 'did you mean "count"?')),
    Row("an empty configuration", "plan empty.yaml", ("empty.yaml:1:1: objects", "no objects", "objects: [{shape: bar")),
    Row("no objects", "build none.yaml", ("none.yaml:1:10: objects: the configuration has no objects",)),
    Row("tabs", "plan tabs.yaml", ("tabs.yaml:2:", "YAML forbids tabs in indentation; use spaces")),
    Row("a key twice", "plan twice.yaml", ("twice.yaml:2:1: name: the key stands twice; first at line 1",)),
    Row("a list", "plan list.yaml", ("list.yaml:1:1: a configuration is a mapping of keys", "`key: value`")),
    Row("an unknown key", "plan small.yaml --set strikes.per_objct=1", ("--set strikes.per_objct=1", 'did you mean "per_object"?')),
    Row("--set without =", "build small.yaml --set strikes", ('--set strikes: there is no "="', "audio.seconds=2")),
    Row("--set of another type", "build small.yaml --set strikes.per_object=many",
        ("strikes.per_object: a whole number from 1 to 1000000 is wanted, not \"many\"",)),
    Row("--set of another kind", "plan small.yaml --set audio.seconds=2kg", ('audio.seconds: "2kg" is a mass; a time is wanted',)),
    Row("--set beyond a bound", "plan small.yaml --set strikes.per_object=0", ("strikes.per_object: 0 is out of range", "from 1 to")),
    Row("a name that leads elsewhere", "build small.yaml --set name=../other",
        ('--set name=../other: name: "../other" is no name of a folder', "--output names another folder")),
    Row("a name that is a path", "plan small.yaml --set name=a/b", ('name: "a/b" is no name of a folder',)),
    Row("a hidden name", "plan small.yaml --set name=.a", ('name: ".a" is no name of a folder',)),
    Row("an empty name", "build unnamed.yaml", ("unnamed.yaml:1:7: name: is empty",)),
    Row("a name with blanks", "plan small.yaml --set name='a~b'", ("is no name of a folder", "letters, digits, - _ and .")),
    Row("a study's name", "accuracy study.yaml --set name=../other", ("is no name of a folder",)),
    Row("units on some of a list", "plan small.yaml --set listeners=[{{position:~[5cm,2,0]}}]",
        ("some of these have a unit and others none", "5 cm, 2 cm, 0 cm")),
)


class Mistakes(FolderTest):
    """Each row of the tables."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.put("small.yaml", SMALL)
        cls.put("slip.yaml", "objects:\n  - shape: bar\n    materials: [steel]\n    cuont: 3\n")
        cls.put("empty.yaml", "")
        cls.put("none.yaml", "objects: []\nmaterials: [steel]\n")
        cls.put("tabs.yaml", "objects:\n\t- {shape: bar}\n")
        cls.put("twice.yaml", "name: a\nname: b\n")
        cls.put("list.yaml", "- a\n- b\n")
        cls.put("unnamed.yaml", 'name: ""\nmaterials: [steel]\nobjects: [{shape: bar}]\n')
        cls.put("bytes.yaml", "a\0b")
        cls.put("strikes.csv", "x_m,y_m,z_m,impulse_n,contact_time_s\n0,0,0.006,0.01,0.0002\n")
        cls.put("strikes.yaml", SMALL.replace("{per_object: 2}", "{csv: strikes.csv}"))
        cls.put("study.yaml", "name: study\nmaterials: [steel]\nobjects: [{shape: bar}]\n")
        cls.put("text.txt", "text\n")
        cls.put("cube.off", CUBE)
        cls.put("empty.stl", "")
        (cls.folder / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
        (cls.folder / "program").write_bytes(b"\x7fELF\2\1\1\0")
        (cls.folder / "folder").mkdir()
        # What a training leaves, as far as its kind is told by it.
        (cls.folder / "trained" / "evaluation" / "models").mkdir(parents=True)
        run_json("build", "small.yaml", cwd=cls.folder)
        run_json("strike", *TILE, "-o", "sound.wav", "--seconds", "0.5", cwd=cls.folder)

    @classmethod
    def put(cls, name, text):
        (cls.folder / name).write_text(text)

    def files(self):
        """Everything in the folder but the cache, with times and sizes."""
        return {str(path): (path.stat().st_mtime_ns, path.stat().st_size) for path in self.folder.rglob("*")
                if "cache" not in path.relative_to(self.folder).parts[:1] and path.is_file()}

    def words(self, row):
        text = row.words.format(tile="{tile}", long="{long}", strike=STRIKE.format(tile="{tile}"))
        words = []
        for word in text.split():
            words += {"{tile}": TILE, "{long}": LONG}.get(word, [word.replace("~", " ").replace("'", "")])
        return words

    def try_all(self, rows):
        self.assertEqual(len({row.name for row in rows}), len(rows))
        for row in rows:
            with self.subTest(row.name, words=row.words):
                before = self.files()
                begin = time.monotonic()
                result = run(*self.words(row), cwd=self.folder, timeout=60)
                took = time.monotonic() - begin
                self.assertEqual(result.returncode, row.code, result.stderr)
                for part in row.says:
                    self.assertIn(part, result.stderr)
                for part in NEVER:
                    self.assertNotIn(part, result.stderr)
                self.assertLessEqual(len(result.stderr.splitlines()), row.lines, result.stderr)
                self.assertEqual(result.stdout, "")
                self.assertLess(took, row.seconds * TIMEOUT_FACTOR)
                self.assertEqual(self.files(), before)

    def test_commands_and_options(self):
        self.try_all(COMMANDS)

    def test_numbers_and_units(self):
        self.try_all(NUMBERS)

    def test_points(self):
        self.try_all(POINTS)

    def test_names(self):
        self.try_all(NAMES)

    def test_paths(self):
        self.try_all(PATHS)

    def test_outputs(self):
        self.try_all(OUTPUTS)

    def test_configurations(self):
        self.try_all(CONFIGURATIONS)


if __name__ == "__main__":
    unittest.main()
