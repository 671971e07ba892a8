"""Tables of docs/recordings.md."""
import statistics

from recordings_lib.clips import DECAY, FREQUENCY, LINE, right_decay, run

WANTED = 0.95  # of isolated strong partials
SHORT = (("do not decay as a mode", "tones that are no modes left out"),
         ("does not decay as a mode", "tones that are no modes left out"),
         ("weaker modes", "more than 100 modes"), ("weaker mode", "more than 100 modes"),
         ("struck before", "struck before"), ("strikes at", "several strikes at once"),
         ("another strike", "another strike after"), ("samples are missing", "samples missing"),
         ("taken for hum", "hums left out"), ("decay rate is not determined", "tones of no certain decay left out"),
         ("clipped", "clipped"), ("kept as modes", "slow modes kept"))


def short(remarks):
    """Each in a few words."""
    words = []
    for remark in remarks:
        known = next((text for part, text in SHORT if part in remark), remark)
        if known not in words:
            words.append(known)
    return "; ".join(words)


def rate_of(value):
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def of_clip(clip):
    """Its three strongest isolated partials by all three, in a row."""
    cells = []
    for partial, feature in clip.matches()[:3]:
        its = f"{feature['frequency_hz']:.2f} / {rate_of(feature['decay_rate_per_s'])}" if feature else "-"
        third = f"{partial.harminv[0]:.2f} / {rate_of(partial.harminv[1])}" if partial.harminv else "-"
        cells.append(f"{its}, {partial.frequency:.2f} / {rate_of(partial.decay_rate)}, {third}")
    if not cells and clip.partials:
        highest = clip.partials[0]
        feature = clip.feature_of(highest)
        its = f"{feature['frequency_hz']:.2f} / {rate_of(feature['decay_rate_per_s'])}" if feature else "-"
        cells.append(f"{its}, {highest.frequency:.2f} ({highest.why}), -")
    counts = f"{len(clip.matches())} of {len(clip.partials)}"
    remarks = short(clip.answer["remarks"]) or clip.answer["nothing"]
    return (f"| {clip.path.stem} | {clip.material} | {len(clip.features)} | {counts} | {'<br>'.join(cells)} | "
            f"{clip.seconds:.2f} | {remarks} |")


def right(clip, partial, feature):
    """Whether frequency and decay rate are."""
    return (clip.right_frequency(partial, feature["frequency_hz"]),
            right_decay(partial, feature["decay_rate_per_s"]))


def totals(clips):
    """(what, how many, of how many) of the three conditions."""
    matches = [(clip, partial, feature) for clip in clips for partial, feature in clip.matches()]
    held = [right(*match) for match in matches if match[2]]
    return [(f"found, within {LINE} Hz or two bins", len(held), len(matches)),
            (f"frequency within {FREQUENCY} Hz or a bin", sum(f for f, _ in held), len(matches)),
            (f"decay rate within {100 * DECAY:.0f} %", sum(d for _, d in held), len(matches))]


def of_harminv(clips):
    """The same of harminv where it finds a partial: how well the regression itself is known."""
    given = [(clip, partial) for clip in clips for partial, _ in clip.matches() if partial.harminv]
    frequency = sum(clip.right_frequency(partial, partial.harminv[0]) for clip, partial in given)
    decay = sum(right_decay(partial, partial.harminv[1]) for _, partial in given)
    return [("harminv: frequency", frequency, len(given)), ("harminv: decay rate", decay, len(given))]


def differences(clips):
    rows = []
    for clip in clips:
        for partial, feature in clip.matches():
            if feature and all(right(clip, partial, feature)):
                continue
            its = (f"{feature['frequency_hz']:.2f} / {feature['decay_rate_per_s']:.1f} "
                   f"+- {feature['decay_rate_error_per_s']:.1f}" if feature else "none")
            third = f"{partial.harminv[0]:.2f} / {partial.harminv[1]:.1f}" if partial.harminv else "-"
            together = "" if partial.together is None else f"{partial.together:.1f}"
            rows.append(f"| {clip.path.stem} | {partial.frequency:.2f} / {partial.decay_rate:.1f} | {its} | {third} "
                        f"| {clip.width:.2f} | {together} |")
    return rows


def material_fits(clips, folder):
    """(material, its clips, what is fitted to all of their features, the papers' law or {}) of each."""
    # Materials of the papers' table are Rayleigh's; a word of MANIFEST.csv that is no material has none.
    known = {material["name"]: material["damping"] for material in run("list", "materials")[0]}
    fits = []
    for material in sorted({clip.material for clip in clips}):
        of_it = [clip for clip in clips if clip.material == material and len(clip.rows) > 1]
        if not of_it:
            continue
        table = folder / "material.csv"
        table.write_text("\n".join([of_it[0].rows[0]] + [row for clip in of_it for row in clip.rows[1:]]) + "\n",
                         encoding="utf-8")
        model = known.get(material, {})
        fits.append((material, of_it, run("fit", "--features", table)[0],
                     model if model.get("model") == "rayleigh" else {}))
    return fits


def dampings(fits):
    """What is fitted to all features of a material, beside the papers'."""
    rows = []
    for material, of_it, fit, papers in fits:
        theirs = f"{papers['alpha1']:.3g} | {papers['alpha2']:.2g}" if papers else "- | -"
        if "error" in fit:
            its = f"{fit['error'].removeprefix('carillon: ')} | "
        else:
            its = " | ".join(
                f"{fit['parameters'][name]:.2e}" if name == "alpha2" else f"{fit['parameters'][name]:.1f}"
                for name in ("alpha1", "alpha2"))
        heard = sorted(2 * partial.decay_rate for clip in of_it for partial, _ in clip.matches())
        spread = f"{heard[0]:.1f} to {heard[-1]:.1f}" if heard else "-"
        rows.append(f"| {material} | {len(of_it)} | {sum(len(clip.rows) - 1 for clip in of_it)} | {its} | {theirs} "
                    f"| {spread} |")
    return rows


def page(clips, fits):
    """All of the tables.

    fits: of material_fits()
    """
    lines = ["| isolated strong partials | | |", "|---|---|---|"]
    lines += [f"| {what} | {count} of {of} | {100 * count / max(of, 1):.0f} % |" for what, count, of in
              totals(clips) + of_harminv(clips)]
    seconds = [clip.seconds for clip in clips]
    reasons = {}
    for clip in clips:
        for partial in clip.partials:
            if partial.why:
                kind = "another beside it" if partial.why.startswith("another") else partial.why
                reasons[kind] = reasons.get(kind, 0) + 1
    strong = sum(len(clip.partials) for clip in clips)
    left = ", ".join(f"{kind} ({count})" for kind, count in sorted(reasons.items(), key=lambda item: -item[1]))
    lines += ["", f"{len(clips)} clips, {strong} strong peaks. Not isolated: {left}. Processor time of a clip: "
              f"{statistics.median(seconds):.2f} s in the median, {max(seconds):.2f} s at most.", ""]
    rows = differences(clips)
    if rows:
        lines += ["## Where the program differs", "",
                  "f [Hz] / d [1/s]. The last column is what the regression makes of all features of the program about",
                  "the partial together (recordings of one channel): where it is right and the column of the program is",
                  "not, the program describes the line by several.", "",
                  "| clip | regression | program | harminv | bin [Hz] | together: d |", "|---|---|---|---|---|---|",
                  *rows, ""]
    lines += ["## Damping of the materials", "",
              "c = 2 d = alpha1 + alpha2 lambda, fitted to all features of all clips of a material.", "",
              "| material | clips | features | alpha1 [1/s] | alpha2 [s] | papers: alpha1 | alpha2 | c of the isolated "
              "partials |",
              "|---|---|---|---|---|---|---|---|", *dampings(fits), "",
              "![Decay rates of features and isolated partials by material, with the laws](recordings.png)", ""]
    lines += ["## Clip by clip", "",
              "f [Hz] / d [1/s] of the program, by regression, by harminv: the strongest three isolated partials, or the",
              "highest peak and why it is none.", "",
              "| clip | material | features | isolated, of strong | program, regression, harminv | time [s] | remarks |",
              "|---|---|---|---|---|---|---|", *map(of_clip, clips)]
    return "\n".join(lines) + "\n"
