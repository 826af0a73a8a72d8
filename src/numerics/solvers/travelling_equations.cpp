// numerics/solvers/travelling_equations.cpp: residual, derivative and preconditioner of the equations of a travelling
// state.
#include "numerics/solvers/travelling_equations.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace drover::numerics {

using travelling::Numbers;
using travelling::product;
using travelling::Values;

namespace {
constexpr double pi = std::numbers::pi;
}  // namespace

TravellingEquations::TravellingEquations(TravellingFamily the_family, Threads& the_threads)
    : family(std::move(the_family)), threads(the_threads) {
    set_parameter(family.parameter);
    grid = whole->system.grid;
    require(grid.ny == 1, {}, "a travelling state on {} rows of points; expected grid.ny = 1", grid.ny);
    modes.emplace(grid, whole->system.layout, whole->system.degree);
    const int count = components(whole->system.layout);
    per_component = modes->size() / static_cast<std::size_t>(count);
    scratch = Spectra(grid, count);
    rate = scratch;
}

/// The size of a field is its root mean square or, where larger, that of its change over 1/shift.
void TravellingEquations::set_sizes(Values a) {
    std::vector<double> squares = modes->mean_squares(a);
    Numbers changes(size());
    evaluate(a, changes);
    for (double& change : changes) change /= shift;
    const std::vector<double> of_changes = modes->mean_squares(changes);
    const double largest = *std::max_element(squares.begin(), squares.end());
    sizes.assign(size(), 0.0);
    for (std::size_t f = 0; f < squares.size(); ++f) {
        squares[f] = std::max(squares[f], std::min(of_changes[f], largest));
        const ModeVector::Field& field = modes->fields()[f];
        std::fill(sizes.begin() + static_cast<std::ptrdiff_t>(field.begin),
                  sizes.begin() + static_cast<std::ptrdiff_t>(field.end),
                  std::sqrt(std::max(squares[f], 1e-6 * largest)));
    }
}

void TravellingEquations::set_parameter(double value) {
    if (whole && parameter == value) return;
    whole.emplace(WholeRate(family.system(value)));
    parameter = value;
}

/// f = L a + N(a) at the present parameter.
void TravellingEquations::evaluate(Values a, std::span<double> f) {
    modes->unpack(a, scratch);
    whole->write(0.0, scratch, rate);
    modes->pack(rate, f);
    ++evaluations;
}

/// d_x a.
Numbers TravellingEquations::slope(Values a) const {
    Numbers result(size(), 0.0);
    for (std::size_t begin = 0; begin < size(); begin += per_component)
        for (std::size_t k = 1; 2 * k < per_component; ++k) {
            const double q = 2.0 * pi / grid.lx * static_cast<double>(k);
            result[begin + 2 * k - 1] = -q * a[begin + 2 * k];
            result[begin + 2 * k] = q * a[begin + 2 * k - 1];
        }
    return result;
}

/// A mean density is conserved if its rate is zero for the guess and for another state.
void TravellingEquations::find_conserved(Values a) {
    Numbers other(a.begin(), a.end()), f(size()), g(size());
    for (std::size_t i = 0; i < other.size(); ++i)
        if (i % per_component < 5) other[i] += 0.01 * sizes[i] * std::sin(1.7 * static_cast<double>(i));
    evaluate(a, f);
    evaluate(other, g);
    conserved.clear();
    masses.clear();
    for (const int c : scalar_components(whole->system.layout)) {
        const std::size_t mean = static_cast<std::size_t>(c) * per_component;
        constexpr double rounding = 1e-13;
        if (std::max(std::abs(f[mean]), std::abs(g[mean])) > rounding * shift * sizes[mean]) continue;
        conserved.push_back(mean);
        masses.push_back(a[mean] - family.mean(parameter, c));
    }
}

/// The mean of a conserved density; it follows what the family prescribes.
double TravellingEquations::mass(std::size_t i) const {
    return masses[i] + family.mean(parameter, static_cast<int>(conserved[i] / per_component));
}

/// Above every growth rate of the linear terms: the preconditioner is regular.
void TravellingEquations::choose_shift() {
    double growth = 0.0, slowest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; 2 * k < per_component + 1; ++k) {
        const IsotropicBlocks blocks = whole->system.linear(2.0 * pi / grid.lx * static_cast<double>(k));
        for (const Block* block : {&blocks.even, &blocks.odd})
            for (const Complex s : eigenvalues(*block)) {
                growth = std::max(growth, s.real());
                if (k == 0 && std::abs(s) > 1e-9) slowest = std::min(slowest, std::abs(s));
            }
    }
    shift = 2.0 * growth + (std::isfinite(slowest) ? slowest : 1.0);
}

/// f of the modes: their rates in the frame that moves; of conserved means: their distance from the masses.
void TravellingEquations::fill_equations(Values a, double speed, std::span<double> f) {
    evaluate(a, f.first(size()));
    const Numbers along = slope(a);
    for (std::size_t i = 0; i < size(); ++i) f[i] += speed * along[i];
    for (std::size_t i = 0; i < conserved.size(); ++i) f[conserved[i]] = shift * (a[conserved[i]] - mass(i));
}

/// Of the modes alone, by central differences.
void TravellingEquations::derive(Values a, double speed, Values v, std::span<double> result) {
    double squares = 0.0;
    for (std::size_t i = 0; i < size(); ++i) squares += v[i] * v[i] / (sizes[i] * sizes[i]);
    if (squares == 0.0) {
        std::fill_n(result.begin(), size(), 0.0);
        return;
    }
    const double step = 6e-6 / std::sqrt(squares);  // of the cube root of rounding
    Numbers moved(size()), below(size());
    for (std::size_t i = 0; i < size(); ++i) moved[i] = a[i] - step * v[i];
    evaluate(moved, below);
    for (std::size_t i = 0; i < size(); ++i) moved[i] = a[i] + step * v[i];
    evaluate(moved, result.first(size()));
    const Numbers along = slope(v.first(size()));
    for (std::size_t i = 0; i < size(); ++i) result[i] = (result[i] - below[i]) / (2.0 * step) + speed * along[i];
    for (const std::size_t mean : conserved) result[mean] = shift * v[mean];
}

namespace {
/// The blocks of L at q along x, in the Cartesian components of the fields: see IsotropicBlocks.
SmallSquare<Complex> cartesian_block(const System& system, double q) {
    const IsotropicBlocks blocks = system.linear(q);
    const BlockParts parts = block_parts(system.layout);
    const int count = components(system.layout);
    SmallSquare<Complex> m = SmallSquare<Complex>::Zero(count, count);
    const auto factor = [&](const Part& part) {
        static constexpr Complex powers_of_i[] = {{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}};
        return q > 0.0 ? powers_of_i[part.spin % 4] : 1.0;
    };
    const auto fill = [&](const Block& block, const std::vector<Part>& of) {
        for (std::size_t i = 0; i < of.size(); ++i)
            for (std::size_t k = 0; k < of.size(); ++k)
                m(of[i].component, of[k].component) =
                    std::conj(factor(of[i])) * block(static_cast<int>(i), static_cast<int>(k)) * factor(of[k]);
    };
    fill(blocks.even, parts.even);
    fill(blocks.odd, parts.odd);
    return m;
}
}  // namespace

void TravellingEquations::prepare(Values a, double speed) {
    const std::size_t kept = (per_component + 1) / 2;
    inverses.clear();
    for (std::size_t k = 0; k < kept; ++k) {
        const double q = 2.0 * pi / grid.lx * static_cast<double>(k);
        Matrix m = cartesian_block(whole->system, q);
        m.diagonal().array() += Complex(-shift, speed * q);
        if (k == 0)
            for (const std::size_t mean : conserved) {
                const auto row = static_cast<Eigen::Index>(mean / per_component);
                m.row(row).setZero();
                m(row, row) = shift;
            }
        inverses.push_back(inverse(Eigen::MatrixXcd(m)));
    }
    columns.front() = slope(a);
    for (const std::size_t mean : conserved) columns.front()[mean] = 0.0;
    if (columns.size() > 1) columns[1] = parameter_column(a);
    const auto extra = static_cast<Eigen::Index>(columns.size());
    preconditioned_columns = columns;
    schur = RealMatrix::Zero(extra, extra);
    for (Numbers& column : preconditioned_columns) solve_blocks(column);
    for (Eigen::Index i = 0; i < extra; ++i)
        for (Eigen::Index k = 0; k < extra; ++k) {
            const Numbers& row = rows[static_cast<std::size_t>(i)];
            schur(i, k) = row[size() + static_cast<std::size_t>(k)] -
                          product(Values(row).first(size()), preconditioned_columns[static_cast<std::size_t>(k)]);
        }
}

void TravellingEquations::solve_blocks(std::span<double> v) const {
    const auto count = static_cast<Eigen::Index>(size() / per_component);
    Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, max_small_rows, 1> x(count);
    for (std::size_t k = 0; k < inverses.size(); ++k) {
        const std::size_t at = k == 0 ? 0 : 2 * k - 1;
        for (Eigen::Index c = 0; c < count; ++c) {
            const double* number = v.data() + static_cast<std::size_t>(c) * per_component + at;
            x(c) = Complex(number[0], k == 0 ? 0.0 : number[1]);
        }
        x = (inverses[k] * x).eval();
        for (Eigen::Index c = 0; c < count; ++c) {
            double* number = v.data() + static_cast<std::size_t>(c) * per_component + at;
            number[0] = x(c).real();
            if (k > 0) number[1] = x(c).imag();
        }
    }
}

/// The bordered system, by its Schur complement.
void TravellingEquations::precondition(std::span<double> v) const {
    const std::span<double> a = v.first(size()), extra = v.subspan(size());
    solve_blocks(a);
    using RealVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_small_rows, 1>;
    RealVector right(static_cast<Eigen::Index>(extra.size()));
    for (std::size_t i = 0; i < extra.size(); ++i)
        right(static_cast<Eigen::Index>(i)) = extra[i] - product(Values(rows[i]).first(size()), a);
    const RealVector found = RealMatrix(inverse(Eigen::MatrixXd(schur))) * right;
    for (std::size_t k = 0; k < extra.size(); ++k) {
        extra[k] = found(static_cast<Eigen::Index>(k));
        for (std::size_t i = 0; i < size(); ++i) a[i] -= extra[k] * preconditioned_columns[k][i];
    }
}

/// d f/d parameter.
Numbers TravellingEquations::parameter_column(Values a) {
    const double at = parameter, step = 1e-5 * std::max(std::abs(at), 0.01);
    Numbers above(size()), below(size());
    set_parameter(at + step);
    fill_equations(a, 0.0, above);
    set_parameter(at - step);
    fill_equations(a, 0.0, below);
    set_parameter(at);
    for (std::size_t i = 0; i < size(); ++i) above[i] = (above[i] - below[i]) / (2.0 * step);
    return above;
}

/// Unknowns: the modes, the speed and, with two columns, the parameter.
NonlinearEquations TravellingEquations::equations() {
    const std::size_t n = size();
    const bool has_parameter = columns.size() > 1;
    const auto set = [this, n, has_parameter](Values u) {
        if (has_parameter) set_parameter(u[n + 1]);
    };
    NonlinearEquations e;
    e.residual = [=, this](Values u, std::span<double> f) {
        set(u);
        fill_equations(u.first(n), u[n], f);
        for (std::size_t i = 0; i < rows.size(); ++i) f[n + i] = product(rows[i], u) - offsets[i];
    };
    e.derivative = [=, this](Values u, Values v, std::span<double> result) {
        set(u);
        derive(u.first(n), u[n], v, result);
        for (std::size_t k = 0; k < columns.size(); ++k)
            for (std::size_t i = 0; i < n; ++i) result[i] += v[n + k] * columns[k][i];
        for (std::size_t i = 0; i < rows.size(); ++i) result[n + i] = product(rows[i], v);
    };
    e.prepare = [=, this](Values u) {
        set(u);
        prepare(u.first(n), u[n]);
    };
    e.precondition = [this](std::span<double> v) { precondition(v); };
    return e;
}

/// Of the modes: the sums of the sizes of their linear terms.
void TravellingEquations::set_equation_sizes(double speed, NonlinearEquations& e) const {
    const std::size_t n = size(), count = n / per_component;
    e.unknown_sizes = sizes;
    e.equation_sizes.assign(n, 0.0);
    for (std::size_t number = 0; number < per_component; ++number) {
        const double q = 2.0 * pi / grid.lx * static_cast<double>((number + 1) / 2);
        const Matrix m = cartesian_block(whole->system, q);
        for (std::size_t c = 0; c < count; ++c) {
            double& sum = e.equation_sizes[c * per_component + number];
            sum = (shift + std::abs(speed) * q) * sizes[c * per_component + number];
            for (std::size_t k = 0; k < count; ++k)
                sum += std::abs(m(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(k))) *
                       sizes[k * per_component + number];
        }
    }
    e.unknown_sizes.push_back(std::max(std::abs(speed), smallest_speed()));
    if (columns.size() > 1) e.unknown_sizes.push_back(std::max(std::abs(parameter), 0.01));
    e.equation_sizes.resize(n + rows.size(), 1.0);
}

/// Weights of a scalar product in which each field counts by its relative mean square.
Numbers TravellingEquations::metric() const {
    Numbers weights(size());
    const auto fields = static_cast<double>(modes->fields().size());
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = modes->weight(i) / (sizes[i] * sizes[i] * fields);
    return weights;
}

/// The size of d_x a.
double TravellingEquations::variation(Values a) const {
    const Numbers along = slope(a.first(size())), weights = metric();
    double squares = 0.0;
    for (std::size_t i = 0; i < along.size(); ++i) squares += weights[i] * along[i] * along[i];
    return std::sqrt(squares);
}

double TravellingEquations::smallest_speed() const { return 0.1 * shift * grid.lx / (2.0 * pi); }

/// The first row: a - (this a) is perpendicular to the slope.
void TravellingEquations::fix_position(Values a) {
    Numbers row = slope(a);
    const Numbers weights = metric();
    double squares = 0.0;
    for (std::size_t i = 0; i < row.size(); ++i) squares += weights[i] * row[i] * row[i];
    const double q = 2.0 * pi / grid.lx;
    require(
        squares > 1e-12 * q * q, {},
        "the guess of the state does not depend on x; expected a wave: give initial.kind = \"formula\" with one, or "
        "an archive that holds one");
    for (std::size_t i = 0; i < row.size(); ++i) row[i] *= weights[i] / std::sqrt(squares);
    row.resize(size() + columns.size(), 0.0);
    offsets.front() = product(Values(row).first(size()), a);
    rows.front() = std::move(row);
}

TravellingState TravellingEquations::solve(Numbers u) {
    const std::size_t n = size();
    NonlinearEquations e = equations();
    set_equation_sizes(u[n], e);
    const NewtonOutcome outcome = solve_newton_krylov(e, {}, u);
    if (!outcome.converged)
        fail_run(
            "no travelling state was found: after {} iterations of Newton's method the equations hold to {:.2g} of "
            "their "
            "terms, expected 1e-10; give a guess nearer to the state (initial.kind = \"formula\" or \"file\", "
            "--speed), "
            "a longer cell or more points",
            outcome.iterations, outcome.residual);
    TravellingState found{.state = Spectra(grid, scratch.count()),
                          .speed = u[n],
                          .parameter = parameter,
                          .speed_error = (1e-13 + 100.0 * outcome.residual) * smallest_speed(),
                          .residual = outcome.residual,
                          .iterations = outcome.iterations};
    modes->unpack(Values(u).first(n), found.state);
    return found;
}

TravellingState TravellingEquations::solve_near(const Numbers& near, const Numbers* direction, Values weights) {
    const std::size_t n = size(), extra = direction ? 2 : 1;
    columns.assign(extra, Numbers(n));
    rows.assign(extra, {});
    offsets.assign(extra, 0.0);
    set_parameter(near[n + 1]);
    fix_position(Values(near).first(n));
    if (!direction) return solve(Numbers(near.begin(), near.end() - 1));
    rows[1] = *direction;
    for (std::size_t i = 0; i < rows[1].size(); ++i) rows[1][i] *= weights[i];
    offsets[1] = product(rows[1], near);
    return solve(near);
}

}  // namespace drover::numerics
