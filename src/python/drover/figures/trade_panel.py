"""drover/figures/trade_panel.py: error against work, one colour a model."""
import json
from pathlib import Path

import matplotlib

from drover.error import DroverError
from drover.figures.panels import log_axes
from drover.figures.paper import STYLE, add_axes, new_figure, write_title_and_caption
from drover.text import drawable

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#56b4e9")  # one orange alone
MARKERS = "osD^vP"
MOST_MODELS = len(COLOURS)
PLANE = (1.0, 1.35, 7.0, 5.4)  # inches


def draw_trade(found, axes=None):
    """Draws the fronts of the models; the line at 1 is what the targets allow.  Returns the matplotlib axes."""
    if axes is None:
        from matplotlib import pyplot
        axes = pyplot.figure(layout="constrained", figsize=(7.0, 4.0)).gca()
    models = list(dict.fromkeys(row["model"] for row in found["by_model"]))
    models.sort(key=lambda model: min(row["error_of_allowed"] for row in found["by_model"] if row["model"] == model))
    for model, colour, marker in zip(models[:MOST_MODELS], COLOURS, MARKERS):
        rows = [row for row in found["by_model"] if row["model"] == model]
        axes.loglog([row["cost"] for row in rows], [row["error_of_allowed"] for row in rows], marker + "-",
                    color=colour, markersize=4, linewidth=1.2, label=drawable(model))
    axes.axhline(1.0, color="0.4", linewidth=0.8, linestyle=":")
    axes.annotate("allowed", (1.0, 1.0), xycoords=("axes fraction", "data"), xytext=(-2, 2),
                  textcoords="offset points", ha="right", va="bottom", color="0.4")
    good = [row for row in found["front"] if row["error_of_allowed"] <= 1 and row["model"] != "linear theory"]
    if good:
        axes.loglog(good[0]["cost"], good[0]["error_of_allowed"], "o", markersize=11, markerfacecolor="none",
                    markeredgecolor="black", label="cheapest that is allowed")
    log_axes(axes)
    axes.set_xlabel("work [s of a core]")
    axes.set_ylabel("error over error allowed")
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return axes


@matplotlib.rc_context(STYLE)
def draw(path):
    """Draws tradeoff.json of a folder of drover tradeoff as a matplotlib Figure."""
    try:
        found = json.loads(Path(path).read_text(encoding="utf-8"))
        found["by_model"], found["front"], found["wishes"]  # pylint: disable=pointless-statement
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DroverError(f"{path}: cannot be read as the result of a study; expected tradeoff.json of the folder of "
                          "drover tradeoff: run that again") from error
    figure = new_figure()
    draw_trade(found, add_axes(figure, PLANE))
    wanted = "; ".join(f"{drawable(row['observable'])} within {row['allowed']:.2g}" for row in found["wishes"])
    left_out = len({row["model"] for row in found["by_model"]}) - MOST_MODELS
    write_title_and_caption(
        figure, "speed for accuracy: error against work",
        f"Wanted: {wanted}. Error: the largest of a target, with a probability of 95 %, over what it allows. Each "
        "point is a setting of step, grid and duration that no other of its model beats."
        + (f" {left_out} models with larger errors are not drawn." if left_out > 0 else ""))
    return figure
