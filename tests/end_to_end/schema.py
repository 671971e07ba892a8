"""JSON Schemas of configurations: they say what the program's readers take, no more keys and no fewer."""
import collections
import copy
import json
import pathlib
import re
import sys
import unittest
import zlib

import jsonschema
import yaml
from program import CARILLON, CONFIGS, DOCS, FolderTest, run

ROOT = CONFIGS.parent
READER = pathlib.Path(CARILLON).parent / "tests" / "configuration_reader"
sys.path.insert(0, str(ROOT / "scripts"))
from schema_lib import readers, schemas  # noqa: E402

DOCUMENTS = {"build": "configuration", "evaluate": "configuration", "accuracy": "configuration", "materials": "materials"}
MEASURED = ("quantity", "range", "ranges", "quantities")
# What a key is given in place of its value.
TRIED = (5, 0.5, -1, 0, "12 cm", "3 µs", "5 m N s", "5 N*s/m", "20 kHz", "40 %", "2 GB", "30°", "1e3", "+2", "x", True,
         "yes", "off", None, [], [1, 2], [1, "2 cm"], [1, 2, 3], ["x", "y"], {})


def schema_of(document):
    return json.loads((CONFIGS / f"{document}.schema.json").read_text())


def validator(schema):
    return jsonschema.Draft7Validator(schema)


def at(value, path):
    for step in path:
        value = value[int(step[1:-1]) if step.startswith("[") else step]
    return value


def changed(configuration, path, value):
    """A copy with another value; `...` takes the key away."""
    whole = copy.deepcopy(configuration)
    inner, last = at(whole, path[:-1]), path[-1]
    last = int(last[1:-1]) if last.startswith("[") else last
    if value is ...:
        del inner[last]
    else:
        inner[last] = value
    return whole


def has(configuration, path):
    try:
        at(configuration, path)
    except (KeyError, IndexError, TypeError, ValueError):
        return False
    return True


def general(path):
    return tuple("[]" if step.startswith("[") else step for step in path)


def properties(schema):
    """Every name of a key in a schema."""
    if isinstance(schema, list):
        return set().union(*map(properties, schema)) if schema else set()
    if not isinstance(schema, dict):
        return set()
    names = set(schema["properties"]) if isinstance(schema.get("properties"), dict) else set()
    return names.union(*(properties(value) for key, value in schema.items() if key not in ("default", "enum")))


class SchemaTest(FolderTest):
    """Has the readers and the schemas."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        readers.prepare(cls.folder)
        cls.reader = readers.Reader(READER)
        cls.schemas = {document: schema_of(document) for document in ("configuration", "materials")}

    @classmethod
    def tearDownClass(cls):
        cls.reader.__exit__()
        super().tearDownClass()

    @classmethod
    def read(cls, kind, configuration):
        file = cls.folder / "case.yaml"
        file.write_text(json.dumps(configuration))
        return cls.reader.read(kind, file)


def unlike(_, ask):
    """Values that no reader takes there."""
    path, kind = ask["path"], ask["kind"]
    if not ask["alone"] or path[-2:-1] == ["keys"]:  # it may be of another kind, too
        return
    if kind in MEASURED:
        wrong = ("5 furlongs", "x", "5 kg s", True)
        for value in wrong if kind in ("quantity", "range") else [[one] * ask.get("count", 3) for one in wrong]:
            yield path, value, True
        yield path, {"x": 1}, True
        if "low" in ask:
            yield path, -1, True
            yield path, "-1", True
    elif kind == "integer":
        high = int(ask["high"]) + 1 if ask["high"] < 2**53 else 2**63
        for value in (int(ask["low"]) - 1, high, 0.5, "x", "2 m", ["x"], None):
            yield path, value, True
    elif kind in ("choice", "flag"):
        for value in ("no_such_word", 5, [1], {"x": 1}, None):
            yield path, value, True
    elif kind == "text":
        yield path, {"x": 1}, True
        yield path, None, True
    elif kind == "texts":
        yield path, [["x"]], True
    elif kind == "child":
        yield path, 5, True
    elif kind == "children":
        yield path, 5, True
        yield path, [5], True


def unknown_key(configuration, ask):
    if ask["kind"] == "child" and isinstance(at(configuration, ask["path"]), dict):
        yield [*ask["path"], "no_such_key"], 1, True
    if ask["kind"] == "children":
        for k in range(len(at(configuration, ask["path"]) or [])):
            yield [*ask["path"], f"[{k}]", "no_such_key"], 1, True


def anything(_, ask):
    """A fourth of the values, others for each key."""
    for value in TRIED[zlib.crc32(ask["path"][-1].encode()) % 4::4]:
        yield ask["path"], value, False


def words(_, ask):
    for word in ask.get("allowed", ()):
        yield ask["path"], word, False


class Agreement(SchemaTest):
    """Both ways: what a schema refuses the reader refuses, too, and the other way round where a key is unknown, a unit
    or a word is wrong, or a value is of another kind."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cases = [(name, kind, configuration, cls.read(kind, configuration))
                     for name, kind, configuration in readers.configurations()]

    def distinct(self):
        """(name, kind, configuration, ask) of each key once, where tests/schema has it."""
        seen, kinds = set(), collections.defaultdict(set)
        for _, kind, _, answer in self.cases:
            for ask in answer["asked"]:
                kinds[kind, general(ask["path"])].add(ask["kind"])
        for name, kind, configuration, answer in self.cases:
            if name.startswith("configs/"):
                continue
            for ask in answer["asked"]:
                path = ask["path"]
                # What a build has is tried where a build is read, which is faster.
                other = kind == "evaluate" and path and path[0] not in ("train", "search", "evaluate", "recordings", "data")
                key = (kind, general(path), ask["kind"])
                if not path or other or key in seen or not has(configuration, path):
                    continue
                seen.add(key)
                yield name, kind, configuration, {**ask, "alone": len(kinds[kind, general(path)]) == 1}

    def complaints(self, tried, others=None):
        """Where a schema and its reader do not agree on what `tried` makes of an ask: (value, whether both refuse)."""
        checks = {kind: validator((others or self.schemas)[document]) for kind, document in DOCUMENTS.items()}
        found = []
        for name, kind, configuration, ask in self.distinct():
            for path, value, both in tried(configuration, ask):
                case = changed(configuration, path, value)
                # The one section says it, and is checked faster.
                alone = kind in ("build", "evaluate") and path[0] not in ("data", "recordings")
                valid = checks[kind].is_valid({path[0]: case[path[0]]} if alone and path[0] in case else case)
                if valid and not both:
                    continue
                refusal = self.read(kind, case)["refusal"]
                if valid or not refusal:
                    found.append(f"{name}: {'.'.join(path)}: {value!r}: "
                                 f"{'the schema takes it' if valid else 'the schema refuses it'}; {refusal or 'the reader takes it'}")
        return found

    def test_all_configurations_are_valid(self):
        self.assertGreater(len(self.cases), 50)
        for name, kind, configuration, answer in self.cases:
            self.assertIsNone(answer["refusal"], name)
            problems = [f"{'.'.join(map(str, error.absolute_path))}: {error.message}"
                        for error in validator(self.schemas[DOCUMENTS[kind]]).iter_errors(configuration)]
            self.assertEqual(problems, [], name)

    def test_resolved_configurations_are_valid_and_have_the_defaults(self):
        compared = 0
        for name, kind, configuration, answer in self.cases:
            if not answer["resolved"]:
                continue
            resolved = readers.load(answer["resolved"])
            schema = self.schemas[DOCUMENTS[kind]]
            self.assertEqual([error.message for error in validator(schema).iter_errors(resolved)], [], name)
            self.assertEqual(self.read(kind, resolved)["resolved"], answer["resolved"], name)
            keys = schema["definitions"]["study" if kind == "accuracy" else "build"]["properties"]
            for key, value in resolved.items():
                of_key = keys[key].get("properties", {})
                for inner, one in value.items() if isinstance(value, dict) else ():
                    if "default" in of_key.get(inner, {}) and not has(configuration, (key, inner)):
                        self.assertEqual(one, of_key[inner]["default"], f"{name}: {key}.{inner}")
                        compared += 1
        self.assertGreater(compared, 300)

    def test_no_reader_takes_what_its_schema_refuses(self):
        self.assertEqual(self.complaints(anything), [])
        self.assertEqual(self.complaints(words), [])

    def test_an_unknown_key_is_refused_by_both(self):
        # Where keys are the user's names, any is known.
        mine = re.compile(r"label_groups|except|published|sweep\.keys|search|train\.(tasks|methods)\.no|materials\.no")
        found = [line for line in self.complaints(unknown_key) if not mine.search(line)]
        self.assertEqual(found, [])

    def test_wrong_units_words_and_kinds_are_refused_by_both(self):
        self.assertEqual(self.complaints(unlike), [])

    def test_a_key_that_must_be_there_is_missed_by_both(self):
        def wanted(configuration, ask):
            path = ask["path"]
            valid = validator(self.schemas[DOCUMENTS[kind_of[id(configuration)]]])
            if not valid.is_valid(changed(configuration, path, ...)):
                missed.append(path)
            yield path, ..., False

        missed = []
        kind_of = {id(configuration): kind for _, kind, configuration, _ in self.cases}
        self.assertEqual(self.complaints(wanted), [])
        self.assertGreater(len(missed), 20)

    def test_every_key_is_written_in_one_that_is_taken(self):
        for document, schema in self.schemas.items():
            written = set()
            for _, kind, configuration, _ in self.cases:
                if DOCUMENTS[kind] == document:
                    written |= set(re.findall(r'"(\w+)":', json.dumps(configuration)))
            known = set(properties({**schema, "definitions": {
                key: value for key, value in schema["definitions"].items() if not key.startswith(("parameters_of", "swept"))}}))
            self.assertEqual(known - written, set())

    def test_every_key_that_a_reader_names_is_there(self):
        ask = re.compile(r'(?:\.(?:quantity|positive|not_negative|range|ranges|quantities|rows|square_matrix|integer|flag|texts?|choice'
                         r'|child|children)\(|\b\w+\((?:node|levels|room|features|motion), |(?<![.\w])value\()\s*"([a-z]\w*)"')
        known = set().union(*map(properties, self.schemas.values()))
        named = set()
        for folder in ("core", "scene", "dataset", "eval", "synth"):
            for file in sorted((ROOT / folder).rglob("*.cpp")):
                text = file.read_text()
                if "ConfigNode" in text and "stored_dataset" not in file.name and "wall_materials" not in file.name:
                    named |= set(ask.findall(text))
        self.assertGreater(len(named), 250)
        self.assertEqual(named - known, set())

    def test_they_notice_what_is_wrong_with_a_schema(self):
        """The checks above, with schemas that are wrong in one place each."""
        def wrong(path, value):
            altered = copy.deepcopy(self.schemas)
            inner = altered["configuration"]["definitions"]["build"]["properties"]
            for step in path[:-1]:
                inner = inner[step]
            if value is ...:
                del inner[path[-1]]
            else:
                inner[path[-1]] = value
            return altered

        modes = ("modes", "properties")
        for path, value, tried in (((*modes, "order"), ..., anything),
                                   ((*modes, "order"), {}, unlike),
                                   ((*modes, "no_such_key"), {}, unknown_key),
                                   (("solver", "properties", "linear_solver", "enum"), ["direct"], words),
                                   (("audio", "properties", "seconds"), {"type": "number"}, anything),
                                   (("modes", "required"), ["order"], anything)):
            self.assertNotEqual(self.complaints(tried, wrong(path, value)), [], path)


class Files(SchemaTest):
    def test_they_are_valid_themselves(self):
        for schema in self.schemas.values():
            jsonschema.Draft7Validator.check_schema(schema)
            self.assertEqual(schema["$schema"], jsonschema.Draft7Validator.META_SCHEMA["$schema"][:-1] + "#")

    def test_they_are_what_the_readers_and_the_documentation_say(self):
        for name, schema in schemas.make(self.reader).items():
            self.assertEqual((CONFIGS / name).read_text(), schemas.text_of(schema), "scripts/make_schema writes them")

    def test_the_command_prints_them(self):
        self.assertEqual(run("schema").stdout, (CONFIGS / "configuration.schema.json").read_text())
        self.assertEqual(run("schema", "materials").stdout, (CONFIGS / "materials.schema.json").read_text())
        self.assertIn('did you mean "materials"?', run("schema", "material").stderr)

    def test_every_key_is_described_with_its_unit(self):
        def look(schema, path):
            for name, key in schema.get("properties", {}).items():
                if "$ref" in key:
                    continue
                self.assertRegex(key.get("description", ""), r"^\S.*\.$", (*path, name))
                if "x-unit" in key:
                    self.assertIn(f"a bare number is in {key['x-unit']}", key["description"])
            for inner, value in schema.items():
                for one in value if isinstance(value, list) else value.values() if inner in ("properties", "definitions") else [value]:
                    if isinstance(one, dict) and inner != "if":
                        look(one, (*path, inner))

        for schema in self.schemas.values():
            look(schema, ())
        modes = self.schemas["configuration"]["definitions"]["build"]["properties"]["modes"]["properties"]
        self.assertEqual((modes["order"]["default"], modes["order"]["minimum"], modes["order"]["maximum"]), (3, 1, 4))
        self.assertEqual((modes["element_size"]["x-dimension"], modes["element_size"]["x-unit"]), ("length", "m"))

    def test_configurations_name_their_schema(self):
        files = sorted(CONFIGS.glob("*.yaml"))
        self.assertGreater(len(files), 20)
        for file in files:
            first = file.read_text().splitlines()[0]
            name = re.fullmatch(r"# yaml-language-server: \$schema=(\S+)", first)
            self.assertTrue(name, f"{file.name}: {first}")
            schema = json.loads((file.parent / name[1]).read_text())
            self.assertTrue(validator(schema).is_valid(readers.load(file.read_text())), file.name)

    def test_configurations_of_the_documentation_are_valid(self):
        check, seen = validator(self.schemas["configuration"]), 0
        for page in sorted(DOCS.rglob("*.md")):
            for block in re.findall(r"^```yaml\n(.*?)^```", page.read_text(), re.S | re.M):
                try:
                    configuration = readers.load(block)
                except yaml.YAMLError:
                    continue
                if isinstance(configuration, dict) and "youngs_modulus" not in block:
                    seen += 1
                    self.assertEqual([error.message for error in check.iter_errors(configuration)], [], f"{page.name}: {block}")
        self.assertGreater(seen, 5)

    def test_a_dataset_keeps_a_valid_configuration(self):
        config = self.write("little.yaml", "objects: [{shape: tile, materials: [steel]}]\nmodes: {max_modes: 3, order: 1}\n"
                                           "strikes: {per_object: 1}\naudio: {seconds: 0.1 s}\n")
        built = run("build", config, "--output", self.folder / "little")
        self.assertEqual(built.returncode, 0, built.stderr)
        kept = readers.load((self.folder / "little" / "configuration.yaml").read_text())
        self.assertEqual([error.message for error in validator(self.schemas["configuration"]).iter_errors(kept)], [])
        named = self.write("named.yaml", f"# yaml-language-server: $schema=carillon.schema.json\n{config.read_text()}modles: {{}}\n")
        self.assertIn('modles: unknown key; did you mean "modes"?', run("plan", named).stderr)


if __name__ == "__main__":
    unittest.main()
