"""Leaderboards of what a run has trained: the rows that `carillon score` and the service keep, on the
nightly report's page (docs/service.md)."""
import json
import subprocess

from nightly_lib import benchmarks


def write(program, outcome, log):
    """Of every dataset and task of a run's classification.json; what is wrong with one is in the log."""
    output, configuration = outcome.output, outcome.benchmark.words[1]
    path = output / "evaluation" / "classification.json"
    if not path.exists():
        return
    tasks = {(row["dataset"], row["task"]) for row in json.loads(path.read_text())["rows"]}
    for document in sorted(output.rglob("dataset.json")):
        name = json.loads(document.read_text())["name"]
        for task in sorted(task for dataset, task in tasks if dataset == name):
            with open(log, "a") as lines:
                subprocess.run([program, "--json", "score", str(document.parent), "--task", task,
                                "--tasks", str(benchmarks.ROOT / configuration)],
                               stdout=lines, stderr=lines)
