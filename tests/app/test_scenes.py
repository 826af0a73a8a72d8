"""tests/app/test_scenes.py: every scene of fields of models/ runs, shows its physics, and has a cost in explain.

--set reduces grids and times so that all scenes together take half a minute.
"""
import math
import re

import h5py
import numpy as np
import pytest
from pictures import covered, overlaps, unlabelled
from scipy.optimize import curve_fit
from support import MODELS, drover, drover_json, scenes, settings, slow_but

import drover as drover_package

SCENES = scenes("fields")  # those of particles are in test_particle_scenes.py

# Shortened settings of scenes, some tested for their physics and some only for running.
SHORT = {
    "isotropic": ["grid.nx=64", "grid.ny=64", "grid.lx=64", "grid.ly=64", "time.end=100"],
    "isotropic-beads": ["time.end=300"],
    "flock": ["grid.nx=48", "grid.ny=48", "grid.lx=48", "grid.ly=48", "time.end=200", "output.frame_every=100"],
    "number-fluctuations": ["grid.nx=64", "grid.ny=64"],
    "noisy-flock": ["grid.nx=32", "grid.ny=32", "grid.lx=320", "grid.ly=320", "time.end=3000"],
    "band": ["time.dt=0.1", "time.end=50", "grid.ny=8"],
    "banding": ["grid.nx=256", "grid.ny=16", "grid.lx=256", "grid.ly=16", "time.dt=0.2", "time.end=800"],
    "kink": ["grid.ny=4", "grid.ly=1"],
    "point-force": ["grid.nx=128", "grid.ny=128", "grid.lx=64", "grid.ly=64", "force.at_x=32", "force.at_y=32"],
    "point-force-moving": ["grid.nx=128", "grid.ny=128", "grid.lx=128", "time.end=5"],
    "barenblatt": ["grid.nx=128", "grid.ny=128"],
    "phase-boundary": ["grid.nx=32", "grid.ny=32", "grid.lx=48", "grid.ly=48", "time.end=50", "output.frame_every=50"],
    "calibrated-flock": ["time.end=50"],
    "calibrated-poor": ["time.end=50"],
    "quench": ["grid.nx=64", "grid.ny=64", "grid.lx=64", "grid.ly=64", "time.end=100"],
}


class Ran:
    """A run: its fields and series by name, and its output."""

    def __init__(self, folder, scene, more=()):
        name = scene + ".h5"
        self.archive = folder / name
        self.told = drover_json(folder, "run", MODELS / (scene + ".toml"), "--overwrite", "--quiet", "--threads", "1",
                                *settings([*SHORT[scene], *more]))
        self.arrays = {}
        with h5py.File(folder / name) as file:
            def take(path, item):
                if isinstance(item, h5py.Dataset):
                    self.arrays[path] = item[()]
            file.visititems(take)

    def __getitem__(self, name):
        return self.arrays[name]

    def series(self, name):
        return self.arrays["observables/" + name]

    def mean(self, name):
        return self.told["results"][name]["mean"]


@pytest.fixture(scope="module", name="ran")
def runs_made_once(tmp_path_factory):
    made = {}

    def ran(scene):
        if scene not in made:
            made[scene] = Ran(tmp_path_factory.mktemp(scene), scene)
        return made[scene]
    return ran


def test_every_scene_is_shortened_here_and_listed_in_the_readme():
    assert sorted(SHORT) == SCENES
    listed = re.findall(r"^\| `([a-z-]+)\.toml` \|", (MODELS / "README.md").read_text(), re.M)
    assert set(SCENES) <= set(listed)


@pytest.mark.parametrize("scene", SCENES)
def test_the_first_lines_describe_a_scene_and_its_cost(scene):
    first, second = (MODELS / (scene + ".toml")).read_text().splitlines()[:2]
    assert re.fullmatch(r"# Shows: .+\.", first) and re.fullmatch(r"# Takes: .+\.", second)


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_runs_and_conserves_its_totals(scene, ran):
    run = ran(scene)
    for name, values in run.arrays.items():
        # The flow has no direction where nothing flows, and sectors of a shell may hold no mode.
        if name.startswith("observables/") and not name.endswith(("_direction", "flow_alignment")):
            assert np.isfinite(values).all(), name
    for name in ("rods_total", "beads_total"):
        if "observables/" + name in run.arrays:
            total = run.series(name)
            # Rounding of the mode q = 0, which no term touches.
            assert np.abs(total / total[0] - 1.0).max() < 1e-13, name


@pytest.mark.parametrize("scene", slow_but(SCENES, "noisy-flock", "band", "isotropic"))
def test_the_figure_of_a_scene_has_labels_and_no_legend_on_its_data(scene, ran):
    with drover_package.open_run(ran(scene).archive) as run:
        picture = drover_package.plot.figure(run)
        picture.set_dpi(60)  # fewer pixels, same layout
        titles = [axes.get_title(loc="left") for axes in picture.axes]
        noisy = any(run.scene["noise"].values())
        assert ("(c) number fluctuations" if noisy else "(c) deviations") in titles
    assert overlaps(picture) == [] and covered(picture) == [] and unlabelled(picture) == []
    texts = [axes.get_xlabel() for axes in picture.axes]
    assert "$x$ [mm]" in texts and "time $t$ [s]" in texts


# --- the physics of each scene

def test_fluctuations_of_rods_among_beads_are_those_of_linear_theory(ran):
    run = ran("isotropic-beads")
    for name in ("structure_factor_rods", "structure_factor_order_across"):
        measured, linear = run["summary/" + name], run["summary/" + name + "_linear"]
        # 300 s contain about 60 independent samples of 8 to 60 modes per shell: 3 per cent; the nonlinear terms
        # contribute as much.
        assert np.abs(measured[5:] / linear[5:] - 1.0).mean() < 0.06, name


def test_fields_on_a_table_have_the_drag_that_was_measured(ran):
    run = ran("calibrated-flock")
    with h5py.File(MODELS / "matched.calibration" / "table.h5") as table:
        dense = list(table["bead_area_fraction"]).index(0.6)
        drag, response, error = (table[name][dense, -1]
                                 for name in ("drag", "response_time", "response_time_error"))
    assert max(response, error) < 0.2  # s: far below the time of 1 s in which the order of this run changes
    p, v = (run.series(f"{name}_mean_x") for name in ("polar_order", "bead_velocity"))
    assert np.polyfit(p[50:], v[50:], 1)[0] == pytest.approx(drag, rel=0.05)


def test_a_flock_carries_its_beads(ran):
    run = ran("flock")
    p0 = math.sqrt(0.2 / 0.4)  # mean field; noise reduces it by some per cent
    assert 0.9 * p0 < run.mean("polar_order") < p0
    assert run.mean("bead_velocity_order") > 0.98
    late = len(run.series("polar_order")) // 2
    # v = alpha p/Gamma, 1 mm/s at full order; the delay by inertia is small: Gamma/(m rho) = 20 /s against rates below
    # 1 /s.
    assert run.series("bead_velocity_mean_x")[late:] == pytest.approx(run.series("polar_order_mean_x")[late:], rel=0.02)


def test_rods_have_giant_number_fluctuations(ran):
    run = ran("number-fluctuations")
    deviation, number = run["summary/rod_number_deviation"], run["summary/rod_number"]
    assert np.isfinite(run["summary/rod_number_deviation_error"]).all()  # even this short run has every error
    ratio = deviation / np.sqrt(number)
    assert ratio.max() > 1.5 and ratio.argmax() >= len(ratio) - 3  # free rods: 1
    exponents, errors = run["summary/rod_number_exponent"][:-1], run["summary/rod_number_exponent_error"][:-1]
    assert (exponents - 5.0 * errors > 0.6).any()  # free rods: 0.5, and less on a finite cell


def test_a_noisy_flock_has_giant_fluctuations_in_large_boxes_and_shot_noise_in_small_ones(ran):
    run = ran("noisy-flock")
    ratio = run["summary/rod_number_deviation"] / np.sqrt(run["summary/rod_number"])
    linear = run["summary/rod_number_deviation_linear"] / np.sqrt(run["summary/rod_number"])
    assert ratio.max() > 1.5 and ratio[1] < 1.0  # independent rods: 1
    # 3000 s contain about 40 correlation times of the longest wave, and the noise reduces the order by 5 per cent.
    assert np.abs(ratio / linear - 1.0).max() < 0.15
    assert 0.6 < run.mean("polar_order") < math.sqrt(0.2 / 560) / 0.0267


def test_a_band_moves_as_its_formula_predicts(ran):
    run = ran("band")
    time, density = run["time"], run["rod_density"]
    speed, side = 2.0 / math.sqrt(3.0), 128.0
    first = np.fft.fft(density.mean(1), axis=1)[:, 1]  # the longest wave: its phase is the position of the band
    moved = -np.unwrap(np.angle(first)) * side / (2.0 * math.pi)
    measured = (moved[-1] - moved[1]) / (time[-1] - time[1])
    # At dt = 0.1 s the error of a step changes its speed by 1e-5; the fronts interact by exp(-48 p_l/2) = 1e-6.
    assert measured == pytest.approx(speed, rel=3e-5)
    waves = 2j * math.pi * np.fft.fftfreq(density.shape[2], side / density.shape[2])
    shifted = np.fft.ifft(np.fft.fft(density[0].mean(0)) * np.exp(-waves * speed * time[-1])).real
    # the same, times the steepest slope, 0.1 /mm^3, and 58 mm
    assert np.abs(density[-1].mean(0) - shifted).max() < 2e-4
    assert density[-1].min() == pytest.approx(5.0 / 6.0, abs=1e-4)
    assert density[-1].max() == pytest.approx(4.0 / 3.0, abs=1e-4)
    assert np.ptp(density[-1], axis=0).max() < 1e-12  # uniform along the fronts


def band_profile(x, side, gas, liquid, ahead, kappa_ahead, behind, kappa_behind):
    """Density of a band between two fronts 1/(1 + exp(kappa z)) in a periodic cell."""
    height = sum(1.0 / (1.0 + np.exp(kappa_ahead * (x - ahead - image)))
                 + 1.0 / (1.0 + np.exp(-kappa_behind * (x - behind - image))) - 1.0
                 for image in (-side, 0.0, side))
    return gas + (liquid - gas) * height


def measured_band(run, side, first):
    """Speed, densities and both 1/front width of the only band of a run.

    The values are fits to the frames from number `first` on.
    """
    time, profiles = run["time"][first:], run["rod_density"].mean(1)[first:]
    x = side / profiles.shape[1] * np.arange(profiles.shape[1])
    fits = []
    for profile in profiles:
        above = profile > 0.5 * (profile.min() + profile.max())
        falls, = np.nonzero(above & ~np.roll(above, -1))
        rises, = np.nonzero(~above & np.roll(above, -1))
        assert len(falls) == len(rises) == 1
        ahead = x[falls[0]]
        guess = (profile.min(), profile.max(), ahead, 1.0, ahead - (ahead - x[rises[0]]) % side, 1.0)
        fits.append(curve_fit(lambda at, *shape: band_profile(at, side, *shape), x, profile, guess)[0])
    gas, liquid, ahead, kappa_ahead, behind, kappa_behind = np.array(fits).T
    speeds = [np.polyfit(time, np.unwrap(front, period=side), 1)[0] for front in (ahead, behind)]
    return {"speed of the front ahead": speeds[0], "speed of the front behind": speeds[1], "gas": gas[-1],
            "liquid": liquid[-1], "kappa ahead": kappa_ahead[-1], "kappa behind": kappa_behind[-1]}


def assert_band_is_that_of_the_formula(found, tolerance):
    c, p = 2.0 / math.sqrt(3.0), 1.0 / math.sqrt(3.0)
    exact = {"speed of the front ahead": c, "speed of the front behind": c, "gas": 5.0 / 6.0, "liquid": 4.0 / 3.0,
             "kappa ahead": p, "kappa behind": p / 2.0}
    errors = {name: found[name] / exact[name] - 1.0 for name in exact}
    print(", ".join(f"{name} {found[name]:.6f} ({error:+.1e})" for name, error in errors.items()))
    assert max(map(abs, errors.values())) < tolerance, errors


def test_a_band_keeps_the_speed_the_densities_and_the_fronts_of_its_formula(ran):
    # At dt = 0.1 s the error of etdrk2 widens the front ahead by 3 parts in 10^4, at 0.2 s by four times as much; all
    # other values are correct to 1 in 10^4.
    assert_band_is_that_of_the_formula(measured_band(ran("band"), 128.0, 0), 1e-3)


def test_a_band_relaxes_to_the_speed_densities_and_fronts_of_its_formula(tmp_path):
    # Both fronts start too steep, by factors of 1.4 and 2.8; order and density of the band start too low and its gas
    # too dense.  The totals are those of 80 mm of liquid in 192 mm; the excess spreads between the fronts for some
    # hundred seconds.
    height = "0.9 * (1 / (1 + exp(0.8 * (x - 112))) + 1 / (1 + exp(-0.8 * (x - 32))) - 1)"
    excess = 0.5 * 80.0 / 192.0 * 0.1
    run = Ran(tmp_path, "band",
              ["grid.nx=384", "grid.ny=4", "grid.lx=192", "time.dt=0.2", 'time.stepper="etdrk4"', "time.end=2000",
               "output.frame_every=50", f'initial.rod_density="5/6 + {excess} + 0.5 * {height}"',
               f'initial.polar_order_x="1 / sqrt(3) * {height}"'])
    start = run["rod_density"][0]
    assert start.max() < 1.31 and start.min() > 0.85
    # The fronts interact by exp(-80 p_l/2) = 1e-10; the initial deviation decays from 2e-2 after 100 s to 3e-7 after
    # 2000 s.
    assert_band_is_that_of_the_formula(measured_band(run, 192.0, 30), 1e-5)


def test_a_uniform_flock_near_its_threshold_breaks_into_bands(ran):
    run = ran("banding")
    spread = run.series("max_rod_density") - run.series("min_rod_density")
    assert spread[5:20].max() < 0.05
    # The plateaus are those of the infinite band, except for what remains of the merging of bands.
    assert run.series("min_rod_density")[-1] == pytest.approx(5.0 / 6.0, abs=0.01)
    assert run.series("max_rod_density")[-1] == pytest.approx(4.0 / 3.0, abs=0.02)
    # Bands lie across the order: the density varies along x, not along y.
    density = run["rod_density"][-1]
    assert density.mean(0).std() > 3.0 * density.mean(1).std()


def test_walls_across_a_flock_are_stationary(ran):
    run = ran("kink")
    x = np.arange(512) / 16.0
    wall = np.tanh(x - 8.0) - np.tanh(x - 24.0) - 1.0
    for name in ("polar_order_y", "bead_velocity_y"):
        # The formula lacks the tail of the next image, which the run contains: 2 exp(-16) = 2.3e-7 half-way between two
        # walls.  The modes beyond the cut contain 5e-9, and the walls attract each other by exp(-32).
        assert np.abs(run[name][-1] - wall).max() < 3e-7
    for name in ("rod_density", "bead_density"):
        assert np.abs(run[name] - 1.0).max() < 1e-13
    assert np.abs(run["polar_order_x"]).max() < 1e-9  # rounding, 1e-16, times exp(0.25 * 40)


def cell_of_force(run, side, at, axis):
    """v_x along a line through the force, by distance from it, in units of f/(2 pi eta)."""
    v = run["bead_velocity_x"][-1] / (100.0 / (2.0 * math.pi * 64.0))
    points = v.shape[0]
    i, j = (round(place / side * points) for place in at)
    line = v[j, :] if axis == "x" else v[:, i]
    return np.roll(line, -(i if axis == "x" else j))


def test_a_force_at_rest_ends_with_flow_without_divergence(ran):
    run = ran("point-force")
    along, across = (cell_of_force(run, 64.0, (32.0, 32.0), axis) for axis in "xy")
    # In a periodic cell of 16 ell, and with the mean flow f/(Gamma area): two per cent of f/(2 pi eta).
    cell = 0.5 / 4.0
    for z, free in ((1.5, 0.25952), (2.0, 0.18007)):
        assert along[round(z / cell)] == pytest.approx(free, abs=0.03)
    assert across[round(2.0 / cell)] < -0.02 and across[round(0.75 / cell)] > 0.05  # changes sign at z = 1.1144
    vx, vy = (run[f"bead_velocity_{axis}"][-1] for axis in "xy")
    q = 2.0 * math.pi * np.fft.fftfreq(128, 0.5)
    fx, fy = np.fft.fft2(vx), np.fft.fft2(vy)
    div, curl = q[None, :] * fx + q[:, None] * fy, q[None, :] * fy - q[:, None] * fx
    assert np.linalg.norm(div) < 0.02 * np.linalg.norm(curl)  # of second order: the density varies by 0.7 per cent


def test_a_moving_force_pushes_all_beads_in_its_direction(ran):
    run = ran("point-force-moving")
    along, across = (cell_of_force(run, 128.0, (24.0 + 8.0 * 5.0, 64.0), axis) for axis in "xy")
    for z, free in ((1.0, 0.42102), (1.5, 0.21381)):  # K0(z); compressible, so far from the force: D/(U ell) = 0.5
        assert along[round(4.0 * z)] == pytest.approx(free, abs=0.03)
        assert across[round(4.0 * z)] == pytest.approx(free, abs=0.03)


def error_of_barenblatt(run):
    density, points = run["bead_density"], run["bead_density"].shape[1]
    x = 32.0 / points * np.arange(points) - 16.0
    square = x[None, :]**2 + x[:, None]**2
    exact = np.maximum(0.0, 1.0 - square / 16.0 / 4.0) / 4.0  # at t = 16
    undershoot = max(-frame.min() / frame.max() for frame in density)
    return np.abs(density[-1] - exact).sum() / exact.sum(), undershoot


def test_beads_spread_into_a_vacuum_as_the_barenblatt_solution(tmp_path, ran):
    coarse, _ = error_of_barenblatt(Ran(tmp_path, "barenblatt", ["grid.nx=64", "grid.ny=64"]))
    middle, _ = error_of_barenblatt(ran("barenblatt"))
    fine, undershoot = error_of_barenblatt(Ran(tmp_path, "barenblatt", ["grid.nx=256", "grid.ny=256"]))
    assert fine < 2e-3 and undershoot < 5e-3
    assert math.log2(coarse / fine) / 2.0 > 1.5 and math.log2(middle / fine) > 1.5  # second order except at the edge


def test_order_grows_after_a_quench(ran):
    run = ran("quench")
    assert run.series("structure_factor_order_across").shape[0] == 101
    largest = run.series("polar_order_largest")
    # Order grows to p0 = sqrt(0.4), also where the densities differ from the mean, since coefficients are constant;
    # waves overshoot slightly.
    assert largest[0] < 0.06 and math.sqrt(0.4) * 0.95 < largest[-1] < math.sqrt(0.4) * 1.2
    order = run.series("polar_order")
    assert order[-1] > 10.0 * order[0]
    assert run.series("bead_speed")[-1] > 0.3  # alpha p0/Gamma = 0.38
    # Coarsening: the correlation length of the order, from its structure factor, grows between the middle and the end.
    q = run.series("wavenumber")
    def mean_q(power):
        return (q**2 * power).sum() / (q * power).sum()
    power = run.series("structure_factor_order_across") + run.series("structure_factor_order_along")
    assert mean_q(power[-1]) < mean_q(power[30])


# --- explain

@pytest.mark.parametrize("scene", SCENES)
def test_explain_reports_the_cost_of_a_scene(scene, tmp_path):
    told = drover_json(tmp_path, "explain", MODELS / (scene + ".toml"))
    count = told["transforms_per_right_hand_side"]
    stages = {"isotropic": 0, "number-fluctuations": 4, "noisy-flock": 4}.get(scene, 2)
    assert told["right_hand_sides_per_step"] == stages
    assert told["transforms_per_step"] == stages * (count["inverse"] + count["forward"])
    assert (count["inverse"] == count["forward"] == 0) == (scene == "isotropic")
    text = drover(tmp_path, "explain", MODELS / (scene + ".toml")).stdout
    nx, ny = map(int, re.search(r"fields on (\d+) by (\d+) points", text).groups())
    for axis, points in (("x", nx), ("y", ny)):
        kept = told["largest_mode_kept"][axis]
        assert kept * (told["degree"] + 1) < points <= (kept + 1) * (told["degree"] + 1)
    assert told["memory_bytes"] > 8 * nx * ny * len(told["fields"])
    assert 0.0 < told["seconds_per_step_estimate"]
    assert told["seconds_per_step_estimate"] * told["steps"] <= told["seconds_estimate"]
    assert f"  form: {told['form']}\n" in text and "(estimate)" in text
    assert [term["name"] for term in told["terms"] if term["name"] not in text] == []


def test_a_form_with_fewer_fields_makes_fewer_transforms(tmp_path):
    common = ["relaxation.rate=-1", "relaxation.saturation=1", "advection.strength=1", "elasticity.stiffness=1",
              "grid.nx=32", "grid.ny=32"]
    beads = ["fields.bead_density=true", 'fields.bead_velocity="dynamic"', "drag.coefficient=1", "driving.strength=1",
             "weathercock.strength=1", "stiffness.beads=1"]
    (tmp_path / "empty.toml").write_text("")
    forms = {"polar": ["fields.rod_density=false"], "dilute": ["fields.rod_density=false", *beads],
             "two-component": [*beads, "current.speed=1", 'current.kind="density-order"', "pressure.rods=1"]}
    transforms = []
    for name, keys in forms.items():
        told = drover_json(tmp_path, "explain", "empty.toml", *settings(common + keys))
        assert told["form"] == name
        transforms.append(told["transforms_per_step"])
    assert 0 < transforms[0] < transforms[1] < transforms[2]


def test_explain_of_a_large_grid_reports_that_it_scaled(tmp_path):
    text = drover(tmp_path, "explain", MODELS / "number-fluctuations.toml", "--set", "grid.nx=2048",
                  "--set", "grid.ny=2048").stdout
    assert "smaller grid" in text and "(estimate)" in text
