"""What a nightly run tells: nightly.json, the page of `carillon report`, and a screen of text."""
import json
import os
import subprocess

from nightly_lib import verdicts

SHOWN = 30   # nightly runs of a measure in nightly.json
LINES = 25   # of changes on the screen
TOLD = ("worse", "slower", "better", "faster")  # in this order


def verdict_of(outcomes):
    words = [verdict.word for outcome in outcomes for _, verdict, _ in outcome.verdicts.values()]
    if any(not outcome.ok for outcome in outcomes):
        return "failed"
    if any(word in verdicts.ALARMS for word in words):
        return "regressed"
    # A measure that is new says nothing of the others.
    return "learning" if "learning" in words or set(words) == {"new"} else "fine"


def document(outcomes, about):
    """nightly.json; `about`: date, version, commit, host and so on."""
    measures, compared = [], 0
    for outcome in outcomes:
        for name, (measure, verdict, past) in outcome.verdicts.items():
            compared = max(compared, len(past))
            rows = [[date, value] for date, value, _ in past[-(SHOWN - 1):]]
            measures.append({
                "name": f"{outcome.benchmark.name}: {name}", "kind": measure.kind,
                "unit": measure.unit, "value": measure.value, "typical": verdict.typical,
                "bound": verdict.bound, "verdict": verdict.word, "change": verdict.change,
                "history": [*rows, [about["date"], measure.value]]})
    runs = [{"config": outcome.benchmark.words[1], "command": outcome.benchmark.words[0],
             "name": outcome.benchmark.name, "folder": outcome.output.name,
             "seconds": outcome.seconds, "ok": outcome.ok, "message": outcome.message}
            for outcome in outcomes]
    return {"format": 1, **about, "nightly_runs": compared, "verdict": verdict_of(outcomes),
            "measures": measures, "runs": runs}


def write_atomically(path, text):
    temporary = path.with_name(f".{path.name}.tmp")
    with open(temporary, "w") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)


def write(folder, found, program):
    """nightly.json and, where the program has the command, report.html; a message if that failed."""
    write_atomically(folder / "nightly.json", json.dumps(found, indent=1, allow_nan=False) + "\n")
    about = subprocess.run([program, "report", "--help"], capture_output=True, text=True)
    if about.returncode != 0 or "Usage: carillon report" not in about.stdout:
        return ""
    page = subprocess.run([program, "report", str(folder), "-o", str(folder / "report.html")],
                          capture_output=True, text=True)
    if page.returncode == 0 or "built without the page" in page.stderr:
        return ""  # without npm there is no page, which is no news
    return f"no report.html: {page.stderr.strip()[-200:]}"


def text(found, folder):
    """A screen of it: what failed and what changed, worst first."""
    lines = [f"{found['verdict']}: {found['version']}, {found['commit'] or 'no commit'}, "
             f"{found['date']}, {found['host']}, {found['ranks']} ranks, compared with "
             f"{found['nightly_runs']} nightly runs"]
    lines += [f"  FAILED   {run['name']}: {run['message']}" for run in found["runs"]
              if not run["ok"]]
    order = {word: i for i, word in enumerate(TOLD)}
    told = sorted((row for row in found["measures"] if row["verdict"] in order),
                  key=lambda row: order[row["verdict"]])
    for row in told[:LINES]:
        lines.append(f"  {row['verdict']:8s} {row['name']}: {row['change']}"
                     f" ({_number(row['typical'])} -> {_number(row['value'])}"
                     f"{' ' + row['unit'] if row['unit'] else ''})")
    if len(told) > LINES:
        lines.append(f"  and {len(told) - LINES} more")
    steady = sum(row["verdict"] == "steady" for row in found["measures"])
    lines.append(f"{steady} of {len(found['measures'])} measures are steady; all: "
                 f"{folder / 'nightly.json'}")
    if any(row["verdict"] in verdicts.ALARMS for row in found["measures"]):
        lines.append("If this is as it should be: scripts/nightly --accept REASON")
    return "\n".join(lines)


def _number(value):
    return f"{value:.4g}" if isinstance(value, (int, float)) else str(value)
