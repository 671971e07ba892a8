"""Trains a small network on an export without test labels, hands its answers in, and tells its place.

    carillon export carillon-smoke --format wav --hide test
    carillon serve carillon-smoke --jobs queue --sealed carillon-smoke-wav-sealed.json
    python3 enter.py carillon-smoke-wav --entry "my network" --sealed carillon-smoke-wav-sealed.json

Needs PyTorch and soundfile (Debian: python3-torch python3-soundfile). Any other way to come to
answers will do as well: the service is asked for one thing alone, in the last function.
"""
import argparse
import json
import pathlib
import time
import urllib.error
import urllib.parse
import urllib.request

import soundfile
import torch

BANDS, FRAMES = 40, 24


def read(folder, part, label):
    """Spectrograms of a part's samples [n, 1, BANDS, FRAMES], their names, and labels as far as there are."""
    pictures, names, labels = [], [], []
    for line in (folder / part / "metadata.jsonl").read_text().splitlines():
        row = json.loads(line)
        sound, rate = soundfile.read(folder / part / row["file_name"], dtype="float32", always_2d=True)
        pictures.append(spectrogram(torch.from_numpy(sound[:, 0]), rate))
        names.append(row.get("key") or pathlib.Path(row["file_name"]).stem)
        labels.append(row.get(label))
    return torch.stack(pictures), names, labels


def spectrogram(sound, rate):
    """Levels in bands of equal ratios from 60 Hz [dB], of mean 0 and deviation 1."""
    window = 1024
    sound = torch.nn.functional.pad(sound, (0, max(0, 2 * window - len(sound))))
    power = torch.stft(sound, window, 256, window=torch.hann_window(window), return_complex=True).abs() ** 2
    edges = torch.logspace(*torch.log10(torch.tensor([60.0, rate / 2])).tolist(), BANDS + 1) / rate * window
    frequency = torch.arange(len(power))
    rows = [power[(frequency >= low.floor()) & (frequency <= high.ceil())].mean(0) for low, high in zip(edges, edges[1:])]
    levels = 10 * torch.log10(torch.stack(rows) + 1e-12)
    picture = torch.nn.functional.interpolate(levels[None, None], (BANDS, FRAMES))[0]
    return (picture - picture.mean()) / (picture.std() + 1e-6)


def network(classes):
    return torch.nn.Sequential(
        torch.nn.Conv2d(1, 16, 3, padding=1), torch.nn.ReLU(), torch.nn.MaxPool2d(2),
        torch.nn.Conv2d(16, 32, 3, padding=1), torch.nn.ReLU(), torch.nn.AdaptiveAvgPool2d((5, 3)),
        torch.nn.Flatten(), torch.nn.Dropout(0.3), torch.nn.Linear(32 * 15, classes))


def train(pictures, targets, classes, epochs):
    model = network(classes)
    optimizer = torch.optim.Adam(model.parameters(), 2e-3, weight_decay=1e-4)
    for _ in range(epochs):
        for batch in torch.randperm(len(pictures)).split(32):
            loss = torch.nn.functional.cross_entropy(model(pictures[batch]), targets[batch])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
    return model.eval()


def ask(options, path, body=None):
    headers = {"Authorization": f"Bearer {options.token}"} if options.token else {}
    try:
        with urllib.request.urlopen(urllib.request.Request(options.service + path, body, headers)) as reply:
            return json.load(reply)
    except urllib.error.HTTPError as refused:
        raise SystemExit(refused.read().decode()) from None


def place(options, answers):
    """The rows of the leaderboard once the answers are scored."""
    query = {"dataset": options.dataset, "task": options.task, "entry": options.entry, "sealed": options.sealed}
    job = ask(options, "/v1/score?" + urllib.parse.urlencode({name: value for name, value in query.items() if value}),
              answers.encode())
    while job["state"] in ("queued", "running"):
        time.sleep(0.2)
        job = ask(options, f"/v1/jobs/{job['id']}")
    if job["state"] != "done":
        raise SystemExit(job.get("errors") or job.get("why"))
    return job["result"]["leaderboard"]["rows"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("export", type=pathlib.Path, help="folder of carillon export --hide test")
    parser.add_argument("--service", default="http://127.0.0.1:8750")
    parser.add_argument("--dataset", default="", help="its name there, where several are served")
    parser.add_argument("--task", default="material")
    parser.add_argument("--entry", default="small network", help="name on the leaderboard")
    parser.add_argument("--sealed", default="", help="name of the seal that the service has")
    parser.add_argument("--token", default="")
    parser.add_argument("--epochs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    torch.manual_seed(options.seed)

    pictures, _, labels = read(options.export, "train", options.task)
    classes = sorted(set(labels))
    model = train(pictures, torch.tensor([classes.index(label) for label in labels]), len(classes), options.epochs)
    test, names, _ = read(options.export, "test", options.task)
    with torch.no_grad():
        shares = model(test).softmax(1).tolist()
    rows = [",".join([name, *(f"{share:.6f}" for share in row)]) for name, row in zip(names, shares)]
    for row in place(options, "\n".join([",".join(["sample", *classes]), *rows]) + "\n"):
        measure = row["measures"][0]
        print(f"{row['rank']:2d}. {row['entry']:<24} {100 * measure['mean']:5.1f} % {measure['name']}"
              f"{'   <- this one' if row['entry'] == options.entry else ''}")


if __name__ == "__main__":
    main()
