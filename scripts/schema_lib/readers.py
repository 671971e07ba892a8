"""What the program's readers of configurations ask for: a tree of keys."""
import json
import pathlib
import re
import shutil
import subprocess
import wave

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
EVERY = "*"  # in paths: any name of the user's
NUMBER = r"([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?"

# Mappings whose keys are the user's names, though their reader asks for those it knows; and the other way round.
NAMED = {("evaluate", "classification", "published", EVERY), ("sweep", "keys"), ("search", EVERY, "keys")}
NOT_NAMED = {("MATERIAL",), ("MATERIAL", "damping")}


class Failure(Exception):
    pass


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """YAML 1.2's core schema, as editors and the program's reader have it: `off` and `2026-03-31` are texts."""


Loader.yaml_implicit_resolvers = {}
for tag, pattern, first in (("null", r"~|null|Null|NULL|", "~nN\0"), ("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
                            ("int", "[-+]?[0-9]+", "-+0123456789"),
                            ("float", rf"[-+]?{NUMBER}", "-+.0123456789"), ("merge", "<<", "<")):
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(f"^(?:{pattern})$"),
                                 [c if c != "\0" else "" for c in first])
Loader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(loader.construct_scalar(node)))
Loader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(loader.construct_scalar(node)))


def load(text):
    return yaml.load(text, Loader)


class Reader:
    """The program's readers of configurations, in a process of their own."""

    def __init__(self, program):
        self.process = subprocess.Popen([str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.words = json.loads(self.process.stdout.readline())

    def read(self, reader, file):
        self.process.stdin.write(json.dumps({"reader": reader, "file": str(file)}) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise Failure(f"{file}: the reader ended")
        return json.loads(line)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def prepare(folder):
    """The files that configurations of tests/schema and configs/ name, in a folder."""
    for file in (ROOT / "tests" / "schema").iterdir():
        if file.suffix not in (".cpp", ".txt"):
            shutil.copy(file, folder)
    for file in (ROOT / "configs").glob("*-materials.yaml"):
        shutil.copy(file, folder)
    for name in ("noises", "rooms", "sounds", "stored"):
        (folder / name).mkdir()
    for k in range(3):  # one for each part
        with wave.open(str(folder / "noises" / f"{k}.wav"), "wb") as file:
            file.setparams((1, 2, 8000, 0, "NONE", ""))
            file.writeframes(bytes(range(1, 251)) * 640)
    for k in range(9):  # likewise, of both splits
        with wave.open(str(folder / "rooms" / f"{k}.wav"), "wb") as file:
            file.setparams((1, 2, 8000, 0, "NONE", ""))
            file.writeframes(bytes((0, 64, k, 0)) + bytes(160))
    (folder / "stored" / "index.h5").touch()


def reader_of(configuration):
    """The reader of one of configs/."""
    if any(key in configuration for key in ("levels", "pitch_targets")):
        return "accuracy"
    if all(isinstance(value, dict) and "density" in value for value in configuration.values()):
        return "materials"
    return "evaluate" if {"train", "evaluate"} & set(configuration) else "build"


def configurations():
    """(name, reader, configuration) of all that keys are heard from."""
    for number, entry in enumerate(load((ROOT / "tests/schema/configurations.yaml").read_text())):
        yield f"tests/schema/configurations.yaml[{number}]", entry["reader"], entry["configuration"]
    for file in sorted((ROOT / "configs").glob("*.yaml")):
        configuration = load(file.read_text())
        reader = reader_of(configuration)
        if "modelnet" in str(configuration):
            reader = "build"  # its files are not here
        yield f"configs/{file.name}", reader, configuration


class Node:
    """What is known of one key."""

    def __init__(self, path):
        self.path = path
        self.asks = []
        self.children = {}
        self.named = False
        self.places = set()       # where it stands, in all configurations
        self.wanted_at = set()    # where it must stand
        self.defaults = set()

    def below(self, step):
        if step not in self.children:
            self.children[step] = Node((*self.path, step))
        return self.children[step]

    def __str__(self):
        return dotted(self.path)


def dotted(path):
    return ".".join(path).replace(".[]", "[]").lstrip(".")


ROOTS = {"build": (), "evaluate": (), "accuracy": ("STUDY",), "materials": ("MATERIAL",)}


def hear(tree, root, asked, source):
    """Puts what was asked of one configuration where it belongs."""
    named = {tuple(ask["path"]) for ask in asked if ask["kind"] == "names"}
    for ask in asked:
        steps, node, concrete = list(ask["path"]), tree, (source,)
        for step in root:
            node = node.below(step)
        if root == ("MATERIAL",):
            concrete += tuple(steps[:1])  # the material's name, which is the user's
            steps = steps[1:]
        whole = tuple(ask["path"][:len(ask["path"]) - len(steps)])
        for step in steps:
            node.places.add(concrete)
            user = (node.named or whole in named or node.path in NAMED) and node.path not in NOT_NAMED
            node.named = user
            if node.path in (("MATERIAL",), ("MATERIAL", "damping")) and re.fullmatch("alpha([3-9]|[1-9][0-9]+)", step):
                break  # a pattern has these
            node = node.below("[]" if step.startswith("[") else EVERY if user else step)
            concrete, whole = (*concrete, step), (*whole, step)
        else:
            if ask["kind"] == "names":
                node.places.add(concrete)
                continue
            node.asks.append(ask)
            if not ask["optional"]:
                node.wanted_at.add(concrete[:-1])
            if "default" in ask:
                node.defaults.add(ask["default"])


def heard(reader, folder):
    """The tree of all keys."""
    tree = Node(())
    for name, kind, configuration in configurations():
        file = folder / "heard.yaml"
        file.write_text(json.dumps(configuration))
        answer = reader.read(kind, file)
        if answer["refusal"]:
            raise Failure(f"{name}: {answer['refusal']}")
        hear(tree, ROOTS[kind], answer["asked"], name)
    return tree
