"""drover/figures/stability_figure.py: figure of the stability of a uniform state: growth, sound, damping, structure
factors."""
import matplotlib

from . import stability_panels as panels
from drover.error import DroverError
from drover.figures.paper import STYLE, add_axes, bar_box, new_figure, write_title_and_caption
from drover.text import drawable, scene_name

# Area of the panels (left, bottom, right, top) and gaps between columns and rows, in inches.
AREA, GAPS = (0.85, 1.3, 11.35, 6.95), (0.95, 0.95)
BAR = 0.75  # width of the colour bar with its ticks


@matplotlib.rc_context(STYLE)
def draw(theory, name=None):
    """Draws one state, by default the most ordered one, as a matplotlib Figure.  Raises DroverError if there is no
    such state."""
    state = state_of(theory, name)
    chosen = panels_of(state)
    figure = new_figure()
    for letter, (words, draw_panel), box in zip("abcdef", chosen, boxes(len(chosen))):
        if draw_panel is panels.draw_growth_map:
            box = (*box[:2], box[2] - BAR, box[3])
            axes = add_axes(figure, box)
            draw_panel(axes, add_axes(figure, bar_box(box)), state)
        else:
            axes = add_axes(figure, box)
            draw_panel(axes, state)
        axes.set_title(f"({letter}) {words}", loc="left")
    title = f"{scene_name(theory)}: linear theory of its uniform state “{drawable(state.words)}”"
    write_title_and_caption(figure, title, caption(state))
    return figure


def state_of(theory, name):
    if not theory.groups:
        raise DroverError(f"{theory.path} contains no uniform state, so there is nothing to draw")
    names = list(theory.groups)
    if name is None:
        # The states of a model of one's own come with ascending order.
        name = next((known for known in panels.STATES if known in names), names[-1])
    name = name.replace(" ", "_")
    alike = [known for known in names if known.startswith(f"{name}_")]  # "isotropic" for the only "isotropic_1"
    name = alike[0] if name not in names and len(alike) == 1 else name
    if name not in names:
        raise DroverError(f'{theory.path} has no state "{name}"; expected {" or ".join(names)}')
    return panels.State(name, theory.groups[name], theory.path, theory.scene)


def panels_of(state):
    """Title and drawing function of each panel for which the state has data."""
    chosen = []
    if not state.is_isotropic:
        rate = panels.with_unit("fastest growth rate", state.data["growth_rate"])
        chosen.append((rate, panels.draw_growth_map))
    chosen.append(("growth rates of all modes", panels.draw_branches))
    if state.is_isotropic and state.holds("frequency"):
        chosen.append(("frequencies of all modes", panels.draw_frequencies))
    for name, words in (("slow_speed", "speeds of slow modes"), ("slow_damping", "damping of slow modes")):
        if not state.is_isotropic and state.is_defined(name):
            chosen.append((words, lambda axes, state, name=name: panels.draw_slow(axes, state, name)))
    for start in ("structure_factor_", "dynamic_structure_factor_"):
        if state.parts(start):
            chosen.append((panels.factor_title(state, start),
                           lambda axes, state, start=start: panels.draw_factor(axes, state, start)))
    return chosen


def boxes(count):
    """Boxes of this many panels, row by row from the top."""
    columns = 1 if count < 3 else 2 if count < 5 else 3
    rows = -(-count // columns)
    left, bottom, right, top = AREA
    width = (right - left - (columns - 1) * GAPS[0]) / columns
    height = (top - bottom - (rows - 1) * GAPS[1]) / rows
    return [(left + column * (width + GAPS[0]), top - height - row * (height + GAPS[1]), width, height)
            for row in range(rows) for column in range(columns)]


def caption(state):
    """Explains the figure to a reader."""
    words = [f"Small perturbations exp(i q·x + s t) of the uniform state “{state.words}”; they grow where Re s > 0."]
    fastest = state.fastest
    if state.is_isotropic:
        words.append("Rates do not depend on the angle of q.")
    if fastest is None:
        words.append("No perturbation grows.")
    else:
        where = "" if state.is_isotropic else f", {fastest[2]:.3g}\u00a0degrees from the order"
        words.append(f"The fastest one shown grows at {fastest[0]:.4g}\u00a0/s, at |q| = "
                     f"{fastest[1]:.4g}\u00a0/mm{where}"
                     + (" (star); on the black line perturbations neither grow nor decay." if where else "."))
    if not state.is_isotropic and state.is_defined("slow_speed"):
        words.append("Slow modes have s = −i u q − γ q² as q → 0, named (d) in order of their speeds at each angle"
                     + (" (with gaps where two speeds coincide and γ is undefined)."
                        if bool(state.array("slow_damping").isnull().any()) else "."))
    q = panels.sound_wavenumber(state)
    if state.parts("structure_factor_"):
        words.append("Structure factors are for the noise of the scene, drawn where no mode grows"
                     + (f"; the dynamic one is at |q| = {q}\u00a0/mm." if q else "."))
    return " ".join(words)
