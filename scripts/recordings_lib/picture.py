"""Decay rates that were heard of each material, and the laws that are fitted to them."""
import math

# Okabe and Ito's colours, told apart by everyone.
FEATURE, PARTIAL, FITTED, PAPERS = "0.7", "black", "#0072B2", "#D55E00"
BAND = (100, 20000)  # Hz


def law(alphas):
    """Frequencies [Hz] and d [1/s] of c = alpha1 + alpha2 lambda over the band."""
    count = 60
    frequencies = [BAND[0] * (BAND[1] / BAND[0])**(k / count) for k in range(count + 1)]
    return frequencies, [0.5 * (alphas["alpha1"] + alphas["alpha2"] * (2 * math.pi * f)**2) for f in frequencies]


def draw_material(axis, material, clips, fit, papers):
    features = [feature for clip in clips for feature in clip.features]
    partials = [partial for clip in clips for partial, _ in clip.matches()]
    axis.scatter([f["frequency_hz"] for f in features], [f["decay_rate_per_s"] for f in features], s=6,
                 color=FEATURE, linewidths=0, label="features")
    axis.scatter([p.frequency for p in partials], [p.decay_rate for p in partials], s=22, facecolors="none",
                 edgecolors=PARTIAL, linewidths=0.9, label="isolated partials, by regression")
    if "error" not in fit:
        axis.plot(*law(fit["parameters"]), color=FITTED, lw=1.8, label="fitted to the features")
    if papers:
        axis.plot(*law(papers), color=PAPERS, lw=1.4, ls="--", label="material alone (Hiner 2024, table 1)")
    axis.set(xscale="log", yscale="log", xlim=BAND, ylim=(0.05, 2000),
             title=f"{material}, {len(clips)} clips", xlabel="frequency [Hz]", ylabel="decay rate d [1/s]")
    axis.grid(color="0.93")


def draw(fits, path):
    """fits: of tables.material_fits()"""
    import matplotlib  # for those who want the tables alone
    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    columns = 4
    rows = -(-len(fits) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4 * columns, 3.4 * rows), squeeze=False,
                                constrained_layout=True, sharex=True, sharey=True)
    for axis, fit in zip(axes.flat, fits):
        draw_material(axis, *fit)
        axis.label_outer()
    for axis in list(axes.flat)[len(fits):]:
        axis.set_visible(False)
    handles = {}
    for axis in axes.flat:
        handles.update({label: handle for handle, label in zip(*axis.get_legend_handles_labels())})
    figure.legend(handles.values(), handles.keys(), loc="upper center", bbox_to_anchor=(0.5, 0), ncols=4)
    figure.savefig(path, dpi=80, bbox_inches="tight")
