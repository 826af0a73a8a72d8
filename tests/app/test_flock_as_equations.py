"""tests/app/test_flock_as_equations.py: the equations of rods and beads written in a scene, beside those built in."""
import h5py
import numpy as np
from support import MODELS, drover, drover_json, settings

FIELDS = ("bead_density", "rod_density", "bead_velocity_x", "bead_velocity_y", "polar_order_x", "polar_order_y")
# The built-in mass of thin beads has a lower bound of Gamma dt/m = .08, a tenth of the density: its 16th power is
# below rounding.
SHORT = settings(["grid.nx=32", "grid.ny=32", "time.dt=0.005", "time.end=1.0", "output.frame_every=1.0",
                  "output.sample_every=0.1", "analysis.warm_up=0", "initial.amplitude=0.05", "run.threads=1"])


def run(name, folder, *noise):
    drover(folder, "run", MODELS / f"{name}.toml", "--quiet", "--overwrite", "--output", folder / f"{name}.h5", *SHORT,
           *settings(noise))
    return h5py.File(folder / f"{name}.h5")


def assert_equal(built_in, written, tolerance):
    for name in FIELDS:
        expected, found = built_in[name][:], written[name][:]
        assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max(), name
        assert expected[-1].std() > 1e-4 * np.abs(expected).max(), name  # the fields are not uniform


def test_the_flock_as_equations_is_the_flock(tmp_path):
    # Rounding errors of 200 steps, each some 1e-16 of the values and of the stiff forces.
    built_in, written = (run(name, tmp_path, noise) for name, noise in
                         (("flock", "noise.order=0"), ("flock-as-equations", "field[4].noise=0")))
    assert_equal(built_in, written, 1e-12)


def test_the_quasi_linear_approximation_is_that_of_any_model(tmp_path):
    (tmp_path / "full").mkdir()
    full = run("flock-as-equations", tmp_path / "full", "field[4].noise=0")
    above = "approximation.quasi_linear_above"
    built_in, written = (run(name, tmp_path, noise, "approximation.quasi_linear=true", f"{above}=0.2")
                         for name, noise in (("flock", "noise.order=0"), ("flock-as-equations", "field[4].noise=0")))
    assert_equal(built_in, written, 1e-12)
    assert np.abs(written["rod_density"][-1] - full["rod_density"][-1]).max() > 1e-6 * full["rod_density"][:].max()
    with run("flock-as-equations", tmp_path, "field[4].noise=0", "approximation.quasi_linear=true",
             f"{above}=100.0") as all_long:
        assert all(np.array_equal(all_long[name][:], full[name][:]) for name in FIELDS)


def test_the_flock_as_equations_has_the_noise_of_the_flock(tmp_path):
    built_in, written = run("flock", tmp_path), run("flock-as-equations", tmp_path)
    # Noise of the order reaches the velocity as the cube of a step: the covariance of a step is nearly singular, and
    # its square root has half of the digits.
    assert_equal(built_in, written, 1e-8)
    # The same observables, of which most have one name.
    common = set(built_in["observables"]) & set(written["observables"]) - {"step_error"}
    assert {"mean_bead_velocity_x", "size_mean_polar_order", "correlation_rod_density", "max_bead_density"} <= common
    for name in common:
        expected, found = built_in[f"observables/{name}"][:], written[f"observables/{name}"][:]
        # Variances and tails of short waves are squares of small differences.
        assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max(), name
    # And an observable by two names.
    expected = built_in["observables/structure_factor_order_across"][:]
    found = written["observables/structure_factor_polar_order_across"][:]
    assert np.abs(found - expected).max() <= 1e-8 * expected.max()
    # And its prediction about the direction that the order had, which the noise turned.  The means of the samples agree
    # to 1e-8; the direction is that of the mean velocity, a small one.
    for one, other in (("structure_factor_rods", "structure_factor_rod_density"),
                       ("structure_factor_velocity_along", "structure_factor_bead_velocity_along"),
                       ("rod_number_deviation_long_x", "rod_density_number_deviation_long_x")):
        expected, found = built_in[f"summary/{one}_linear"][:], written[f"summary/{other}_linear"][:]
        assert np.isfinite(expected).all() and expected.max() > 0.0
        assert np.abs(found - expected).max() <= 1e-6 * expected.max(), one


def test_both_have_the_same_uniform_states_and_waves(tmp_path):
    built_in, written = (drover_json(tmp_path, "stability", MODELS / f"{name}.toml")
                         for name in ("flock", "flock-as-equations"))
    assert [state["name"] for state in written["states"]] == ["isotropic", "ordered"]
    flock = written["states"][1]
    assert abs(flock["polar_order_x"] - built_in["states"][1]["order"][0]) <= 1e-12
    assert abs(flock["bead_velocity_x"] - built_in["states"][1]["velocity"][0]) <= 1e-12

    def waves(result):  # of the flock; rates to ten digits, since damping comes from differences of large terms
        modes = [(mode["angle"], mode["speed"], mode["damping"]) for mode in result["states"][1]["slow_modes"]]
        return np.array(sorted(modes))

    assert np.allclose(waves(written), waves(built_in), rtol=1e-9, atol=1e-9)

    def kinds(result):  # the places of maxima to the square root of rounding
        return [(found["name"], found["rate"], found["wavenumber"]) for state in result["states"]
                for found in state["instabilities"]]

    assert [kind[0] for kind in kinds(written)] == [kind[0] for kind in kinds(built_in)] == ["order"]
    assert np.allclose([kind[1:] for kind in kinds(written)], [kind[1:] for kind in kinds(built_in)], rtol=1e-6)
    for result in (built_in, written):  # the shares of all terms add up to the rate of the fastest wave
        for state in result["states"]:
            total = sum(share["growth"] for share in state["shares"])
            # It is the difference of terms of some 40 /s.
            assert abs(total - state["fastest_rate"]) <= 1e-12 * sum(abs(share["growth"]) for share in state["shares"])
    diffusions = [result["states"][1]["direction_diffusion_times_area"] for result in (built_in, written)]
    assert diffusions[0] > 0.0 and abs(diffusions[1] / diffusions[0] - 1.0) < 1e-10


MORE = """
model = {name = "a flock with more", file = "flock-as-equations.toml"}
field = [
  {symbol = "c", name = "nutrient", reference = "1"},
  {symbol = "w", name = "vorticity", parity = "odd"},
  {symbol = "j", name = "current", rank = "vector"},
  {symbol = "Q", name = "texture", rank = "nematic"},
]
grid = {nx = 16, ny = 16, lx = 16.0, ly = 16.0}
time = {dt = 0.05, end = 2.0}
initial = {kind = "formula", polar_order_x = "0.7", bead_velocity_x = "0.7", amplitude = 0.001}
output = {frame_every = 1.0, sample_every = 0.1}
[equations]
c = "lap c - 0.1 c sigma"
w = "-w + lap w + curl p"
j = "-j + lap j + 0.1 p"
Q = "-Q + lap Q + 0.1 sym(outer(p, p))"
"""


def test_the_flock_takes_a_field_of_every_rank_beside_its_own(tmp_path):
    """The fields of the installed flock stay as they are: none of the new ones acts on them."""
    (tmp_path / "more.toml").write_text(MORE)
    (tmp_path / "plain.toml").write_text(MORE[:MORE.index("field = [")] + MORE[MORE.index("grid ="):MORE.index("[equ")])
    for name in ("more", "plain"):
        drover(tmp_path, "run", f"{name}.toml", "--quiet", "--set", "field[4].noise=0")
    with h5py.File(tmp_path / "more.h5") as more, h5py.File(tmp_path / "plain.h5") as plain:
        for name in FIELDS:
            assert np.abs(more[name][:] - plain[name][:]).max() <= 1e-12 * np.abs(plain[name][:]).max(), name
        assert np.abs(more["texture_xx"][-1]).max() > 0.01 and np.abs(more["vorticity"][-1]).max() > 0.0
        # d_t j = -j + 0.1 p: the mean of p is close to its value in the flock.
        expected = 0.1 * (1.0 - np.exp(-2.0)) * more["polar_order_x"][:].mean()
        assert abs(more["current_x"][-1].mean() - expected) < 0.02 * expected
    drover(tmp_path, "check", "more.toml")
    assert len(drover_json(tmp_path, "stability", "more.toml")["states"]) >= 2
