"""tests/app/test_particle_scenes.py: every scene of particles of models/ runs, conserves energy and matches its model.

--set reduces cells and times so that all scenes together take about twelve seconds of one core; densities, plates,
bodies and contacts are those of the scene.  Flocks take minutes to form, so the tests check only properties that a run
of any length has.
"""
import math
import re
import sys
import tomllib

import h5py
import numpy as np
import pytest
from pictures import covered, overlaps, unlabelled
from support import MODELS, drover, drover_json, scenes, settings, slow_but

import drover as drover_package

# Frames at six phases of the plates, whose period is 5 ms; samples at five.
OFTEN = ["time.end=0.312", "output.frame_every=0.052", "output.sample_every=0.002"]
SQUARE = ["cell.lx=13.5", "cell.ly=13.5", *OFTEN]
FLOWER = ["cell.radius=8", "cell.petals=6", "cell.petal_radius=5", *OFTEN]
SHORT = {
    "rod": ["time.end=1.04", "output.frame_every=0.052", "output.sample_every=0.026"],
    "rod-matched": ["rods.count=8", "time.end=0.416", "output.frame_every=0.052", "output.sample_every=0.026"],
    "rod-in-beads": ["cell.lx=9", "cell.ly=9", *OFTEN],
    "paper-rod": ["rods.count=6", "time.end=1.56", "output.frame_every=0.052", "output.sample_every=0.026"],
    "paper-rod-in-beads": ["cell.lx=9", "cell.ly=9", *OFTEN],
    "paper-flock": SQUARE,
    "paper-poor": SQUARE,
    "bead-flock": SQUARE,
    "bead-poor": SQUARE,
    "rods-alone": ["cell.lx=27", "cell.ly=27", *OFTEN],
    "amorphous": SQUARE,
    "flower-flock": FLOWER,
    "flower-poor": FLOWER,
    "circle-flock": ["cell.radius=10", *OFTEN],
    "bead-gas": ["cell.lx=12", "cell.ly=12", *OFTEN],
    "full-size": ["cell.lx=22.5", "cell.ly=22.5", "time.end=0.06", "output.frame_every=0.012",
                  "output.sample_every=0.002"],
}
SCENES = sorted(SHORT)
WITH_RODS = [scene for scene in SCENES if scene != "bead-gas"]
WITH_BEADS = [scene for scene in SCENES if scene not in ("rod", "rod-matched", "paper-rod", "rods-alone")]
PAPER = ["rod", "paper-rod", "paper-rod-in-beads", "paper-flock", "paper-poor"]  # its amplitude and gap
MATCHED = [scene for scene in WITH_RODS if scene not in PAPER]


def scene_of(name):
    return tomllib.loads((MODELS / f"{name}.toml").read_text())


def arrays_of(group, path):
    """All arrays below a group, also those with several names, of which visititems visits only one."""
    for name, item in group.items():
        if isinstance(item, h5py.Dataset):
            yield path + name, item[()]
        else:
            yield from arrays_of(item, f"{path}{name}/")


class Ran:
    """A run: the numbers of its archive by name, its scene with all keys, and the output of explain."""

    def __init__(self, folder, scene, keys):
        words = [MODELS / f"{scene}.toml", *settings(keys)]
        drover(folder, "run", *words, "--quiet", "--threads", "1")
        self.archive = folder / f"{scene}.h5"
        self.told = drover_json(folder, "explain", *words)
        self.scene = tomllib.loads(drover(folder, "check", *words, "--resolved").stdout)
        with h5py.File(folder / f"{scene}.h5") as file:
            self.arrays = dict(arrays_of(file, ""))

    def __getitem__(self, name):
        return self.arrays[name]

    def __contains__(self, name):
        return name in self.arrays

    def series(self, name):
        return self.arrays["series/" + name]

    @property
    def spheres(self):
        """Positions (frame, sphere, 3), radii and times."""
        return (self["particles/spheres/position/value"], self["particles/spheres/radius"],
                self["particles/spheres/position/time"])

    def count(self, kind):
        return self[f"bodies/{kind}/mass"].size if f"bodies/{kind}/mass" in self else 0

    def ways(self):
        """Displacement of each rod between frames, along its n and to the left of it: two arrays (step, rod)."""
        path, axis = self["bodies/rods/position/value"][..., :2], self["bodies/rods/axis/value"][..., :2]
        step, n = np.diff(path, axis=0), axis[:-1] + axis[1:]
        n /= np.linalg.norm(n, axis=-1, keepdims=True)
        return (step * n).sum(-1), step[..., 1] * n[..., 0] - step[..., 0] * n[..., 1]


@pytest.fixture(scope="module", name="ran")
def runs_made_once(tmp_path_factory):
    made = {}

    def ran(scene):
        if scene not in made:
            made[scene] = Ran(tmp_path_factory.mktemp(scene), scene, SHORT[scene])
        return made[scene]
    return ran


# --- the list of scenes

def test_every_scene_is_shortened_here_and_listed_in_the_readme():
    assert SCENES == scenes("particles")
    listed = dict(re.findall(r"^\| `([a-z-]+)\.toml` \|.*\| ([^|]+) \|$", (MODELS / "README.md").read_text(), re.M))
    for scene in SCENES:
        first, second = (MODELS / f"{scene}.toml").read_text().splitlines()[:2]
        assert re.fullmatch(r"# Shows: .+\.", first)
        takes = re.fullmatch(r"# Takes: (.+)\.", second).group(1)
        assert listed[scene] == takes, scene


def test_scenes_of_matched_rods_have_the_same_rods_and_plates():
    model = scene_of("rod-matched")
    for name in MATCHED:
        scene = scene_of(name)
        assert scene["plates"] == model["plates"], name
        assert scene["rods"]["size_tolerance"] == model["rods"]["size_tolerance"], name
        assert scene["kick"]["strength"] == {"rod-matched": 0.0265, "rods-alone": 0.015}.get(name, 0.018), name


@pytest.mark.parametrize("rich, poor", [("bead-flock", "bead-poor"), ("flower-flock", "flower-poor")])
def test_paired_scenes_differ_only_in_their_beads(rich, poor):
    one, other = scene_of(rich), scene_of(poor)
    assert one["beads"].pop("area_fraction") == pytest.approx(3.0 * other["beads"].pop("area_fraction"))
    assert one == other


def test_the_settings_of_studies_make_matched_rods_those_of_the_paper_as_printed():
    sys.path.insert(0, str(MODELS.parent / "tests" / "bench" / "particles"))
    from flocks import RODS
    made = drover_package.Scene.load(MODELS / "bead-flock.toml").set(RODS["printed"]).to_toml()
    assert made == drover_package.Scene.load(MODELS / "paper-flock.toml").to_toml()


@pytest.mark.parametrize("scene", SCENES)
def test_an_unmodified_scene_starts_at_rest_without_order(scene, tmp_path):
    run = Ran(tmp_path, scene, ["time.end=0.0002", "output.frame_every=0", "output.sample_every=0"])
    assert run.series("energy_kinetic")[0] == 0.0
    if scene not in WITH_RODS:
        return
    axis = run["bodies/rods/axis/value"][0]
    # All rods lie flat: heads of .72 mm and tails of 1.1 mm, 3.6 mm apart, in a gap of 1.2 mm.
    assert np.abs(axis[:, 2]).max() < 0.1
    angles, rods = np.arctan2(axis[:, 1], axis[:, 0]), len(axis)
    if rods > 1:
        # N random directions have a mean longer than 3/sqrt(N) in one of exp(9) = 8000 packings.
        for turns in (1, 2):
            assert abs(np.exp(1j * turns * angles).mean()) < 3.0 / math.sqrt(rods)



def panel_of(scene):
    """What the figure of a scene shows beside the bodies: what its header is about."""
    if scene == "bead-gas":
        return "pair correlation of the beads"
    if scene in ("circle-flock", "flower-flock", "flower-poor"):
        return "polar order about the centre"
    alone = scene not in WITH_BEADS or scene.endswith("rod-in-beads")
    return "memory of the direction" if alone else "bead velocity order"


@pytest.mark.parametrize("scene", slow_but(SCENES, "paper-flock", "rod", "circle-flock"))
def test_the_figure_of_a_scene_has_labels_and_no_legend_on_its_data(scene, ran):
    with drover_package.open_run(ran(scene).archive) as run:
        picture = drover_package.plot.figure(run)
        titles = [axes.get_title(loc="left") for axes in picture.axes]
    assert any(panel_of(scene) in title for title in titles)
    assert ("(b) beads around a rod" in titles) == (scene in WITH_RODS and scene in WITH_BEADS)
    picture.set_dpi(60)  # fewer pixels, same layout
    assert overlaps(picture) == [] and covered(picture) == [] and unlabelled(picture) == []
    assert any("time $t$ [s]" == axes.get_xlabel() for axes in picture.axes)


# --- every run

@pytest.mark.parametrize("scene", SCENES)
def test_all_frames_have_the_bodies_of_the_scene(scene, ran):
    run = ran(scene)
    frames = len(run.spheres[2])
    assert frames >= 6
    assert run.told["spheres"] == run.spheres[0].shape[1] == run.count("beads") + 13 * run.count("rods")
    for kind in ("beads", "rods"):
        asked = run.scene[kind]
        assert (asked["count"] > 0 or asked["area_fraction"] > 0.0) == (run.count(kind) > 0)
        if run.count(kind) == 0:
            assert not any(name.startswith(f"bodies/{kind}") for name in run.arrays)
            continue
        assert run.told[kind]["count"] == run.count(kind)
        if asked["count"] > 0:
            assert asked["count"] == run.count(kind)
        else:  # half a body, and as much for rods of sizes that differ
            assert run.told[kind]["area_fraction"] == pytest.approx(asked["area_fraction"],
                                                                    rel=0.75 / run.count(kind) + 0.005)
        for what in ("position", "velocity", "angular_velocity"):
            values = run[f"bodies/{kind}/{what}/value"]
            assert values.shape == (frames, run.count(kind), 3) and np.isfinite(values).all()


@pytest.mark.parametrize("scene", SCENES)
def test_energy_balances_and_no_impact_remains_unresolved(scene, ran):
    run = ran(scene)
    balance = run.series("energy_balance")
    turnover = sum(abs(run.series(f"work_{part}")[-1]) for part in ("plates", "gravity", "kicks", "impact", "friction"))
    # Rounding of 1e4 to 1e7 sums of relative error 1e-16: the maximum of all scenes was 1e-12.
    assert np.abs(balance - balance[0]).max() < 1e-10 * turnover
    assert run.series("work_plates")[-1] > 0.0
    impact, friction = (np.diff(run.series(f"work_{part}")) for part in ("impact", "friction"))
    assert impact.max() <= 0.0 and (impact + friction).max() <= 0.0
    # Friction along the slip before an impact may gain a part of what is lost along the normals.
    assert friction.max() <= 0.0 or run.scene["contacts"]["law"] == "pairwise"
    assert run.series("work_forces")[-1] == 0.0  # no scene has forces
    assert run.series("impacts_unresolved")[-1] == 0.0


@pytest.mark.parametrize("scene", SCENES)
def test_bodies_hardly_overlap(scene, ran):
    overlap = ran(scene).series("overlap_largest")
    # In 20 us a fast pair, at 0.1 m/s, comes 2 um nearer: .005 of a bead's radius; the maximum of all scenes was 0.006.
    assert 0.0 <= overlap[-1] < 0.01 and (np.diff(overlap) >= 0.0).all()
    assert ran(scene)["summary/overlap_largest"] == overlap[-1]


@pytest.mark.parametrize("scene", SCENES)
def test_bodies_stay_between_the_plates(scene, ran):
    run = ran(scene)
    place, radius, time = run.spheres
    plates = run.scene["plates"]
    base = plates["amplitude"] * (1.0 + np.cos(2.0 * math.pi * plates["frequency"] * time))[:, None]
    assert np.ptp(base[1:]) > plates["amplitude"]  # at several phases
    # Pairs move each other after the contacts with the plates, by as much as they overlapped.
    assert ((place[..., 2] - radius - base) / radius).min() > -0.01
    assert ((base + plates["gap"] - place[..., 2] - radius) / radius).min() > -0.01


def wall_distance(cell, x, y):
    """Distance from positions to the wall of a circle or a flower; negative outside."""
    if cell["shape"] == "circle":
        return cell["radius"] - np.hypot(x, y)
    half, corner = math.pi / cell["petals"], cell["radius"]
    width = math.asin(corner * math.sin(half) / cell["petal_radius"])  # half the angle of an arc, from its centre
    centre = corner * math.cos(half) - cell["petal_radius"] * math.cos(width)
    angle, r = np.arctan2(y, x), np.hypot(x, y)
    # Maps each petal to the upper half of the first.
    angle = np.abs(angle - 2.0 * half * np.round(angle / (2.0 * half)))
    px, py = r * np.cos(angle), r * np.sin(angle)
    from_corner = np.hypot(px - corner * math.cos(half), py - corner * math.sin(half))
    return np.where(np.arctan2(py, px - centre) <= width, cell["petal_radius"] - np.hypot(px - centre, py), from_corner)


def test_the_distance_to_a_flower_agrees_with_its_geometry():
    cell = {"shape": "flower", "radius": 8.0, "petals": 6, "petal_radius": 5.0}
    # 8 cos 30 - 3, and 5 beyond
    assert wall_distance(cell, 4.0 * math.sqrt(3.0) + 2.0, 0.0) == pytest.approx(0.0, abs=1e-12)
    assert wall_distance(cell, 0.0, 0.0) == pytest.approx(8.0)
    assert wall_distance(cell, 4.0 * math.sqrt(3.0), 4.0) == pytest.approx(0.0, abs=1e-12)  # a corner
    assert wall_distance(cell, 4.0 * math.sqrt(3.0) - 0.5, 4.0 - 0.5 / math.sqrt(3.0)) > 0.0
    assert wall_distance(cell, 12.0, 0.5) < 0.0


@pytest.mark.parametrize("scene", ["circle-flock", "flower-flock", "flower-poor"])
def test_bodies_stay_inside_the_wall(scene, ran):
    run = ran(scene)
    place, radius, _ = run.spheres
    gap = (wall_distance(run.scene["cell"], place[..., 0], place[..., 1]) - radius) / radius
    assert -0.01 < gap.min() < 0.2  # as with plates; some body is near the wall
    assert {"series/polar_order_local", "series/polar_order_azimuthal", "series/impacts_rod_wall"} <= set(run.arrays)
    assert run.series("impacts_bead_wall")[-1] > 0.0


@pytest.mark.parametrize("scene", WITH_BEADS)
def test_beads_have_a_higher_vertical_than_horizontal_temperature(scene, ran):
    run = ran(scene)
    late = len(run.series("energy_kinetic")) // 2
    along, up = (run.series(f"bead_temperature_{way}")[late:].mean() for way in ("horizontal", "vertical"))
    assert 0.0 < along < 0.5 * up  # the plates shake only vertically; measured ratios are 0.05 to 0.1
    assert run.series("impacts_bead_bead")[-1] > 1.0 and run.series("impacts_bead_plate")[-1] > 1.0


# --- the physics of each scene

def test_a_single_rod_moves_along_its_axis(ran):
    run = ran("rod")
    along, across = run.ways()
    # Its gaits have 12.45 and -7.38 mm/s; rounding can select either.  The start may cost a third of the slower one.
    assert run.count("rods") == 1 and run.count("beads") == 0 and abs(along.sum()) > 5.0
    assert np.abs(across).sum() < 0.25 * np.abs(along).sum()
    assert run.series("work_kicks")[-1] != 0.0 and run.series("impacts_rod_plate")[-1] > 100.0


def test_matched_rods_move_head_first_at_the_speed_of_the_experiment(ran):
    run = ran("rod-matched")
    speeds = run.ways()[0].sum(0) / run.spheres[2][-1]
    # 3.6 mm/s with a spread of 2.5 among rods: the mean of eight is within 3 errors of it.
    assert np.mean(speeds) == pytest.approx(3.6, abs=3.0 * 2.5 / math.sqrt(8.0))
    assert np.ptp(run["bodies/rods/mass"]) > 0.0  # different sizes


def test_the_rod_of_the_paper_moves_head_first_in_one_gait(ran):
    run = ran("paper-rod")
    speeds = run.ways()[0][-20:].sum(0) / (20 * 0.052)
    # The plain program of tests/bench/particles has 5.97(2) mm/s, with a spread of 0.1 over a second.
    assert speeds == pytest.approx(6.0, abs=0.6)
    assert run.series("impacts_limited")[-1] == 0.0  # friction never creates energy with the numbers of the paper


@pytest.mark.parametrize("scene", ["rod-in-beads", "paper-rod-in-beads"])
def test_one_rod_in_beads_pushes_them(scene, ran):
    run = ran(scene)
    assert run.count("rods") == 1 and run.count("beads") > 50
    assert run.series("impacts_rod_bead")[-1] > 10.0
    assert np.abs(run.ways()[0].sum()) > 0.1  # a part of 3.6 mm/s in 0.3 s


def test_rods_alone_have_no_beads_and_keep_their_directions(ran):
    run = ran("rods-alone")
    assert run.count("beads") == 0 and run.count("rods") > 1
    assert not any("bead" in name for name in run.arrays)
    axis = run["bodies/rods/axis/value"][..., :2]
    turned = np.arctan2(axis[-1, :, 1], axis[-1, :, 0]) - np.arctan2(axis[0, :, 1], axis[0, :, 0])
    # 1/D_r is 2.5 s (.0215/.005)^2 = 46 s: .1 rad in 0.3 s.  At least half of the rods had no collision.
    assert np.median(np.abs((turned + math.pi) % (2.0 * math.pi) - math.pi)) < 0.35


def test_the_amorphous_bed_has_equal_numbers_of_beads_of_five_sizes(ran):
    radius = ran("amorphous")["bodies/beads/radius"]
    sizes, counts = np.unique(radius, return_counts=True)
    assert sizes == pytest.approx([0.35, 0.375, 0.4, 0.425, 0.45]) and np.ptp(counts) <= 1


@pytest.mark.parametrize("scene", [scene for scene in WITH_BEADS if scene in WITH_RODS])
def test_rods_touch_beads(scene, ran):
    run = ran(scene)
    assert run.series("impacts_rod_bead")[-1] > 1.0
    assert np.abs(run.ways()[0]).max() > 0.0 and "summary/flow_velocity_along" in run


def test_the_pair_correlation_of_a_bead_gas_has_a_hole_and_a_peak(ran):
    run = ran("bead-gas")
    r, g = run["series/bead_separation"], run["summary/pair_correlation_beads"]
    # Two beads at base and lid, with a clearance of 0.4 mm, are sqrt(0.8^2 - 0.4^2) = 0.69 mm apart in the plane.
    assert g[r < 0.6].max() == 0.0 and 1.1 < g.max() < 5.0
    drift, heat = run.series("bead_velocity_size"), run.series("bead_temperature_horizontal")
    free = np.sqrt(2.0 * heat[-1] / (0.7238 * run.count("beads")))  # of as many independent beads
    assert drift[-1] < 5.0 * free


def test_the_full_size_scene_has_the_size_of_the_paper(tmp_path):
    told = drover_json(tmp_path, "explain", MODELS / "full-size.toml")
    assert (told["beads"]["count"], told["rods"]["count"]) == (73385, 1642)
    assert told["cell_area"] == pytest.approx((55.1 * 4.5)**2)
