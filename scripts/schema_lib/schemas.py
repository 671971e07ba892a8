"""JSON Schemas of what readers ask for and tables of docs/ mean."""
import json
import pathlib
import re
import tempfile

from schema_lib.readers import EVERY, NUMBER, Failure, heard, load, prepare
from schema_lib.tables import default_of, same, tables

DRAFT = "http://json-schema.org/draft-07/schema#"

# Texts and lists of texts that a reader holds to a list of its own: the list's name in the reader's vocabulary,
# or the list. "open" are those that take other names, too.
WORDS = {
    "objects[].shape": "shapes",
    "objects[].nodes": ["open", "joined", "each"],
    "objects[].unit": ["open", "mm", "cm", "m", "inch"],
    "materials": "open materials", "objects[].materials": "open materials",
    "motion.bodies[].materials": "open materials", "motion.ground.material": "open materials",
    "supports.contacts[].kind": "supports", "motion.bodies[].rests": "touches",
    "motion.strings[].rests": "touches",
    "striker.kind": "strikers", "noise.kind": "noises",
    "motion.bodies[].texture.map": "maps", "motion.ground.texture.map": "maps",
    **{f"room.{key}{wall}": "walls" for key in ("absorption", "walls")
       for wall in ("", ".x0", ".x1", ".y0", ".y1", ".floor", ".ceiling", ".walls", ".others")},
    "train.tasks.*.column": ["open", "shape", "family", "material"],
    "train.methods.*.branches": ["isnn", "soundnet5", "soundnet8", "voxnet", "image", "touch"],
    "train.methods.*.modalities": ["spectrogram", "waveform", "voxels", "image", "touch"],
    "evaluate.damping.estimators": ["mixture", "emg", "emg_relative", "least_squares", "lower_bound"],
    "evaluate.damping.draws_from": ["object", "material"],
    "evaluate.damping.features.extractors": ["esprit", "peaks", "room_likelihood", "truth"],
    "STUDY.features.extractors": ["esprit", "peaks"],
    "STUDY.materials": "open materials",
    "MATERIAL.damping": ["open", "rayleigh", "caughey", "power", "hybrid"],
    "MATERIAL.damping.model": ["open", "rayleigh", "caughey", "power", "hybrid"],
}
# Where keys of one place are those of another.
SAME = {"train.with.recordings": "recordings", "evaluate.transfer.recordings": "recordings",
        "train.with.data": "data", "evaluate.transfer.data": "data", "STUDY.name": "name",
        "motion.ground.texture": "motion.bodies[].texture"}
# Keys of a scene, which `sound.scene` of a study has too.
SCENE = ("audio", "strikes", "listeners", "effects", "radiation", "click", "room", "noise", "recording", "striker",
         "supports", "negative_damping")
STAND_IN = ("shape", "parameters", "profile", "svg", "svg_height", "profile_axis", "profile_id", "csv", "length")
# Exactly one of these, or at most one.
ONE_OF = {"objects[]": ("shape", "mesh", "glob", "manifest", "modelnet"), "noise": ("folder", "kind"),
          "room": ("dimensions absorption", "dimensions walls", "dimensions rt60", "responses"),
          "motion.bodies[].texture": ("map", "image"), "recordings": ("names", "table")}


def beside(schema):
    """A schema that others may stand beside: draft-07 passes over what stands beside a `$ref`."""
    return {"allOf": [schema]} if "$ref" in schema else schema


class Maker:
    def __init__(self, words, tree, meanings):
        self.words, self.tree, self.meanings = words, tree, meanings
        self.definitions = {}
        self.used = set()
        self.without = []  # keys that no table has
        self.other_defaults = []  # of which the reader and the tables do not say the same

    # Values.

    def unit_pattern(self, unit):
        """As core::parse_quantity reads it, blanks and other spellings included."""
        forms = {"u": "[uµμ]", "^3": "(\\^3|³)", "deg": "(deg|°)", "*": "[*·]", "in": "(inches|inch|in)"}
        blank = "[ \\t\\u00a0]*"
        parts = re.findall(r"\^3|deg|in\b|.", unit)
        return blank.join(forms.get(part, re.escape(part)) for part in parts).replace("\\/", "/")

    def quantity(self, ask):
        """The definition of a quantity: a number in SI, or a text with a unit."""
        dimension = ask.get("dimension", "plain number")
        low = ask.get("low")
        sign = "" if low is None else "positive " if ask.get("above_low") else "not negative "
        name = (sign + dimension).replace(" ", "_")
        known = self.words["units"][dimension]
        if name not in self.definitions:
            units = "|".join(self.unit_pattern(unit) for unit in known["units"])
            schema = {"type": ["number", "string"],
                      "pattern": rf"^[ \t]*{'[+-]' if low is None else '[+]'}?{NUMBER}[ \t]*({units})?[ \t]*$",
                      "patternErrorMessage": self.wanted(sign, dimension)}
            if low is not None:
                schema["exclusiveMinimum" if ask.get("above_low") else "minimum"] = low
            self.definitions[name] = schema
        return {"$ref": f"#/definitions/{name}"}

    def wanted(self, sign, dimension):
        known = self.words["units"][dimension]
        if dimension == "plain number":
            return f"a {sign}number, or a percentage such as \"5 %\", is wanted"
        return f"a {sign}{dimension} is wanted: {', '.join(known['units'])}; a bare number is in {known['unit']}"

    def word(self, node, kind):
        """A text, or a list of texts."""
        scalar = {"type": ["string", "number", "boolean"]}
        known = WORDS.get(str(node))
        if known:
            names = known if isinstance(known, list) else [*known.split()[:-1], *self.words[known.split()[-1]]]
            names = [*names, "own", "noise_burst"] if known == "strikers" else names
            scalar = {"enum": names} if names[0] != "open" else {"anyOf": [{"enum": names[1:]}, scalar]}
        return scalar if kind == "text" else {"anyOf": [scalar, {"type": "array", "items": scalar}]}

    def value(self, node, ask):
        """What one ask takes."""
        kind, count = ask["kind"], ask.get("count", 0)
        one = self.quantity(ask) if kind in ("quantity", "range", "ranges", "quantities", "rows", "square_matrix") else {}
        length = {"minItems": count, "maxItems": count} if count else {}
        if kind == "quantity":
            return one
        if kind == "range":
            return {"anyOf": [one, {"type": "array", "items": one, "minItems": 2, "maxItems": 2}]}
        if kind == "ranges":
            item = {"anyOf": [one, {"type": "array", "items": one, "minItems": 1, "maxItems": 2}]}
            return {"type": "array", "items": item, **length}
        if kind == "quantities":
            return {"type": "array", "items": one, **length}
        if kind == "rows":
            row = {"type": "array", "items": one, **length}
            return {"anyOf": [row, {"type": "array", "items": row}]}
        if kind == "square_matrix":
            return {"type": "array", "items": {"type": "array", "items": one, **length}, **length}
        if kind == "integer":
            return {"type": ["integer", "string"], "pattern": "^[+-]?[0-9]+(\\.?0*|[eE][+]?[0-9]+)$",
                    "minimum": int(ask["low"]), "maximum": min(int(ask["high"]), 2**63 - 1)}
        if kind == "flag":
            return {"type": ["boolean", "string"], "pattern": "^([Tt]rue|[Ff]alse|[Yy]es|[Nn]o|[Oo]n|[Oo]ff)$"}
        if kind == "choice":
            words = list(ask["allowed"])
            return {"enum": words + [word == "true" for word in words if word in ("true", "false")]}
        if kind in ("text", "texts"):
            return self.word(node, kind)
        if kind == "child":
            return self.mapping(node)
        if kind == "children":
            return {"type": ["array", "null"], "items": self.mapping(node.below("[]"))}
        raise Failure(f"{node}: asked by {kind}")

    def merged(self, asks):
        """Asks without what others of them take as well."""
        kept = {}
        for ask in asks:
            key = json.dumps([ask["kind"], ask.get("dimension"), ask.get("count")])
            before = kept.setdefault(key, dict(ask))
            if "low" not in ask or ask.get("low") < before.get("low", ask["low"]) or not ask.get("above_low"):
                before.pop("above_low", None)
            for side, wider in (("low", min), ("high", max)):
                if side in before and side in ask:
                    before[side] = wider(before[side], ask[side])
                else:
                    before.pop(side, None)
            if "allowed" in ask:
                before["allowed"] = list(dict.fromkeys([*before["allowed"], *ask["allowed"]]))
        return list(kept.values())

    # Keys.

    def described(self, node, schema, ask):
        """A key's schema with what it means, its unit and its default."""
        name = str(node)
        meaning, default = self.meanings.get(name) or self.meanings.get(SAME.get(name, "")) or (None, "")
        if meaning is None:
            same = next((old for old in SAME if name.startswith(old)), None)
            if same:
                meaning, default = self.meanings.get(SAME[same] + name[len(same):]) or (None, "")
        if meaning is None and name.endswith("." + EVERY):
            meaning, default = self.meanings.get(name.removesuffix("." + EVERY)) or (None, "")
        if meaning is None:
            if not any(ask["kind"] in ("child", "children") for ask in node.asks):
                self.without.append(name)
            meaning = ""
        self.used.add(name)
        text = meaning or name.split(".")[-1].replace("_", " ")
        if default:
            text += f". Default: {default}"
        schema = {"description": text[0].upper() + text[1:], **beside(schema)}
        if "dimension" in ask:
            known = self.words["units"][ask["dimension"]]
            schema |= {"x-dimension": ask["dimension"], "x-unit": known["unit"]}
            schema["description"] += f". In {', '.join(known['units'])}; a bare number is in {known['unit']}"
        schema["description"] = schema["description"].rstrip(".") + "."
        return schema | self.default(node, default, ask)

    def default(self, node, cell, ask):
        """A key's default, where it is one value: both the reader and a table have it then."""
        stated = default_of(cell, self.words["units"][ask["dimension"]]["units"] if "dimension" in ask else {})
        values = [load(text) for text in node.defaults]
        if len(values) == 1 and same(stated, values[0]):
            return {"default": values[0]}
        if any(value not in ("", []) for value in values) and (not cell or (len(values) == 1 and stated is not None)):
            self.other_defaults.append(f"{node} ({', '.join(map(str, values))}, not {cell or 'none'})")
        return {}

    def key(self, node):
        asks = self.merged(node.asks)
        if str(node) in SAME and SAME[str(node)] != str(node):
            target = SAME[str(node)]
            if any(ask["kind"] == "child" for ask in asks) and target == "recordings":
                return self.described(node, {"$ref": "#/definitions/recordings"}, {})
        special = getattr(self, "key_" + re.sub(r"\W+", "_", str(node)).strip("_"), None)
        if special:
            return self.described(node, special(node), {})
        if any(ask["kind"] == "choice" for ask in asks):  # others look at the word, too
            asks = [ask for ask in asks if ask["kind"] != "text"]
        choices = [self.value(node, ask) for ask in asks]
        if len(choices) > 1:  # a mapping or else a value, which must be there
            choices = [one | {"type": "object"} if one.get("type") == ["object", "null"] else one for one in choices]
        unique = [one for k, one in enumerate(choices) if one not in choices[:k]]
        measured = next((ask for ask in asks if "dimension" in ask), {})
        return self.described(node, unique[0] if len(unique) == 1 else {"anyOf": unique}, measured)

    def mapping(self, node):
        """The schema of a mapping with its keys."""
        schema = {"type": ["object", "null"]}
        special = getattr(self, "mapping_" + re.sub(r"\W+", "_", str(node)).strip("_"), None)
        if special:
            return special(node, schema)
        if node.named:
            other = node.children.get(EVERY)
            return schema | {"additionalProperties": self.key(other) if other else True}
        schema["properties"] = {step: self.key(child) for step, child in node.children.items()}
        schema["additionalProperties"] = False
        wanted = [step for step, child in node.children.items()
                  if node.places and child.wanted_at >= node.places]
        if wanted:
            schema["required"] = wanted
        if str(node) in ONE_OF:
            schema["oneOf"] = [{"required": keys.split()} for keys in ONE_OF[str(node)]]
        return schema

    # Keys that a reader's asks do not say enough of.

    def key_solver_pitch_cents(self, _):
        return {"type": ["number", "string"], "pattern": f"^(off|[+]?{NUMBER}[ ]*%?)$", "minimum": 0}

    def key_sweep_keys(self, node):
        """Swept keys: a list, names for values, a range, or one value."""
        parts = node.children[EVERY].children
        measure = {"type": ["number", "string"], "pattern": rf"^[+-]?{NUMBER}"}
        what = {"from": "first value", "to": "last value", "count": "so many values",
                "step": "from each value to the next", "spacing": "of values between, or of draws"}
        spans = {step: {"description": what[step].capitalize() + ".",
                        **(measure if parts[step].asks[0]["kind"] == "text"
                           else self.value(parts[step], self.merged(parts[step].asks)[0]))} for step in what}
        span = {"type": "object", "properties": spans, "required": ["from", "to"], "additionalProperties": False,
                "not": {"required": ["count", "step"]}}
        names = {"type": "object", "required": ["named"], "additionalProperties": False,
                 "properties": {"named": {"type": "object", "description": "Values by names, which folders and tables have.",
                                          "additionalProperties": {"not": {"type": "null"}}, "minProperties": 1}}}
        one = {"type": ["string", "number", "boolean"]}
        many = {"type": "array", "items": {"not": {"type": "null"}}, "minItems": 1}
        self.definitions["swept"] = {"anyOf": [many, names, span, one]}
        return {"type": "object", "additionalProperties": {"$ref": "#/definitions/swept"}, "minProperties": 1}

    def key_search_keys(self, _):
        return {"type": "object", "additionalProperties": {"$ref": "#/definitions/swept"}, "minProperties": 1}

    def by_kind(self, key, kinds, ask):
        """`parameters` has those of the kind that `key` names."""
        cases = []
        for name, kind in kinds.items():
            parameters = {}
            for parameter, known in kind["parameters"].items():
                known = known if isinstance(known, dict) else {"default": known}
                text = f"{known['meaning']}. " if "meaning" in known else ""
                text += f"In {', '.join(self.words['units']['length']['units'])}; a bare number is in m."
                default = known["default"]
                if isinstance(default, list) and default[0] == default[1]:
                    default = default[0]
                parameters[parameter] = {"description": text[0].upper() + text[1:], **beside(self.value(None, ask)),
                                         "x-dimension": "length", "x-unit": "m", "default": default}
            cases.append({"if": {"properties": {key: {"const": name}}, "required": [key]},
                          "then": {"properties": {"parameters": {
                              "description": f"Parameters of {name}: {kind['meaning']}.", "type": ["object", "null"],
                              "properties": parameters, "additionalProperties": False}}}})
        return cases

    def mapping_objects_parameters(self, _, schema):
        return schema

    mapping_motion_bodies_texture_parameters = mapping_objects_parameters
    mapping_motion_ground_texture_parameters = mapping_objects_parameters

    def mapping_objects(self, node, schema):
        if "object" not in self.definitions:
            self.definitions["object"] = {}  # its place
            keys = {step: self.key(child) for step, child in node.children.items()}
            self.definitions["parameters_of_shape"] = {"allOf": self.by_kind(
                "shape", self.words["shapes"], {"kind": "range", "dimension": "length"})}
            self.definitions["object"] = schema | {
                "properties": keys, "additionalProperties": False, **self.one_object()}
        return {"$ref": "#/definitions/object"}

    def one_object(self):
        return {"allOf": [{"$ref": "#/definitions/parameters_of_shape"}], "dependencies": {"parameters": ["shape"]},
                "oneOf": [{"required": [key]} for key in ONE_OF["objects[]"]]}

    def of_object(self, keys):
        return {key: {"$ref": f"#/definitions/object/properties/{key}"} for key in keys}

    def mapping_STUDY_objects(self, node, schema):
        own = {step: self.key(child) for step, child in node.children.items()
               if step not in self.definitions["object"]["properties"]}
        others = [key for key in self.definitions["object"]["properties"] if key not in own]
        return schema | {"properties": {**self.of_object(others), **own}, "additionalProperties": False,
                         **self.one_object()}

    def mapping_STUDY_objects_stand_in(self, node, schema):
        return schema | {"properties": {**self.of_object(STAND_IN), "deviation": self.key(node.children["deviation"])},
                         "required": ["shape", "deviation"], "additionalProperties": False,
                         "allOf": [{"$ref": "#/definitions/parameters_of_shape"}]}

    def mapping_STUDY_sound_object(self, node, _):
        return {"$ref": "#/definitions/object"}

    def mapping_STUDY_sound_scene(self, _, schema):
        return schema | {"properties": {key: {"$ref": f"#/definitions/build/properties/{key}"} for key in SCENE},
                         "additionalProperties": False}

    def mapping_motion_bodies_texture(self, node, schema):
        keys = {step: self.key(child) for step, child in node.children.items()}
        self.definitions["parameters_of_map"] = {"allOf": self.by_kind(
            "map", self.words["maps"], {"kind": "quantity", "dimension": "length"})}
        return schema | {"properties": keys, "additionalProperties": False,
                         "allOf": [{"$ref": "#/definitions/parameters_of_map"}],
                         "oneOf": [{"required": [key]} for key in ONE_OF["motion.bodies[].texture"]],
                         "dependencies": {"parameters": ["map"]}}

    mapping_motion_ground_texture = mapping_motion_bodies_texture

    def key_motion_bodies_supports(self, node):
        return self.described(node, {"$ref": "#/definitions/build/properties/supports"}, {})

    # Documents.

    def configuration(self):
        roots = self.tree.children
        given = ("name", "data", "recordings", "train", "search", "evaluate")
        self.definitions["recordings"] = self.mapping(roots["recordings"])
        build = {step: self.key(child) for step, child in roots.items()
                 if step not in ("STUDY", "MATERIAL", "data", "recordings")}
        self.definitions["build"] = {"properties": build, "additionalProperties": False}
        own = {"data": self.key(roots["data"]), "recordings": self.key(roots["recordings"])}
        self.definitions["given"] = {
            "properties": {key: own.get(key) or {"$ref": f"#/definitions/build/properties/{key}"} for key in given},
            "additionalProperties": False, "oneOf": [{"required": [key]} for key in own]}
        study = {step: self.key(child) for step, child in roots["STUDY"].children.items()}
        self.definitions["study"] = {"properties": study, "additionalProperties": False}
        of_study = [key for key in study if key not in build]
        of_build = [key for key in build if key not in study]
        needs = lambda keys: {"anyOf": [{"required": [key]} for key in keys]}
        return {"type": "object",
                "if": {"allOf": [needs(of_study), {"not": needs(of_build)}]}, "then": {"$ref": "#/definitions/study"},
                "else": {"if": needs(own), "then": {"$ref": "#/definitions/given"},
                         "else": {"$ref": "#/definitions/build"}}}

    def materials(self):
        node = self.tree.children["MATERIAL"]
        schema = self.mapping(node)
        further = {"^alpha([3-9]|[1-9][0-9]+)$": {"description": "Further parameter of the damping model.",
                                                **beside(self.quantity({}))}}
        schema["patternProperties"] = further
        damping = schema["properties"]["damping"]
        next(one for one in damping["anyOf"] if "properties" in one)["patternProperties"] = further
        self.definitions["material"] = schema
        return {"type": "object", "propertyNames": {"pattern": "^[^=,/]+$", "not": {"enum": [".", ".."]}},
                "additionalProperties": {"$ref": "#/definitions/material"}}

    def document(self, name, title, description):
        self.definitions = {}
        body = getattr(self, name)()
        return {"$schema": DRAFT, "$id": f"urn:carillon:{name}.schema.json", "title": title,
                "description": description, **body, "definitions": self.definitions}


def make(reader):
    """{file name: schema} as the program's readers have it.
    @throws Failure  a key that no table of docs/ has, or one that no reader takes"""
    with tempfile.TemporaryDirectory() as folder:
        prepare(pathlib.Path(folder))
        tree = heard(reader, pathlib.Path(folder))
    meanings = tables()
    maker = Maker(reader.words, tree, meanings)
    made = {
        "configuration.schema.json": maker.document(
            "configuration", "Carillon: configuration",
            "What carillon build, plan, evaluate, train and accuracy read (docs/configuration.md)."),
        "materials.schema.json": maker.document(
            "materials", "Carillon: materials",
            "A file of materials, `materials_file` of a configuration (docs/configuration.md).")}
    if maker.without:
        raise Failure("no table of docs/ has " + ", ".join(dict.fromkeys(maker.without)))
    if maker.other_defaults:
        raise Failure("defaults of readers that docs/ has otherwise: " + "; ".join(dict.fromkeys(maker.other_defaults)))
    if unread := [key for key in meanings if key not in maker.used]:
        raise Failure("docs/ has, and no reader takes, " + ", ".join(unread))
    return made


def text_of(schema):
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
