"""tests/bench/particles/parts.py: the cases of each part of study.py: scene, settings, seeds and durations."""
import math
from dataclasses import dataclass

VELOCITY = 5.0  # of the flow whose decay is measured [mm/s]
STEPS = (2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6)


@dataclass(frozen=True)
class Case:
    """One row: `key` names it in the table."""
    key: dict
    scene: str
    settings: dict
    seeds: int
    seconds: float
    measure: str = "rod"
    release: float = 0.0
    tilted: bool = True
    plain: tuple = ()  # words of plain_rod.cpp after the spacing of frames: that program instead of drover

    @property
    def gap(self):
        return self.settings.get("plates.gap", 1.2)

    @property
    def amplitude(self):
        return self.settings.get("plates.amplitude", 0.04)


def make(varied, scene, settings, seeds, seconds, **more):
    """Seeds and seconds belong to the key: a trial is another row."""
    return Case({**varied, "seeds": seeds, "seconds": seconds}, scene, settings, seeds, seconds, **more)


def whole(seconds, of):
    """Times of runs end with a frame."""
    return round(max(4, round(seconds / of)) * of, 9)


def rod_step(seeds, factor):
    return [make({"dt": dt, "kick": kick}, "rod.toml", {"time.dt": dt, "contacts.substep": dt, "kick.strength": kick},
                 seeds or 20, whole(20.0 * factor, 0.1))
            for dt in STEPS for kick in (0.0, 0.015)]


def matched_step(seeds, factor):
    """Rods of one size, all in one gait: what a step changes is not lost in their spread."""
    return [make({"dt": dt, "kick": kick}, "rod-matched.toml",
                 {"time.dt": dt, "contacts.substep": dt, "kick.strength": kick, "rods.size_tolerance": 0.0},
                 seeds or 40, whole(20.0 * factor, 0.1))
            for dt in STEPS[1:-1] for kick in (0.0, 0.0265)]


LAWS = ("simultaneous", "approaching-first", "first-to-last", "last-to-first")
GAPS = tuple(round(1.18 + 0.01 * i, 2) for i in range(9))
CHOSEN = {"law": "simultaneous", "restitution": "energetic", "track_slip": True, "increments": 8,
          "simultaneity_gap": 1e-5, "substep": 2e-5}


def contact_laws():
    """Every law with every restitution; and numbers of the program, one at a time, about those chosen."""
    laws = [{**CHOSEN, "law": law, "restitution": restitution, "track_slip": track_slip}
            for law in LAWS for restitution in ("energetic", "kinetic", "kinematic") for track_slip in (True, False)
            if track_slip or (law != "simultaneous" and restitution == "energetic")]  # others have no effect
    for key, values in (("increments", (4, 16, 32, 64)), ("simultaneity_gap", (1e-7, 1e-6, 1e-4)),
                        ("substep", (1e-5, 5e-6, 2e-6))):
        laws += [{**CHOSEN, key: value} for value in values]
    return laws


def rod_laws(seeds, factor):
    return [make({**law, "gap": gap}, "rod.toml",
                 {"time.dt": 2e-5, "plates.gap": gap, **{f"contacts.{key}": value for key, value in law.items()}},
                 seeds or 20, whole(10.0 * factor, 0.1))
            for law in contact_laws() for gap in GAPS]


def rod_kick(seeds, factor):
    return [make({"kick": kick}, "rod.toml", {"kick.strength": kick}, seeds or 20, whole(40.0 * factor, 0.1))
            for kick in (0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.03)]


SYMMETRIC = {
    "cylinder": [1.1] * 13,
    "dumbbell": [1.1] * 3 + [0.88] * 7 + [1.1] * 3,
    "spindle": [0.72] * 3 + [0.88] * 2 + [1.1] * 3 + [0.88] * 2 + [0.72] * 3,
}


def rod_matched(seeds, factor):
    return [make({"gap": gap, "kick": kick}, "rod-matched.toml",
                 {"plates.gap": gap, "kick.strength": kick, "output.frame_every": 0.1}, seeds or 60,
                 whole(30.0 * factor, 0.1))
            for gap, kick in ((1.17, 0.0265), (1.177, 0.0265), (1.184, 0.0265), (1.177, 0.012), (1.177, 0.018))]


def rod_symmetric(seeds, factor):
    return [make({"shape": shape}, "rod.toml", {"rods.diameters": diameters}, seeds or 40, whole(20.0 * factor, 0.1))
            for shape, diameters in SYMMETRIC.items()]


def bed_step(seeds, factor):
    def settings(fraction, dt):
        count = round(fraction * 20.0**2 / (math.pi * 0.4**2))
        return {"time.dt": dt, "contacts.substep": dt, "cell.lx": 20.0, "cell.ly": 20.0, "beads.area_fraction": 0.0,
                "beads.count": count}
    return [make({"area_fraction": fraction, "dt": dt}, "bead-gas.toml", settings(fraction, dt), seeds or 1,
                 whole(5.0 * factor, 0.5), measure="bed", release=whole(3.0 * factor, 0.005))
            for dt in (1e-4, 5e-5, 2.5e-5, 1e-5, 5e-6, 2.5e-6) for fraction in (0.3, 0.6)]


def bed_groups(seeds, factor):
    return [make({"increments": increments, "inelastic_threshold": threshold}, "bead-gas.toml",
                 {"contacts.increments": increments, "contacts.inelastic_threshold": threshold, "cell.lx": 20.0,
                  "cell.ly": 20.0, "beads.area_fraction": 0.7},
                 seeds or 4, whole(5.0 * factor, 0.5), measure="bed", release=whole(1.0 * factor, 0.005))
            for increments, threshold in ((64, 0.0), (16, 0.0), (8, 0.0), (8, 0.03), (8, 0.1), (4, 0.03))]


def rod_in_bed(seeds, factor):
    return [make({"area_fraction": fraction, "kick": kick}, scene, {"kick.strength": kick, "output.frame_every": 0.1},
                 seeds or 20,
                 whole(40.0 * factor, 0.1), tilted=False)
            for kick in (0.0265, 0.018) for fraction, scene in ((0.0, "rod-matched.toml"), (0.67, "rod-in-beads.toml"))]


def paper_rod(seeds, factor):
    return [make({"area_fraction": fraction, "kick": kick}, scene,
                 {"kick.strength": kick, "output.frame_every": 0.1, "rods.count": 1}, seeds or count,
                 whole(60.0 * factor, 0.1), tilted=False)
            for kick in (0.0065, 0.015)
            for fraction, scene, count in ((0.0, "paper-rod.toml", 40), (0.67, "paper-rod-in-beads.toml", 12))]


VARIANTS = (("stop-or-slide", "random", "all"), ("stop-or-slide", "fastest-first", "all"),
            ("decoupled", "tail-first", "all"), ("decoupled", "random", "all"),
            ("stop-or-slide", "tail-first", "hull"), ("decoupled", "tail-first", "hull"))


def pairwise_rod(seeds, factor):
    """Drover and the plain program at three steps; then other steps, orders, friction, spheres and kicks."""
    rows = [(program, *USUAL, step, 0.015) for step in (2e-6, 5e-6, 1e-5) for program in ("drover", "plain")]
    rows += [("drover", *USUAL, step, 0.015) for step in (1e-6, 2e-5, 5e-7)]
    rows += [("drover", friction, order, bearing, step, 0.015)
             for friction, order, bearing in VARIANTS for step in (2e-6, 5e-6, 1e-5)]
    rows += [(program, *USUAL, 2e-6, 0.0065) for program in ("drover", "plain")]

    def case(program, friction, order, bearing, step, kick):
        dt = max(step, 1e-5)
        return make({"program": program, "friction": friction, "order": order, "bearing": bearing, "rod_step": step,
                     "kick": kick}, "paper-rod.toml",
                    {"time.dt": dt, "contacts.friction": friction, "contacts.order": order, "rods.bearing": bearing,
                     "contacts.rod_step": step, "kick.strength": kick}, seeds or 20, whole(20.0 * factor, 0.1),
                    plain=(step, kick, friction, order, bearing) if program == "plain" else ())
    return [case(*row) for row in rows]


USUAL = ("stop-or-slide", "tail-first", "all")

PARTS = {part.__name__: part for part in (rod_step, matched_step, rod_laws, rod_kick, rod_matched, rod_symmetric,
                                          bed_step, bed_groups, rod_in_bed, paper_rod, pairwise_rod)}

# Under the first line of a table.
COMMENTS = {
    "rod_laws": (
        "soft spheres (springs and dashpots) at gap 1.2 mm, equal at contact times 2e-5 and 5e-6 s: damping by mode so",
        "that each mode has e = 0.1: +13.1 mm/s for 60 % of starts and -7.1 for 40 %; damping by contact: 10.2;",
        "damping by the mass of the body: 14",
    ),
}
