"""Whether two datasets, or sweeps of them, are the same."""
import hashlib
import pathlib

# Dates, hosts and timings, and a lock that holds nothing but its holder.
OWN = {"trace.json", "journal.jsonl", "status.json", "sweep-timing.csv", ".lock"}


def hashes(output):
    """SHA-256 of every file of a dataset that equal builds share."""
    output = pathlib.Path(output)
    return {str(path.relative_to(output)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(output.rglob("*")) if path.is_file() and path.name not in OWN}
