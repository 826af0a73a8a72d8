"""tests/app/test_shelf.py: every scene of models/ with its own fields runs and shows its physics: exact results.

A growth rate is measured as half the rate at which the logarithm of a variance changes.  The waves are so small that
products of two of them are below the rounding errors of the fields, and linear terms are exact for any step.
"""
import re
import tomllib

import h5py
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import fsolve
from scipy.special import ive
from support import MODELS, drover, scenes, settings

# Grids and times that suffice for a run; the tests of physics below choose their own.
SHORT = {
    "active-model-b": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
    "active-nematic": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=10"],
    "bidisperse-bed": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
    "brusselator": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=10"],
    "burgers": ["grid.nx=128"],
    "cahn-hilliard": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
    "flock-as-equations": ["grid.nx=32", "grid.ny=32", "time.end=10", "analysis.warm_up=0"],
    "foraging-flock": ["grid.nx=64", "grid.ny=64", "time.end=5"],
    "ginzburg-landau": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
    "keller-segel": ["grid.nx=32", "grid.ny=32", "grid.lx=16", "grid.ly=16", "time.end=10"],
    "kpz": ["grid.nx=128", "grid.lx=128", "time.end=100"],
    "malthusian-flock": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
    "model-b": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
    "model-h": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=10"],
    "swift-hohenberg": ["grid.nx=32", "grid.ny=32", "grid.lx=25", "grid.ly=25", "time.end=20"],
    "toner-tu": ["grid.nx=64", "grid.ny=8", "grid.lx=64", "grid.ly=8", "time.end=20"],
    "two-rod-species": ["grid.nx=32", "grid.ny=32", "grid.lx=32", "grid.ly=32", "time.end=20"],
}
PI = np.pi


class Ran:
    """The archive of a run of a scene with changed keys, and its fields and observables by name."""

    def __init__(self, folder, scene, keys):
        self.archive = folder / "run.h5"
        drover(folder, "run", MODELS / f"{scene}.toml", "--overwrite", "--quiet", "--threads", "1", "-o", self.archive,
               *settings(keys))
        with h5py.File(self.archive) as file:
            self.fields = {name: item[()] for name, item in file.items()
                           if isinstance(item, h5py.Dataset) and item.ndim == 3}
            self.observables = {name: item[()] for name, item in file["observables"].items()}
            self.frame_times = file["time"][()]
            self.times = file["observables/time"][()]
            self.wavenumbers = file["observables/wavenumber"][()] if "observables/wavenumber" in file else None

    def growth_rate(self, field):
        """Half the mean rate of the logarithm of the variance, over the second half of the run."""
        variance, half = self.observables[f"variance_{field}"], len(self.times) // 2
        return 0.5 * np.log(variance[-1] / variance[half]) / (self.times[-1] - self.times[half])


@pytest.fixture(name="run")
def run_of_a_scene(tmp_path):
    return lambda scene, *keys: Ran(tmp_path, scene, keys)


def line(nx, lx, end, *more):
    """Keys of a run on a line of points along x, which keeps no more than its first and last frame."""
    return ["grid.ny=1", "grid.ly=1", f"grid.nx={nx}", f"grid.lx={lx!r}", f"time.end={end}", "output.frame_every=0",
            *more]


def start(**formulas):
    """Keys of a start from formulas."""
    return ["initial.kind=formula", "initial.amplitude=0",
            *(f"initial.{name}={text}" for name, text in formulas.items())]


def largest_rate(matrix):
    return np.linalg.eigvals(matrix).real.max()


# --- every scene

def test_every_scene_is_shortened_here_and_listed_in_the_readme():
    assert sorted(SHORT) == scenes("model")
    listed = dict(re.findall(r"^\| `([a-z-]+)\.toml` \|.*\| ([^|]+) \|$", (MODELS / "README.md").read_text(), re.M))
    for scene in SHORT:
        lines = (MODELS / f"{scene}.toml").read_text().splitlines()
        assert re.fullmatch(r"# Shows: .+\.", lines[0]), scene
        assert re.fullmatch(r"# Takes: (.+)\.", lines[1]).group(1) == listed[scene], scene
        assert len(lines) <= 40, scene


@pytest.mark.parametrize("scene", SHORT)
def test_a_scene_runs_and_conserves_its_totals(scene, run):
    made = run(scene, *SHORT[scene])
    for name, values in made.observables.items():
        if not name.endswith("_direction"):  # sectors of a shell may hold no mode
            assert np.isfinite(values).all(), name
    for field in tomllib.loads((MODELS / f"{scene}.toml").read_text())["field"]:
        if field.get("conserved"):
            mean = made.observables[f"mean_{field['name']}"]
            assert (mean == mean[0]).all(), field["name"]  # no term touches the mode q = 0


# --- flocks

def longitudinal(q, rho, order, birth=0.0, w=1.0, stiffness=1.0, c2=1.0):
    """The linear rates of density and polarity along q of a flock along q, in toner-tu.toml: by hand."""
    return np.array([[-birth, -1j * q],
                     [order - 1j * q * c2, rho - 1.0 - 3.0 * order**2 - 1j * q * w * order - stiffness * q**2]])


def flock_wave(rho, length):
    """A long wave on a uniform flock; beyond the reference state terms are explicit, so that the step makes errors."""
    return [*line(32, length, 200.0), "time.dt=0.1", "time.stepper=etdrk4", "output.sample_every=1",
            *start(density=f"{rho} + 1e-7 cos(2 pi x/{length})", polarity_x=f"sqrt({rho} - 1)")]


def test_a_flock_of_toner_and_tu_is_unstable_to_bands_near_its_threshold_only(run):
    length = 128.0
    rates = []
    for rho in (1.1, 1.2):  # the published limit is 1 + 1/6
        expected = largest_rate(longitudinal(2.0 * PI / length, rho, np.sqrt(rho - 1.0)))
        rates.append(run("toner-tu", f"coefficients.rho0={rho}", *flock_wave(rho, length)).growth_rate("density"))
        assert rates[-1] == pytest.approx(expected, rel=1e-3)  # the fourth-order step; the other mode has decayed
    assert rates[0] > 0.0 > rates[1]


def test_a_band_of_toner_and_tu_travels_at_its_exact_speed(run):
    shape = "(1/(1 + exp((x - 80)/sqrt(3))) + 1/(1 + exp((32 - x)/sqrt(12))) - 1)"
    band = run("toner-tu", "coefficients.rho0=1.0208333333333333", *line(512, 128.0, 20.0), "time.dt=0.05",
               *start(density=f"5/6 + 0.5 {shape}", polarity_x=f"{shape}/sqrt(3)"))
    first, last = (np.fft.rfft(frame[0]) for frame in band.fields["density"][[0, -1]])
    speed = -np.angle(last[1] / first[1]) * 128.0 / (2.0 * PI * 20.0)
    assert speed == pytest.approx(np.sqrt(1.0 + 1.0 / 3.0), rel=1e-5)  # the step makes an error of 3e-6
    assert abs(last) == pytest.approx(abs(first), abs=1e-4 * abs(first[1]))


def test_births_and_deaths_follow_the_logistic_curve_and_remove_the_instability_of_bands(run):
    quiet = ["coefficients.Delta=0", "coefficients.Delta_rho=0"]
    made = run("malthusian-flock", *quiet, *line(4, 8.0, 20.0), "time.stepper=etdrk4",
               *start(density="0.2", polarity_x="0"))
    logistic = 1.1 / (1.0 + (1.1 / 0.2 - 1.0) * np.exp(-0.5 * made.times))
    assert made.observables["mean_density"] == pytest.approx(logistic, rel=1e-6)  # of a fourth-order step of 0.1
    length, rates = 128.0, []
    for birth in (0.0, 0.05):
        expected = largest_rate(longitudinal(2.0 * PI / length, 1.1, np.sqrt(0.1), birth))
        keys = [*quiet, f"coefficients.g={birth}", *flock_wave(1.1, length)]
        rates.append(run("malthusian-flock", *keys).growth_rate("density"))
        assert rates[-1] == pytest.approx(expected, rel=1e-3)
    assert rates[0] > 0.0 > rates[1]


def test_a_front_that_eats_its_nutrient_is_that_of_ablowitz_and_zeppetella(run):
    grown = run("foraging-flock", *SHORT["foraging-flock"]).observables
    total = grown["mean_density"] + grown["mean_nutrient"]
    assert total == pytest.approx(total[0], rel=1e-12)  # rounding
    assert grown["mean_density"][-1] > 2.0 * grown["mean_density"][0]

    def front(radius):
        return (1.0 + np.exp((abs(np.arange(512) * 200.0 / 512 - 100.0) - radius) / np.sqrt(6.0)))**-2.0
    shape = "(1 + exp((abs(x - 100) - 30)/sqrt(6)))^(-2)"
    made = run("foraging-flock", "coefficients.u=0", "coefficients.chi=0", *line(512, 200.0, 15.0),
               "time.stepper=etdrk4", *start(density=shape, nutrient=f"1 - {shape}"))
    assert made.fields["density"][0, 0] == pytest.approx(front(30.0), abs=1e-4)
    # Where the two fronts meet, the start has a kink of 2 exp(-30/sqrt(6)) = 1e-5.
    assert made.fields["density"][-1, 0] == pytest.approx(front(30.0 + 5.0 / np.sqrt(6.0) * 15.0), abs=2e-5)


def test_rods_drag_two_species_of_beads_at_the_speeds_of_their_balance_of_forces(run):
    made = run("bidisperse-bed", "field[6].noise=0", *line(4, 8.0, 100.0), *start(order_x="0.1"))
    mobility = np.linalg.inv([[2.0 + 1.0, -1.0], [-1.0, 3.0 + 1.0]]) @ [1.5, 1.0]
    order = np.sqrt(0.2 - 0.4 + mobility @ [0.5, 0.3])
    # It has relaxed by exp(-2 order^2 100) = 1e-21; a steady state is that of the equations for any step.
    assert made.observables["mean_order_x"][-1] == pytest.approx(order, rel=1e-9)
    speeds = [made.observables[f"mean_{size}_bead_velocity_x"][-1] for size in ("small", "large")]
    assert speeds == pytest.approx(mobility * order, rel=1e-9)


def test_sound_in_a_bidisperse_bed_has_the_speed_of_both_species(run):
    free = [f"coefficients.{name}=0" for name in ("Gamma1", "Gamma2", "G", "eta", "alpha1", "alpha2")]
    made = run("bidisperse-bed", "field[6].noise=0", *free, *line(16, 32.0, 20.0),
               *start(small_beads="1 + 1e-7 cos(2 pi x/32)"))
    small, large = (np.fft.rfft(made.fields[f"{size}_beads"][-1, 0])[1].real / 8.0 / 1e-7
                    for size in ("small", "large"))
    # n = rho1 + rho2 oscillates; rho_i takes part in it with the weight E_i/m_i.
    weights = np.array([2.0 / 0.5, 3.0 / 1.5])
    change = np.cos(np.sqrt(weights.sum()) * 2.0 * PI / 32.0 * 20.0) - 1.0
    # Products of two waves of 1e-7, and the rounding of the means, 1e-16/1e-7.
    assert [small - 1.0, large] == pytest.approx(change * weights / weights.sum(), abs=1e-6)


@pytest.mark.parametrize("alpha1, alpha2, flocks",
                         [(1.0, 1.5, 1), (1.0, 0.0, -1), (0.0, 1.5, -1), (2.0 / 3.0, 1.0, 0)])
def test_two_species_of_rods_flock_where_the_sum_of_their_couplings_exceeds_one(run, alpha1, alpha2, flocks):
    made = run("two-rod-species", "coefficients.Delta=0", f"coefficients.alpha1={alpha1!r}",
               f"coefficients.alpha2={alpha2}", *line(4, 8.0, 100.0),
               *start(fast_order_x="1e-20", slow_order_x="1e-20"))
    matrix = 0.6 / 2.0 * np.outer([1.0, 1.0], [alpha1, alpha2]) - np.diag([0.4, 0.6])
    size, half = made.observables["mean_fast_order_x"] + made.observables["mean_slow_order_x"], 50
    rate = np.log(size[-1] / size[half]) / (made.times[-1] - made.times[half])
    assert rate == pytest.approx(largest_rate(matrix), abs=1e-7)  # the other mode has decayed by exp(-0.25 50)
    assert abs(rate) < 1e-7 if flocks == 0 else np.sign(rate) == flocks


# --- conserved densities

def binodals(strength):
    """Coexisting densities of d_t phi = lap mu - zeta div(lap phi grad phi), with strength = (2 lambda - zeta)/K.

    In one dimension a flat wall obeys K phi'' = f'(phi) - mu + (lambda - zeta/2) phi'^2, which is linear in phi'^2 as a
    function of phi, with the integrating factor exp(-strength phi): phi' = 0 on both sides.
    """
    def conditions(pair):
        one, other = pair
        mu = one**3 - one
        return [other**3 - other - mu,
                quad(lambda phi: (phi**3 - phi - mu) * np.exp(-strength * phi), one, other, epsabs=1e-13)[0]]
    return fsolve(conditions, [-1.0, 1.0], xtol=1e-12)


@pytest.mark.parametrize("kind, zeta", [(0.5, -0.5), (-0.4, 0.4), (0.0, 0.0)])
def test_active_phases_coexist_at_the_densities_of_the_pseudo_pressure(run, kind, zeta):
    made = run("active-model-b", f"coefficients.lambda={kind}", f"coefficients.zeta={zeta}", *line(256, 48.0, 400.0),
               *start(composition="tanh((x - 12)/sqrt(2)) - tanh((x - 36)/sqrt(2)) - 1"))
    profile = made.fields["composition"][-1, 0]
    # Half a phase is 12 wide: exp(-12 sqrt(2)) = 4e-8 of the wall is left there, and the longest wave has decayed.
    assert [profile[0], profile[128]] == pytest.approx(binodals(2.0 * kind - zeta), abs=1e-5)


def test_a_wall_of_cahn_and_hilliard_has_its_width_and_waves_grow_at_their_rate(run):
    made = run("cahn-hilliard", "coefficients.kappa=2", *line(256, 64.0, 300.0),
               *start(composition="tanh(x - 16) - tanh(x - 48) - 1"))
    x = np.arange(256) * 0.25
    wall = np.tanh((x - 16.0) / 2.0) - np.tanh((x - 48.0) / 2.0) - 1.0
    assert made.fields["composition"][-1, 0] == pytest.approx(wall, abs=1e-4)
    for length in (16.0, 2.0 * PI * np.sqrt(2.0), 7.0):
        q = 2.0 * PI / length
        made = run("cahn-hilliard", *line(16, length, 5.0), "initial.kind=mode", "initial.field=composition",
                   "initial.amplitude=1e-8")
        assert made.growth_rate("composition") == pytest.approx(q**2 - q**4, abs=1e-10)


def test_a_wavy_wall_of_model_h_relaxes_by_its_tension_against_the_viscosity(run):
    # Stokes flow by a normal force per length f at y = 0: v_y = f (1 + q|y|) exp(-q|y|)/(4 eta q); f = -tension q^2 h
    # on each wall, all walls of the periodic cell displaced alike, half a cell apart.
    side, height, tension = 64.0, 0.5, np.sqrt(8.0 / 9.0)
    q = 2.0 * PI / side
    apart = q * side / 2.0 * np.arange(1, 20)
    rate = tension * q / 4.0 * (1.0 + 2.0 * np.sum((1.0 + apart) * np.exp(-apart)))
    wall = f"tanh((y - {{}} - {height} cos(2 pi x/lx))/sqrt(2))"
    made = run("model-h", "coefficients.M=0.1", "grid.nx=32", f"grid.lx={side}", "grid.ny=128", f"grid.ly={side}",
               "time.end=20", "output.frame_every=10", *start(composition=f"{wall.format(16)} - {wall.format(48)} - 1"))
    sizes = [np.abs(np.fft.fft(frame, axis=1)[:, 1]).sum() for frame in made.fields["composition"]]
    # Walls are wide: (1.4 q)^2 = 2 %; and they have relaxed by a third.
    assert np.log(sizes[1] / sizes[2]) / 10.0 == pytest.approx(rate, rel=0.03)


def test_fluctuations_of_model_b_have_the_structure_factor_of_ornstein_and_zernike(run):
    made = run("model-b", "coefficients.u=0", "coefficients.r=1", *line(32, 16.0, 20000.0), "time.dt=1",
               "initial.kind=uniform")
    measured = made.observables["structure_factor_composition"][100:].mean(axis=0)
    ratio = measured * (1.0 + made.wavenumbers**2) / 0.1
    # The longest wave, at rate 0.18, has 20000 * 0.18 = 3600 independent samples: 1.7 %; the others have more.
    assert ratio == pytest.approx(1.0, abs=0.08)
    assert ratio.mean() == pytest.approx(1.0, abs=0.02)


# --- patterns, waves and interfaces

@pytest.mark.parametrize("direction, sign", [("x", 1.0), ("y", -1.0)])
def test_an_active_nematic_bends_above_its_threshold_and_does_not_splay(run, direction, sign):
    length, coupling = 16.0, 1.0 + 0.7 / 2.0 * sign
    grid = line(32, length, 4.0) if direction == "x" else [
        "grid.nx=8", "grid.lx=4", "grid.ny=32", f"grid.ly={length}", "time.end=4", "output.frame_every=0"]
    square = (2.0 * PI / length)**2
    threshold = (0.2 + square) / 1.35
    for zeta in (2.0, 1.05 * threshold, 0.95 * threshold):
        made = run("active-nematic", f"coefficients.zeta={zeta}", "time.stepper=etdrk4", *grid,
                   *start(nematic_order_xx="1", nematic_order_xy=f"1e-7 cos(2 pi {direction}/{length})"))
        rate = sign * coupling * zeta * square / (0.2 + square) - square
        assert made.growth_rate("nematic_order") == pytest.approx(rate, rel=1e-4)  # a step of 0.05 of fourth order
        assert (rate > 0.0) == (direction == "x" and zeta > threshold)


def test_stripes_of_swift_and_hohenberg_have_their_amplitude_and_third_harmonic(run):
    made = run("swift-hohenberg", *line(64, 8.0 * PI, 300.0), *start(pattern="0.3 cos(x)"))
    modes = 2.0 * np.fft.rfft(made.fields["pattern"][-1, 0]).real / 64.0
    # The third harmonic -A^3/256 raises the amplitude by A^2/512 = 2.6e-4.
    assert modes[4] == pytest.approx(np.sqrt(4.0 * 0.1 / 3.0), rel=3e-4)
    assert modes[12] == pytest.approx(-modes[4]**3 / 256.0, rel=0.01)  # of order A^2/43


def test_a_plane_wave_of_ginzburg_and_landau_has_its_frequency(run):
    q, b, c = 2.0 * PI / 20.0, 2.0, -0.3
    made = run("ginzburg-landau", f"coefficients.c={c}", *line(64, 40.0, 10.0), "time.stepper=etdrk4",
               *start(amplitude_re=f"sqrt(1 - {q!r}^2) cos({q!r} x)", amplitude_im=f"sqrt(1 - {q!r}^2) sin({q!r} x)"))
    x = np.arange(64) * 40.0 / 64.0
    wave = np.sqrt(1.0 - q**2) * np.exp(1j * (q * x - (c + (b - c) * q**2) * 10.0))
    last = made.fields["amplitude_re"][-1, 0] + 1j * made.fields["amplitude_im"][-1, 0]
    assert last == pytest.approx(wave, abs=1e-5)  # a step of 0.05 of fourth order


@pytest.mark.parametrize("c, unstable", [(-1.0, True), (-0.3, False)])
def test_uniform_oscillations_are_unstable_beyond_the_line_of_benjamin_feir_and_newell(run, c, unstable):
    b, k = 2.0, 2.0 * PI / 20.0
    made = run("ginzburg-landau", f"coefficients.c={c}", *line(32, 20.0, 20.0), "time.stepper=etdrk4",
               *start(amplitude_re="1 + 1e-7 cos(pi x/10)", amplitude_im="0"))
    # The oscillation turns the wave from one part to the other; the sum of the variances grows.
    made.observables["variance_A"] = sum(made.observables[f"variance_amplitude_{end}"] for end in ("re", "im"))
    rate = np.sqrt(1.0 - 2.0 * b * c * k**2 - b**2 * k**4) - 1.0 - k**2
    assert made.growth_rate("A") == pytest.approx(rate, rel=1e-3)
    assert (rate > 0.0) == (1.0 + b * c < 0.0) == unstable


def test_a_stationary_interface_of_kardar_parisi_and_zhang_is_a_random_walk_and_grows_at_its_mean_speed(run):
    made = run("kpz", *line(64, 32.0, 10000.0), "time.dt=0.1", "output.sample_every=1")
    late = made.times > 200.0
    ratio = made.observables["structure_factor_height"][late].mean(axis=0) * 2.0 * made.wavenumbers**2
    # The longest wave decays at 0.04 or faster: 400 independent samples; the mean over the shells has thousands.
    assert ratio == pytest.approx(1.0, abs=0.25)
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)
    # <lambda/2 |grad h|^2> of 42 modes of variance D/(2 nu q^2 area): 0.5 % of scatter.
    speed = np.polyfit(made.times[late], made.observables["mean_height"][late], 1)[0]
    assert speed == pytest.approx(0.5 * 42 / 2.0 / 32.0, rel=0.03)


def test_a_shock_of_burgers_is_that_of_cole_and_hopf(run):
    made = run("burgers")
    x = np.arange(512) * 2.0 * PI / 512
    n = np.arange(1, 60)[:, None]
    for frame in (10, 20, 40):
        time = made.frame_times[frame]
        modes = 2.0 * ive(n, 1.0 / (2.0 * 0.05)) * np.exp(-0.05 * n**2 * time)
        theta = ive(0, 10.0) + (modes * np.cos(n * x)).sum(axis=0)
        exact = 2.0 * 0.05 * (n * modes * np.sin(n * x)).sum(axis=0) / theta
        assert made.fields["velocity"][frame, 0] == pytest.approx(exact, abs=1e-7)  # a step of 0.005 of fourth order


def test_cells_of_keller_and_segel_gather_above_their_threshold(run):
    for length in (8.0, 16.0):
        square = (2.0 * PI / length)**2
        threshold = (square + 1.0) / 0.75
        for chi in (3.0, 1.01 * threshold, 0.99 * threshold):
            made = run("keller-segel", f"coefficients.chi={chi}", *line(16, length, 10.0), "initial.kind=mode",
                       "initial.field=cells", "initial.amplitude=1e-9")
            rate = 0.75 * chi * square / (square + 1.0) - square
            assert made.growth_rate("cells") == pytest.approx(rate, abs=1e-7)  # products of the waves
            assert (rate > 0.0) == (chi > threshold)


def test_a_brusselator_has_turings_threshold_and_wavenumber(run):
    b_c, q_c = (1.0 + 3.0 * np.sqrt(5.0 / 12.0))**2, np.sqrt(3.0 / np.sqrt(60.0))

    def rate(b, q):
        made = run("brusselator", f"coefficients.b={b!r}", *line(16, 2.0 * PI / q, 10.0), "initial.kind=mode",
                   "initial.field=activator", "initial.amplitude=1e-9")
        jacobian = [[b - 1.0 - 5.0 * q**2, 9.0], [-b, -9.0 - 12.0 * q**2]]
        assert made.growth_rate("activator") == pytest.approx(largest_rate(jacobian), abs=1e-6)  # products of the waves
        return made.growth_rate("activator")
    assert rate(1.01 * b_c, q_c) > 0.0 > rate(0.99 * b_c, q_c)
    assert abs(rate(b_c, q_c)) < 1e-6 and rate(b_c, 0.8 * q_c) < -1e-3 and rate(b_c, 1.2 * q_c) < -1e-3
