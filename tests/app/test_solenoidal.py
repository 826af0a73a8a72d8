"""tests/app/test_solenoidal.py: divergence-free fields, and products in balances that are solved wave by wave."""
import numpy as np
import pytest
from support import drover as program

import drover
from drover import Error, Field, Model, Noise

SIDE, POINTS = 2 * np.pi, 32
NAVIER_STOKES = Field("v", "-v.grad v + nu lap v", spin=1, solenoidal=True)


def grid():
    at = np.arange(POINTS) * SIDE / POINTS
    return np.meshgrid(at, at)


def wavevectors():
    k = np.fft.fftfreq(POINTS, 1 / POINTS)
    return np.meshgrid(k, k)


def stream(seed=1, waves=4):
    """A random smooth function, as a sum of waves: its velocity perp grad psi and vorticity are exact on the grid."""
    draw, (x, y) = np.random.default_rng(seed), grid()
    psi, vx, vy, vorticity = (np.zeros_like(x) for _ in range(4))
    for _ in range(waves):
        kx, ky = draw.integers(-3, 4, 2)
        size, phase = draw.normal(), draw.uniform(0, SIDE)
        psi += size * np.cos(kx * x + ky * y + phase)
        slope = -size * np.sin(kx * x + ky * y + phase)
        vx, vy = vx - ky * slope, vy + kx * slope  # perp grad psi = (-d_y psi, d_x psi)
        vorticity -= (kx**2 + ky**2) * size * np.cos(kx * x + ky * y + phase)
    return psi, vx, vy, vorticity


def derivative(field, axis):
    return np.fft.ifft2(1j * wavevectors()[axis] * np.fft.fft2(field)).real


def test_the_vortices_of_taylor_and_green_decay_as_in_their_solution():
    # v = (cos x sin y, -sin x cos y) exp(-2 nu t) solves the equations of Navier and Stokes: v.grad v is a gradient.
    x, y = grid()
    exact = np.cos(x) * np.sin(y), -np.sin(x) * np.cos(y)
    run = Model([NAVIER_STOKES], nu=0.3).start(POINTS, SIDE, dt=0.5).set(v_x=exact[0], v_y=exact[1]).advance(3.0)
    for found, start in zip((run.fields.v_x, run.fields.v_y), exact, strict=True):
        assert np.abs(found.values - start * np.exp(-2 * 0.3 * 3.0)).max() < 1e-14  # rounding: the step is exact


def test_velocity_and_vorticity_give_the_same_flow():
    # The curl of v.grad v is v.grad curl v without divergence: two sets of equations, one flow.
    _, vx, vy, vorticity = stream()
    one = Model([NAVIER_STOKES], nu=0.02)
    other = Model([Field("w", "-v.grad w + nu lap w", odd=True, conserved=True),
                   Field("psi", "lap psi - w", odd=True, balance=True)],
                  define={"v": "perp grad psi"}, nu=0.02)
    a = one.start(POINTS, SIDE, dt=0.02).set(v_x=vx, v_y=vy).advance(1.0).fields
    b = other.start(POINTS, SIDE, dt=0.02).set(w=vorticity).advance(1.0).fields
    curl = derivative(a.v_y.values, 0) - derivative(a.v_x.values, 1)
    assert np.abs(curl - vorticity).max() > 0.5, "the flow has changed"
    assert np.abs(curl - b.w.values).max() < 1e-11 * np.abs(vorticity).max()  # rounding of 50 steps
    divergence = derivative(a.v_x.values, 0) + derivative(a.v_y.values, 1)
    assert np.abs(divergence).max() < 1e-13 * np.abs(vorticity).max()


def test_a_nematic_swirls_alike_with_a_stream_function_and_with_a_velocity_without_divergence():
    common = dict(coefficients={"lambda": 0.7}, K=0.3, Gamma=0.2, eta=1.0, zeta=2.0)
    q = "-v.grad Q + {} perp Q + lambda sym(grad v) + (1 - Q:Q / 2) Q + K lap Q"
    with_v = Model([Field("Q", q.format("curl v"), spin=2),
                    Field("v", "-Gamma v + eta lap v - zeta div Q", spin=1, balance=True, solenoidal=True)], **common)
    with_psi = Model([Field("Q", q.format("lap psi"), spin=2),
                      Field("psi", "-Gamma lap psi + eta lap lap psi - curl div (zeta Q)", odd=True, balance=True)],
                     define={"v": "perp grad psi"}, **common)
    wave = stream(3)[0]
    ends = [model.start(POINTS, SIDE, dt=0.02).set(Q_xx=1 + 0.1 * wave, Q_xy=0.1 * wave).advance(2.0).fields
            for model in (with_v, with_psi)]
    assert np.abs(ends[0].Q_xy.values).max() > 0.1
    assert np.abs(ends[0].Q_xy - ends[1].Q_xy).max() < 1e-11  # rounding, in a state of size 1 that swirls
    aligned = [model.state(Q=(0.8, 0.3)) for model in (with_v, with_psi)]
    rates = [model.growth_rates([0.4, 2.0], angle=0.6, state=state).growth_rate.values
             for model, state in zip((with_v, with_psi), aligned, strict=True)]
    assert rates[0] == pytest.approx(rates[1], rel=1e-11, abs=1e-12)


MODEL_H = ([Field("phi", "-div(phi v) + M lap mu", conserved=True),
            Field("v", "-Gamma v + eta lap v - phi grad mu + g phi^2 e_y", spin=1, balance=True, solenoidal=True)],
           dict(define={"mu": "phi^3 - phi - lap phi"}, M=0.1, Gamma=0.3, eta=0.5, g=0.2))


def test_a_mixture_with_flow_follows_an_independent_solution():
    # Products of up to four fields without aliases on four times the points, and the fourth-order method of Runge.
    fields, numbers = MODEL_H
    model, start = Model(fields, **numbers), 0.2 * stream(5)[0]
    fine, kept = 4 * POINTS, POINTS // 5  # modes with |k| < N/(4 + 1)
    k = np.fft.fftfreq(POINTS, 1 / POINTS)
    is_kept = (np.abs(k)[:, None] <= kept) & (np.abs(k)[None, :] <= kept)
    kx, ky = wavevectors()
    q2 = np.where(kx**2 + ky**2 == 0, 1, kx**2 + ky**2)
    places = np.ix_(np.arange(-POINTS // 2, POINTS // 2), np.arange(-POINTS // 2, POINTS // 2))
    order = np.argsort(np.fft.fftfreq(POINTS))

    def at_points(modes):
        padded = np.zeros((fine, fine), complex)
        padded[places] = modes[np.ix_(order, order)]
        return np.fft.ifft2(padded).real * (fine / POINTS) ** 2

    def modes_of(values):
        modes = np.empty((POINTS, POINTS), complex)
        modes[np.ix_(order, order)] = np.fft.fft2(values)[places] * (POINTS / fine) ** 2
        return modes * is_kept

    def rate(phi):
        value, mu = at_points(phi), modes_of(at_points(phi) ** 3) + (q2 * (kx**2 + ky**2 > 0) - 1) * phi
        whole = at_points(phi) ** 3 - value + at_points((kx**2 + ky**2) * phi)
        slopes = [3 * value**2 * at_points(1j * c * phi) - at_points(1j * c * phi)
                  + at_points(1j * c * (kx**2 + ky**2) * phi) for c in (kx, ky)]
        assert np.isfinite(whole).all()
        fx, fy = (modes_of(-value * slope) for slope in slopes)
        fy = fy + numbers["g"] * modes_of(value**2)
        along = (kx * fx + ky * fy) / q2
        drag = numbers["Gamma"] + numbers["eta"] * (kx**2 + ky**2)
        vx, vy = (fx - kx * along) / drag, (fy - ky * along) / drag
        flux = [modes_of(value * at_points(v)) for v in (vx, vy)]
        return -1j * kx * flux[0] - 1j * ky * flux[1] - numbers["M"] * (kx**2 + ky**2) * mu

    phi, dt = np.fft.fft2(start) * is_kept, 1e-3
    for _ in range(100):
        a = rate(phi)
        b = rate(phi + dt / 2 * a)
        c = rate(phi + dt / 2 * b)
        phi = phi + dt / 6 * (a + 2 * b + 2 * c + rate(phi + dt * c))
    run = model.start(POINTS, SIDE, dt=1e-3).set(phi=start).advance(0.1)
    expected = np.fft.ifft2(phi).real
    assert np.abs(expected - start).max() > 0.01
    assert np.abs(run.fields.phi.values - expected).max() < 5e-11  # two methods of fourth order at steps of 1e-3


def test_products_in_a_balance_act_in_uniform_states_and_in_theory():
    # A drag with a viscosity, and a force that is cubic: v = (alpha + beta p.p) p / Gamma without waves.
    model = Model([Field("p", "a p - p.p p + lambda v + lap p", spin=1),
                   Field("v", "-Gamma v + eta lap v + (alpha + beta p.p) p", spin=1, balance=True)],
                  coefficients={"lambda": 0.5}, a=0.4, Gamma=2.0, eta=1.5, alpha=0.8, beta=0.3)
    square = (0.4 + 0.5 * 0.8 / 2) / (1 - 0.5 * 0.3 / 2)  # a + lambda alpha/Gamma = (1 - lambda beta/Gamma) p^2
    ordered = model.state(p=(square**0.5, 0.0))
    assert np.abs(model.rates(ordered)).max() < 1e-15
    q = 0.7
    found = np.sort(model.growth_rates([q], angle=0.0, state=ordered).growth_rate.values.ravel())
    along = 0.4 - 3 * square - q**2 + 0.5 * (0.8 + 3 * 0.3 * square) / (2.0 + 1.5 * q**2)
    across = 0.4 - square - q**2 + 0.5 * (0.8 + 0.3 * square) / (2.0 + 1.5 * q**2)
    assert found == pytest.approx(sorted((along, across)), rel=1e-13)
    run = model.start(16, 8.0, dt=0.1).set(p_x=square**0.5).advance(20.0)
    assert np.abs(run.fields.p_x - square**0.5).max() < 1e-13, "the ordered state stays"
    wave = 1e-6 * np.cos(2 * np.pi * np.arange(16) / 16)
    run = model.start(16, 2 * np.pi / q, dt=0.01).set(p_x=square**0.5 + wave).advance(1.0)
    decay = np.fft.fft(run.fields.p_x.values[0])[1] / np.fft.fft(wave)[1]
    assert decay.real == pytest.approx(np.exp(along), rel=1e-5)  # a wave of 1e-6: its square


def test_thermal_noise_has_its_structure_factor_across_the_wave_alone():
    # nu q^2 with the noise D q^2: D/(2 nu) across q, and nothing along it; the mean does not move.
    model = Model([Field("v", "-v.grad v + nu lap v", spin=1, solenoidal=True, noise="D", conserved_noise=True)],
                  nu=0.5, D=0.02)
    found = model.structure_factors([1.0, 3.0])
    assert found.values.real[:, 0, 0] == pytest.approx(0.0, abs=1e-17)
    assert found.values.real[:, 1, 1] == pytest.approx(0.02, rel=1e-13)
    run = model.start(POINTS, SIDE, dt=0.2, seed=4)
    samples = [run.advance(1.0).fields for _ in range(60)]
    for one in samples[::20]:
        assert np.abs(derivative(one.v_x.values, 0) + derivative(one.v_y.values, 1)).max() < 1e-13
    kx, ky = wavevectors()
    kept = (np.abs(kx) <= 10) & (np.abs(ky) <= 10) & (kx**2 + ky**2 > 0)  # below N/3
    powers = [(np.abs(np.fft.fft2(one.v_x.values)) ** 2 + np.abs(np.fft.fft2(one.v_y.values)) ** 2)[kept].mean()
              for one in samples[10:]]
    found = np.mean(powers) / POINTS**4 * SIDE**2
    # 50 samples of 220 pairs of modes that forget each other within a unit of time or so, the slowest in two: 1 % each.
    assert found == pytest.approx(0.02, rel=0.03)
    noisy = Model([Field("v", "nu lap v + div(s)", spin=1, solenoidal=True)], noises=[Noise("S", spin=2)],
                  define={"s": "D S"}, nu=0.5, D=0.2)
    # A random stress: div S has the strength D^2 q^2/2 ... of each component, half of it across.
    matrix = noisy.structure_factors([2.0]).values.real[0]
    assert matrix[0, 0] == pytest.approx(0.0, abs=1e-17) and matrix[1, 1] > 0.0


def test_long_waves_of_a_flow_diffuse_with_its_viscosity():
    model = Model([Field("v", "nu lap v - v.grad v", spin=1, solenoidal=True)], nu=0.3)
    assert model.growth_rates([0.5, 2.0]).growth_rate.values.ravel() == pytest.approx([-0.075, -1.2], rel=1e-13)
    moving = model.state(v=(0.6, 0.8))
    found = model.growth_rates([0.5], angle=0.3, state=moving)
    assert found.growth_rate.values.ravel() == pytest.approx([-0.075], rel=1e-12)
    carried = 0.5 * (0.6 * np.cos(0.3) + 0.8 * np.sin(0.3))
    assert abs(found.frequency.values.ravel()[0]) == pytest.approx(carried, rel=1e-12)


def test_waves_of_a_flow_are_asked_for_with_uniform_changes_among_them():
    found = Model([NAVIER_STOKES], nu=0.3).growth_rates([0.0, 2.0]).growth_rate.values
    assert found[0].tolist() == [0.0, 0.0] and found[1, 0] == pytest.approx(-1.2) and np.isnan(found[1, 1])


def test_a_weight_drives_a_flow_that_has_a_pressure():
    # Stokes flow: of n = cos(k x), a weight n e_y gives v_y = n/(eta k^2); of cos(k y) the pressure carries it.
    x, y = grid()
    model = Model([Field("n", "-v.grad n", conserved=True),
                   Field("v", "eta lap v + n e_y", spin=1, balance=True, solenoidal=True)], eta=0.5)
    for start, flow in ((np.cos(2 * x), np.cos(2 * x) / (0.5 * 4)), (np.cos(2 * y), 0 * y)):
        n = start + 0.01 * np.sin(y)
        run = model.start(POINTS, SIDE, dt=1e-4).set(n=n).advance(1e-4)
        rate = (run.fields.n.values - n) / 1e-4  # -v_y d_y n to the first order
        assert np.abs(rate + flow * 0.01 * np.cos(y)).max() < 1e-6


@pytest.mark.parametrize("force", ["phi^2 e_y", "sin(x)^2 e_y", "phi e_y", "phi e_y - e_y"])
def test_a_flow_without_drag_takes_no_force_that_has_a_mean(force):
    fields = [Field("phi", "lap phi"), Field("v", f"lap v + {force}", spin=1, balance=True, solenoidal=True)]
    with pytest.raises(Error, match="mean|does not determine it at wavenumber 0"):
        Model(fields)
    Model([fields[0], Field("v", f"-v + lap v + {force}", spin=1, balance=True, solenoidal=True)])


@pytest.mark.parametrize("field, says", [
    (Field("s", "lap s", solenoidal=True), "expected a vector"),
    (Field("v", "lap v", spin=1, solenoidal=True, mass="1 + v.v"), "its mass is not constant"),
    (Field("v", "-v - v.v v + p", spin=1, solenoidal=True, balance=True), "solenoidal"),
    (Field("v", "-v.v v + lap v + p", spin=1, balance=True), "derivatives"),
])
def test_what_a_pressure_or_a_balance_cannot_do_is_said(field, says):
    with pytest.raises(Error, match=says):
        Model([Field("p", "-p", spin=1), field]).growth_rates([1.0])


SCENE = """
field = [{symbol = "v", name = "velocity", rank = "vector", solenoidal = true}]
equations = {v = "-v.grad v + nu lap v - drag v + A sin(2 pi y / 16) e_x"}
coefficients = {nu = 0.1, drag = 0.05, A = 0.1}
grid = {nx = 32, ny = 32, lx = 16.0, ly = 16.0}
time = {dt = 0.1, end = 2.0}
initial = {kind = "formula", velocity_x = "0.1 cos(2 pi x / lx)", velocity_y = "0.1 cos(2 pi x / lx)"}
output = {frame_every = 1.0, sample_every = 0.5}
"""


def test_a_scene_without_divergence_runs_and_says_what_it_leaves_out_of_a_start(tmp_path):
    file = tmp_path / "kolmogorov.toml"
    file.write_text(SCENE)
    said = program(tmp_path, "run", file)
    assert "0.5 of the variance of its start has a divergence" in said.stderr + said.stdout
    # One wave across its own vector and one along it, of equal size; one of them is along x, the other along y.
    other = program(tmp_path, "run", file, "-o", "other.h5", "--set", "initial.velocity_x=",
                    "--set", "initial.velocity_y=\"0.1 cos(2 pi y / ly) + 0.1 sin(2 pi x / lx)\"")
    assert "0.5 of the variance of its start has a divergence" in other.stderr + other.stdout
    with drover.open_run(tmp_path / "kolmogorov.h5") as run:
        frame = run.frames.isel(time=0)
        assert np.abs(frame.velocity_x.values).max() < 1e-16 and frame.velocity_y.values.max() > 0.09
    assert r"- \nabla P" in drover.Scene.load(file).model.latex
    says = program(tmp_path, "states", file, "--wave", "x", "--set", "equations.v=\"nu lap v\"", status=2).stderr
    assert "v is solenoidal" in says
