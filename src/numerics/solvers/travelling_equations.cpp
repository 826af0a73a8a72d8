// numerics/solvers/travelling_equations.cpp: residual, derivative and preconditioner of the equations of a travelling
// state, and their solution by Newton's method and GMRES (KINSOL of SUNDIALS).
#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <numbers>
#include <numeric>

#include "base/constants.hpp"
#include "numerics/solvers/travelling_state.hpp"
#include "numerics/steppers/sundials_handles.hpp"

namespace drover::numerics {

namespace {
constexpr double pi = std::numbers::pi;
double product(std::span<const double> a, std::span<const double> b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// The blocks of L at q along x, in the Cartesian components of the fields: see IsotropicBlocks.
Eigen::MatrixXcd cartesian_block(const System& system, double q) {
    const IsotropicBlocks blocks = system.linear(q);
    const BlockParts parts = block_parts(system.layout);
    const int count = components(system.layout);
    Eigen::MatrixXcd m = Eigen::MatrixXcd::Zero(count, count);
    const auto factor = [&](const Part& part) { return power_of_i(q > 0.0 ? part.spin : 0); };
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

TravellingSolver::TravellingSolver(TravellingFamily family) : family_(std::move(family)) {
    set_parameter(family_.parameter);
    grid_ = whole_->system.grid;
    require(grid_.ny == 1, {}, "a travelling state on {} rows of points; expected grid.ny = 1", grid_.ny);
    modes_.emplace(grid_, whole_->system.layout, whole_->system.degree);
    const int count = components(whole_->system.layout);
    per_component_ = modes_->size() / static_cast<std::size_t>(count);
    scratch_ = Spectra(grid_, count);
    rate_ = scratch_;
}

void TravellingSolver::set_parameter(double value) {
    if (whole_ && parameter_ == value) return;
    whole_.emplace(WholeRate(family_.system(value)));
    parameter_ = value;
}

/// f = L a + N(a) at the present parameter.
void TravellingSolver::evaluate(Values a, std::span<double> f) {
    modes_->unpack(a, scratch_);
    whole_->write(0.0, scratch_, rate_);
    modes_->pack(rate_, f);
    ++evaluations_;
}

/// d_x a.
TravellingSolver::Numbers TravellingSolver::slope(Values a) const {
    Numbers result(size(), 0.0);
    for (std::size_t begin = 0; begin < size(); begin += per_component_)
        for (std::size_t k = 1; 2 * k < per_component_; ++k) {
            const double q = 2.0 * pi / grid_.lx * static_cast<double>(k);
            result[begin + 2 * k - 1] = -q * a[begin + 2 * k];
            result[begin + 2 * k] = q * a[begin + 2 * k - 1];
        }
    return result;
}

/// A mean density is conserved if its rate is zero for the guess and for another state.
void TravellingSolver::find_conserved(Values a) {
    Numbers other(a.begin(), a.end()), f(size()), g(size());
    for (std::size_t i = 0; i < other.size(); ++i)
        if (i % per_component_ < 5) other[i] += 0.01 * sizes_[i] * std::sin(1.7 * static_cast<double>(i));
    evaluate(a, f);
    evaluate(other, g);
    conserved_.clear();
    masses_.clear();
    for (const int c : scalar_components(whole_->system.layout)) {
        const std::size_t mean = static_cast<std::size_t>(c) * per_component_;
        constexpr double rounding = 1e-13;
        if (std::max(std::abs(f[mean]), std::abs(g[mean])) > rounding * shift_ * sizes_[mean]) continue;
        conserved_.push_back(mean);
        masses_.push_back(a[mean] - family_.mean(parameter_, c));
    }
}

/// The mean of a conserved density; it follows what the family prescribes.
double TravellingSolver::mass(std::size_t i) const {
    return masses_[i] + family_.mean(parameter_, static_cast<int>(conserved_[i] / per_component_));
}

/// Above every growth rate of the linear terms: the preconditioner is regular.  By the slowest rate of the means or,
/// where none has a rate, of the longest wave that has one.
void TravellingSolver::choose_shift() {
    double growth = 0.0, slowest = infinite;
    for (std::size_t k = 0; 2 * k < per_component_ + 1; ++k) {
        const IsotropicBlocks blocks = whole_->system.linear(2.0 * pi / grid_.lx * static_cast<double>(k));
        std::vector<double> sizes;
        for (const Block* block : {&blocks.even, &blocks.odd})
            for (const Complex s : eigenvalues(*block)) {
                growth = std::max(growth, s.real());
                sizes.push_back(std::abs(s));
            }
        constexpr double rounding = 1e-12;  // of a conserved mean, beside the fastest
        const double smallest = rounding * *std::ranges::max_element(sizes);
        if (std::isfinite(slowest)) continue;
        for (const double size : sizes)
            if (size > smallest) slowest = std::min(slowest, size);
    }
    shift_ = 2.0 * growth + (std::isfinite(slowest) ? slowest : 1.0);
}

/// f of the modes: their rates in the frame that moves; of conserved means: their distance from the masses.
void TravellingSolver::fill_equations(Values a, double speed, std::span<double> f) {
    evaluate(a, f.first(size()));
    const Numbers along = slope(a);
    for (std::size_t i = 0; i < size(); ++i) f[i] += speed * along[i];
    for (std::size_t i = 0; i < conserved_.size(); ++i) f[conserved_[i]] = shift_ * (a[conserved_[i]] - mass(i));
}

/// Of the modes alone, by central differences.
void TravellingSolver::derive(Values a, double speed, Values v, std::span<double> result) {
    double squares = 0.0;
    for (std::size_t i = 0; i < size(); ++i) squares += v[i] * v[i] / (sizes_[i] * sizes_[i]);
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
    for (const std::size_t mean : conserved_) result[mean] = shift_ * v[mean];
}

/// (L - shift + speed d_x)^-1 of each mode; of conserved means 1/shift.
void TravellingSolver::invert_blocks(double speed) {
    const std::size_t kept = (per_component_ + 1) / 2;
    inverses_.clear();
    for (std::size_t k = 0; k < kept; ++k) {
        const double q = 2.0 * pi / grid_.lx * static_cast<double>(k);
        Eigen::MatrixXcd m = cartesian_block(whole_->system, q);
        m.diagonal().array() += Complex(-shift_, speed * q);
        if (k == 0)
            for (const std::size_t mean : conserved_) {
                const auto row = static_cast<Eigen::Index>(mean / per_component_);
                m.row(row).setZero();
                m(row, row) = shift_;
            }
        inverses_.push_back(inverse(m));
    }
}

/// The size of a field is its root mean square or, where larger, that of its change in an implicit step of 1/shift:
/// each in the unit of the field.
void TravellingSolver::set_sizes(Values a) {
    Numbers changes(size());
    evaluate(a, changes);
    invert_blocks(0.0);
    solve_blocks(changes);
    std::vector<double> squares = modes_->mean_squares(a);
    const std::vector<double> of_changes = modes_->mean_squares(changes);
    for (std::size_t f = 0; f < squares.size(); ++f) squares[f] = std::max(squares[f], of_changes[f]);
    const double largest = *std::ranges::max_element(squares);
    sizes_.assign(size(), 0.0);
    for (std::size_t f = 0; f < squares.size(); ++f) {
        constexpr double rounding = 1e-20, of_none = 1e-6;  // of squares: what is left of a field that is 0; any size
        const double square = squares[f] > rounding * largest ? squares[f] : of_none * largest;
        const ModeVector::Field& field = modes_->fields()[f];
        std::fill(sizes_.begin() + static_cast<std::ptrdiff_t>(field.begin),
                  sizes_.begin() + static_cast<std::ptrdiff_t>(field.end), std::sqrt(square));
    }
}

void TravellingSolver::prepare(Values a, double speed) {
    invert_blocks(speed);
    columns_.front() = slope(a);
    for (const std::size_t mean : conserved_) columns_.front()[mean] = 0.0;
    if (columns_.size() > 1) columns_[1] = parameter_column(a);
    const auto extra = static_cast<Eigen::Index>(columns_.size());
    preconditioned_columns_ = columns_;
    schur_ = Eigen::MatrixXd::Zero(extra, extra);
    for (Numbers& column : preconditioned_columns_) solve_blocks(column);
    for (Eigen::Index i = 0; i < extra; ++i)
        for (Eigen::Index k = 0; k < extra; ++k) {
            const Numbers& row = rows_[static_cast<std::size_t>(i)];
            schur_(i, k) = row[size() + static_cast<std::size_t>(k)] -
                           product(Values(row).first(size()), preconditioned_columns_[static_cast<std::size_t>(k)]);
        }
}

void TravellingSolver::solve_blocks(std::span<double> v) const {
    const auto count = static_cast<Eigen::Index>(size() / per_component_);
    Eigen::VectorXcd x(count), solved(count);
    for (std::size_t k = 0; k < inverses_.size(); ++k) {
        const std::size_t at = k == 0 ? 0 : 2 * k - 1;
        for (Eigen::Index c = 0; c < count; ++c) {
            const double* number = v.data() + static_cast<std::size_t>(c) * per_component_ + at;
            x(c) = Complex(number[0], k == 0 ? 0.0 : number[1]);
        }
        solved.noalias() = inverses_[k] * x;
        for (Eigen::Index c = 0; c < count; ++c) {
            double* number = v.data() + static_cast<std::size_t>(c) * per_component_ + at;
            number[0] = solved(c).real();
            if (k > 0) number[1] = solved(c).imag();
        }
    }
}

/// The bordered system, by its Schur complement.
void TravellingSolver::precondition(std::span<double> v) const {
    const std::span<double> a = v.first(size()), extra = v.subspan(size());
    solve_blocks(a);
    Eigen::VectorXd right(static_cast<Eigen::Index>(extra.size()));
    for (std::size_t i = 0; i < extra.size(); ++i)
        right(static_cast<Eigen::Index>(i)) = extra[i] - product(Values(rows_[i]).first(size()), a);
    const Eigen::VectorXd found = inverse(schur_) * right;
    for (std::size_t k = 0; k < extra.size(); ++k) {
        extra[k] = found(static_cast<Eigen::Index>(k));
        for (std::size_t i = 0; i < size(); ++i) a[i] -= extra[k] * preconditioned_columns_[k][i];
    }
}

/// d f/d parameter.
TravellingSolver::Numbers TravellingSolver::parameter_column(Values a) {
    const double at = parameter_, step = 1e-5 * parameter_size();
    Numbers above(size()), below(size());
    set_parameter(at + step);
    fill_equations(a, 0.0, above);
    set_parameter(at - step);
    fill_equations(a, 0.0, below);
    set_parameter(at);
    for (std::size_t i = 0; i < size(); ++i) above[i] = (above[i] - below[i]) / (2.0 * step);
    return above;
}

/// Typical sizes of the terms of each equation: of the modes, the sums of the sizes of their linear terms.
TravellingSolver::Numbers TravellingSolver::equation_sizes(double speed) const {
    const std::size_t n = size(), count = n / per_component_;
    Numbers result(n);
    for (std::size_t number = 0; number < per_component_; ++number) {
        const double q = 2.0 * pi / grid_.lx * static_cast<double>((number + 1) / 2);
        const Eigen::MatrixXcd m = cartesian_block(whole_->system, q);
        for (std::size_t c = 0; c < count; ++c) {
            double& sum = result[c * per_component_ + number];
            sum = (shift_ + std::abs(speed) * q) * sizes_[c * per_component_ + number];
            for (std::size_t k = 0; k < count; ++k)
                sum += std::abs(m(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(k))) *
                       sizes_[k * per_component_ + number];
        }
    }
    result.resize(n + rows_.size(), 1.0);
    return result;
}

/// Weights of a scalar product in which each field counts by its relative mean square.
TravellingSolver::Numbers TravellingSolver::metric() const {
    Numbers weights(size());
    const auto fields = static_cast<double>(modes_->fields().size());
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = modes_->weight(i) / (sizes_[i] * sizes_[i] * fields);
    return weights;
}

/// The size of d_x a.
double TravellingSolver::variation(Values a) const {
    const Numbers along = slope(a.first(size())), weights = metric();
    double squares = 0.0;
    for (std::size_t i = 0; i < along.size(); ++i) squares += weights[i] * along[i] * along[i];
    return std::sqrt(squares);
}

double TravellingSolver::smallest_speed() const { return 0.1 * shift_ * grid_.lx / (2.0 * pi); }

/// The first row: a - (this a) is perpendicular to the slope.
void TravellingSolver::fix_position(Values a) {
    Numbers row = slope(a);
    const Numbers weights = metric();
    double squares = 0.0;
    for (std::size_t i = 0; i < row.size(); ++i) squares += weights[i] * row[i] * row[i];
    const double q = 2.0 * pi / grid_.lx;
    require(
        squares > 1e-12 * q * q, {},
        "the guess of the state does not depend on x; expected a wave: give initial.kind = \"formula\" with one, or "
        "an archive that holds one");
    for (std::size_t i = 0; i < row.size(); ++i) row[i] *= weights[i] / std::sqrt(squares);
    row.resize(size() + columns_.size(), 0.0);
    offsets_.front() = product(Values(row).first(size()), a);
    rows_.front() = std::move(row);
}

/// KINSOL's view of the equations.  Unknowns: the modes, the speed and, with two columns, the parameter.
struct TravellingSolver::Newton {
    static constexpr double tolerance = 1e-13;  ///< aimed at: the largest |f|, relative to the size of its equation
    static constexpr double accepted = 1e-10;   ///< still accepted where rounding ends the iteration earlier

    TravellingSolver& solver;
    std::size_t n;
    Numbers equation_sizes;
    bool has_begun = false;
    std::exception_ptr failure = nullptr;
    std::string message = {};

    void residual_at(Values u, std::span<double> f) {
        set_parameter(u);
        solver.fill_equations(u.first(n), u[n], f);
        for (std::size_t i = 0; i < solver.rows_.size(); ++i)
            f[n + i] = product(solver.rows_[i], u) - solver.offsets_[i];
    }
    void set_parameter(Values u) {
        if (solver.columns_.size() > 1) solver.set_parameter(u[n + 1]);
    }

    /// Outside the domain of the equations the residual counts as huge, so that the line search comes back.
    static int residual(N_Vector u, N_Vector f, void* call) {
        auto& c = *static_cast<Newton*>(call);
        const int flag = guarded(c.failure, [&] {
            c.residual_at(numbers(u), numbers(f));
            for (const double value : numbers(f))
                if (!std::isfinite(value))
                    fail_run("the residual of Newton's method is not finite; expected finite fields");
        });
        if (flag == 1 && c.has_begun) {
            constexpr double far = 1e10;
            std::transform(c.equation_sizes.begin(), c.equation_sizes.end(), numbers(f).begin(),
                           [](double size) { return far * size; });
            return 0;
        }
        c.has_begun = true;
        return flag;
    }

    static int derivative(N_Vector v_vector, N_Vector product_vector, N_Vector u_vector, int*, void* call) {
        auto& c = *static_cast<Newton*>(call);
        return guarded(c.failure, [&] {
            const Values u = numbers(u_vector), v = numbers(v_vector);
            const std::span<double> result = numbers(product_vector);
            c.set_parameter(u);
            c.solver.derive(u.first(c.n), u[c.n], v, result);
            for (std::size_t k = 0; k < c.solver.columns_.size(); ++k)
                for (std::size_t i = 0; i < c.n; ++i) result[i] += v[c.n + k] * c.solver.columns_[k][i];
            for (std::size_t i = 0; i < c.solver.rows_.size(); ++i) result[c.n + i] = product(c.solver.rows_[i], v);
        });
    }

    static int prepare(N_Vector u_vector, N_Vector, N_Vector, N_Vector, void* call) {
        auto& c = *static_cast<Newton*>(call);
        return guarded(c.failure, [&] {
            const Values u = numbers(u_vector);
            c.set_parameter(u);
            c.solver.prepare(u.first(c.n), u[c.n]);
        });
    }

    static int precondition(N_Vector, N_Vector, N_Vector, N_Vector, N_Vector v, void* call) {
        auto& c = *static_cast<Newton*>(call);
        return guarded(c.failure, [&] { c.solver.precondition(numbers(v)); });
    }

    static void keep_message(int, const char*, const char*, char* words, void* call) {
        static_cast<Newton*>(call)->message = words;
    }

    /// Replaces u, with a line search; returns the number of iterations.
    int iterate(std::span<double> u, Values unknown_sizes);
};

int TravellingSolver::Newton::iterate(std::span<double> u, Values unknown_sizes) {
    SUNContext made = nullptr;
    if (SUNContext_Create(nullptr, &made) != 0) fail_environment("SUNDIALS cannot be started; it is out of memory");
    const Owned<SUNContext, ContextDeleter> context(made);
    const auto vector_of = [&](Values from, bool inverse) {
        Owned<N_Vector, VectorDeleter> vector(N_VNew_Serial(static_cast<sunindextype>(u.size()), context.get()));
        if (!vector) fail_environment("no memory for {} unknowns; expected a smaller grid", u.size());
        std::transform(from.begin(), from.end(), numbers(vector.get()).begin(),
                       [&](double value) { return inverse ? 1.0 / value : value; });
        return vector;
    };
    const auto unknowns = vector_of(u, false), unknown_scale = vector_of(unknown_sizes, true),
               equation_scale = vector_of(equation_sizes, true);
    const auto free = [](void* memory) { KINFree(&memory); };
    const std::unique_ptr<void, decltype(free)> kinsol(KINCreate(context.get()), free);
    constexpr int max_krylov = 400, max_iterations = 100;  // dimensions of GMRES, without restarts
    const Owned<SUNLinearSolver, SolverDeleter> linear(
        SUNLinSol_SPGMR(unknowns.get(), SUN_PREC_RIGHT, std::min<int>(max_krylov, static_cast<int>(u.size())),
                        context.get()));
    void* memory = kinsol.get();
    constexpr double smallest_step = 1e-15, largest_step = 1.0;
    if (!memory || !linear || KINSetErrHandlerFn(memory, keep_message, this) != 0 ||
        KINInit(memory, residual, unknowns.get()) != 0 || KINSetUserData(memory, this) != 0 ||
        KINSetFuncNormTol(memory, tolerance) != 0 || KINSetScaledStepTol(memory, smallest_step) != 0 ||
        KINSetNumMaxIters(memory, max_iterations) != 0 || KINSetMaxSetupCalls(memory, 1) != 0 ||
        KINSetMaxNewtonStep(memory, largest_step) != 0 || KINSetNoResMon(memory, SUNTRUE) != 0 ||
        KINSetLinearSolver(memory, linear.get(), nullptr) != 0 || KINSetJacTimesVecFn(memory, derivative) != 0 ||
        KINSetPreconditioner(memory, prepare, precondition) != 0)
        fail_run("KINSOL cannot be prepared: {}", message);
    const int flag = KINSol(memory, unknowns.get(), KIN_LINESEARCH, unknown_scale.get(), equation_scale.get());
    long iterations = 0;
    KINGetNumNonlinSolvIters(memory, &iterations);
    if (flag < 0 && failure && flag != KIN_LINESEARCH_NONCONV) std::rethrow_exception(failure);
    const Values found = numbers(unknowns.get());
    std::ranges::copy(found, u.begin());
    return static_cast<int>(iterations);
}

TravellingState TravellingSolver::solve(Numbers u) {
    const std::size_t n = size();
    Numbers unknown_sizes = sizes_, f(u.size());
    unknown_sizes.push_back(std::max(std::abs(u[n]), smallest_speed()));
    if (columns_.size() > 1) unknown_sizes.push_back(parameter_size());
    Newton newton{.solver = *this, .n = n, .equation_sizes = equation_sizes(u[n])};
    TravellingState found{.state = Spectra(grid_, scratch_.count())};
    const auto measure_residual = [&] {
        newton.residual_at(u, f);
        found.residual = 0.0;
        for (std::size_t i = 0; i < f.size(); ++i)
            found.residual = std::max(found.residual, std::abs(f[i]) / newton.equation_sizes[i]);
        return found.residual <= Newton::accepted;
    };
    // The sizes of terms are those at the guess of the speed at first, and must be those at the speed that is found.
    constexpr int max_rounds = 4;
    for (int round = 0; round < max_rounds; ++round) {
        found.iterations += newton.iterate(u, unknown_sizes);
        if (!measure_residual()) break;
        newton.equation_sizes = equation_sizes(u[n]);
        if (measure_residual()) break;
        unknown_sizes[n] = std::max(std::abs(u[n]), smallest_speed());
    }
    if (!(found.residual <= Newton::accepted))
        fail_run(
            "no travelling state was found: after {} iterations of Newton's method the equations hold to {:.2g} of "
            "their terms, expected 1e-10; give a guess nearer to the state (initial.kind = \"formula\" or \"file\", "
            "--speed), a longer cell or more points",
            found.iterations, found.residual);
    found.speed = u[n];
    found.parameter = parameter_;
    found.speed_error = (1e-13 + 100.0 * found.residual) * smallest_speed();
    modes_->unpack(Values(u).first(n), found.state);
    return found;
}

TravellingState TravellingSolver::solve_near(const Numbers& near, const Numbers* direction, Values weights) {
    const std::size_t n = size(), extra = direction ? 2 : 1;
    columns_.assign(extra, Numbers(n));
    rows_.assign(extra, {});
    offsets_.assign(extra, 0.0);
    set_parameter(near[n + 1]);
    fix_position(Values(near).first(n));
    if (!direction) return solve(Numbers(near.begin(), near.end() - 1));
    rows_[1] = *direction;
    for (std::size_t i = 0; i < rows_[1].size(); ++i) rows_[1][i] *= weights[i];
    offsets_[1] = product(rows_[1], near);
    return solve(near);
}

}  // namespace drover::numerics
