"""What the tables of docs/ say of keys."""
import re

from schema_lib.readers import EVERY, ROOT, load

# Headings of tables whose first column leaves out where its keys stand.
TABLES = {"objects": "objects[].", "modes": "modes.", "solver": "solver.", "strikes": "strikes.",
          "The section `evaluate.classification`": "evaluate.classification.",
          "Another condition: the section `evaluate.transfer`": "evaluate.transfer.",
          "Spectrograms: the section `evaluate.spectrograms`": "evaluate.spectrograms."}
PAGES = ("configuration.md", "learning.md", "damping-validation.md", "accuracy.md")


def plain(cell):
    """A table's cell without links and quotes of Markdown."""
    return re.sub(r"\[([^]]+)\]\([^)]*\)", r"\1", cell).replace("\\|", "|").strip()


def split_defaults(cell, count):
    """The defaults of a row for several keys; one for all of them where there is one."""
    for between in ";,":
        parts, depth = [""], 0
        for c in cell:
            depth += (c in "[{(") - (c in "]})")
            if c == between and depth == 0:
                parts.append("")
            else:
                parts[-1] += c
        if len(parts) == count:
            return [part.strip() for part in parts]
    return [cell] * count


def default_of(cell, units):
    """The value that a table's cell states, in SI; None where it says where one comes from."""
    text = re.sub(r"\([^)]*\)|`", "", cell).strip()
    match = re.fullmatch(r"(\[[^]]*\]|\S+)(?: (\S.*))?", text)
    if not match or text in ("all", "none") or re.search(r"`\w+\.\w+`", cell):
        return None
    value, unit = load(match[1]), (match[2] or "").replace(" ", "")
    if unit and unit not in units:
        return None
    if isinstance(value, list) and any(isinstance(one, str) for one in value) and units:
        parts = [str(one).partition(" ") for one in value]
        return [load(number) * units[of.replace(" ", "")] if of else load(number) for number, _, of in parts]
    scaled = lambda one: one * units[unit] if unit else one
    return [scaled(one) for one in value] if isinstance(value, list) else scaled(value)


def same(one, other):
    """Whether two values are one, but for the rounding of units."""
    if isinstance(other, list) and isinstance(one, str):
        one = [one]
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, bool) or isinstance(other, bool) or not all(isinstance(x, int | float) for x in (one, other)):
        return one == other
    return abs(one - other) <= 1e-12 * abs(one)


def tables():
    """{dotted key: (meaning, default)} of the tables of docs/."""
    found = {}
    for page in PAGES:
        heading, header, prefix = "", "", None
        for line in (ROOT / "docs" / page).read_text().splitlines():
            if line.startswith("#"):
                heading = line.lstrip("# ")
            if not line.startswith("|"):
                prefix = None
                continue
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            if cells[0].startswith("key"):
                prefix, header = TABLES.get(heading, ""), cells[-1]
                if of := re.match(r"key of `?(.*?):?`?$", cells[0]):
                    prefix = "MATERIAL." if "material" in of[1] else of[1] + "."
                if page == "accuracy.md":
                    prefix = "STUDY." + prefix
                if heading == "keys that stand in several places":
                    prefix = None
            elif prefix is not None and cells[0].startswith("`"):
                keys = re.findall(r"`([^`]+)`", cells[0])
                default = cells[1] if len(cells) > 2 else ""
                for key, one in zip(keys, split_defaults(default, len(keys))):
                    key = key.replace("...", "train.methods.NAME.") if key.startswith("...") else key
                    key = re.sub(r"\b(NAME|TASK)\b", EVERY, key)
                    meaning = f"off: {cells[-1]}" if header == "off means" else cells[-1]
                    found[(prefix if not key.startswith(prefix) else "") + key] = (plain(meaning), plain(one))
    return found
