// model/field_evolution.cpp: N with its checks, and the reference that follows a run.
#include "model/field_evolution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drover/model/linearised_at.hpp"
#include "model/start.hpp"

namespace drover::model {

using numerics::Complex;
using numerics::Spectra;

namespace {
/// Whether the rate of a uniform state is not uniform, or has sources at points.
bool depends_on_place(const Equations& equations) {
    const std::vector<Field>& fields = equations.model().fields;
    return equations.placed_term() != nullptr ||
           std::ranges::any_of(fields, [](const Field& one) { return one.left == LeftSide::given; });
}

/// The kept modes with |q| > long_waves.
std::vector<std::size_t> short_waves(double long_waves, const numerics::System& linear) {
    const numerics::Grid& grid = linear.grid;
    std::vector<std::size_t> result;
    if (std::isinf(long_waves)) return result;
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < numerics::columns(grid); ++i) {
            const numerics::Wavevector q = numerics::wavevector(grid, i, j);
            if (numerics::is_kept(grid, linear.degree, i, j) && std::hypot(q.x, q.y) > long_waves)
                result.push_back(j * numerics::columns(grid) + i);
        }
    return result;
}

/// N, its checks, and the values that the reference follows.
class RightHandSide {
public:
    RightHandSide(const Integrated& what, const std::optional<Followed>& followed, const numerics::System& linear,
                  std::shared_ptr<ExplicitPart> part)
        : part_(std::move(part)),
          followed_(followed ? followed->component : -1),
          watched_(what.watched),
          check_(what.check),
          short_(short_waves(what.long_waves, linear)),
          depends_on_place_(depends_on_place(what.equations)) {
        if (!short_.empty())
            displaced_ = other_ = Spectra(linear.grid, static_cast<int>(what.equations.state_components().size()));
        if (followed && !followed->by_largest) {
            const std::vector<int>& state = what.equations.state_components();
            array_ = static_cast<int>(std::ranges::find(state, followed_) - state.begin());
            const std::vector<Field>& fields = what.equations.model().fields;
            mass_of_ = fields[components_of_state(what.equations)[static_cast<std::size_t>(array_)].field].name;
            moved_ = text("the equation of {}", fields[followed->mass_field].name);
        }
        if (followed_ >= 0) part_->watch(followed_);
        for (const int k : watched_)
            if (k != followed_) part_->watch(k);
    }

    void operator()(double t, const Spectra& state, Spectra& rate) {
        *values_ = {};
        if (short_.empty()) evaluate(t, state, rate);
        else evaluate_quasi_linear(t, state, rate);
    }

    std::shared_ptr<const Range> values() const { return values_; }

private:
    void evaluate(double t, const Spectra& state, Spectra& rate) {
        (*part_)(t, state, rate);
        if (followed_ >= 0) {
            const Range found = part_->range(followed_);
            *values_ = {.min = std::min(values_->min, found.min), .max = std::max(values_->max, found.max)};
        }
        if (!check_) return require_mass();
        ranges_.clear();
        for (const int k : watched_) ranges_.push_back(part_->range(k));
        check_(ranges_);
    }

    /// The state with its short waves times a factor.
    void displace(const Spectra& state, double factor) {
        displaced_ = state;
        for (int c = 0; c < state.count(); ++c)
            for (const std::size_t m : short_) displaced_[c][m] *= factor;
    }

    /// The generalised quasi-linear approximation (Marston, Chini & Tobias, Phys. Rev. Lett. 116, 214501 (2016)) of N:
    /// with long waves l and short waves h,
    ///     long:  N(l) + N''(l) h h/2,     short:  N'(l) h + N(mean).
    /// N(mean) is what acts on short waves from outside.  Exact for products of up to three fields.
    void evaluate_quasi_linear(double t, const Spectra& state, Spectra& rate) {
        const auto of_short = [&](auto body) {
            for (int c = 0; c < state.count(); ++c)
                for (const std::size_t m : short_) body(rate[c][m], other_[c][m]);
        };
        // With D(e) = (N(l + e h) - N(l - e h))/2, N'(l) h = (8 D(1/2) - D(1))/3.
        evaluate(t, state, rate);
        displace(state, -1.0);
        evaluate(t, displaced_, other_);
        std::vector<Complex> slopes;
        of_short([&](Complex plus, Complex minus) { slopes.push_back((minus - plus) / 6.0); });
        for (std::size_t k = 0; k < rate.values.size(); ++k) rate.values[k] = 0.5 * (rate.values[k] + other_.values[k]);
        for (const double half : {0.5, -0.5}) {
            displace(state, half);
            evaluate(t, displaced_, other_);
            std::size_t n = 0;
            of_short([&](Complex, Complex at) { slopes[n++] += std::copysign(4.0 / 3.0, half) * at; });
        }
        std::size_t n = 0;
        of_short([&](Complex& to, Complex) { to = slopes[n++]; });
        if (!depends_on_place_) return;
        std::ranges::fill(displaced_.values, Complex(0.0));
        for (int c = 0; c < state.count(); ++c) displaced_[c][0] = state[c][0];
        evaluate(t, displaced_, other_);
        of_short([&](Complex& to, Complex source) { to += source; });
    }

    void require_mass() const {
        if (mass_of_.empty() || values_->min > 0.0) return;
        throw DomainFailure(
            text("{} reached {:.4g} on the grid, and {} divides by it; expected a value above 0: take a "
                 "finer grid, a smaller time.dt or less noise",
                 mass_of_, values_->min, moved_),
            array_);
    }

    std::shared_ptr<ExplicitPart> part_;
    int followed_;
    std::string mass_of_, moved_;  // the fields of a mass that the reference follows; "": none
    int array_ = -1;               // of the first of them, in a state
    std::vector<int> watched_;
    std::function<void(std::span<const Range>)> check_;
    std::vector<std::size_t> short_;  // the modes of short waves of the quasi-linear approximation
    bool depends_on_place_;
    Spectra displaced_, other_;
    std::vector<Range> ranges_;
    std::shared_ptr<Range> values_ = std::make_shared<Range>();  // of the followed scalar
};

constexpr int max_level = 200;  // a factor of 1e30

UniformState with_factor(UniformState state, int component, double factor) {
    state[static_cast<std::size_t>(component)] *= factor;
    return state;
}

/// What damps each component of a state at |q| about the references, one of them times a factor.
std::vector<double> dampings(const Equations& equations, int component, double factor, double q) {
    const numerics::System system = equations.about(with_factor(equations.reference(), component, factor))
                                        .linear_system({.nx = 8, .ny = 8, .lx = 1.0, .ly = 1.0}, 1);
    const numerics::IsotropicBlocks blocks = system.linear(q);
    const numerics::BlockParts parts = numerics::block_parts(system.layout);
    std::vector<double> result(equations.state_components().size());
    for (const auto& [block, list] : {std::pair{&blocks.even, &parts.even}, std::pair{&blocks.odd, &parts.odd}})
        for (int k = 0; k < block->size; ++k)
            result[static_cast<std::size_t>((*list)[static_cast<std::size_t>(k)].component)] = -(*block)(k, k);
    return result;
}

Split split(const Integrated& what, const numerics::Grid& grid, int degree, Threads& threads,
            const std::optional<Followed>& followed = std::nullopt) {
    Split result;
    result.system = what.equations.system(grid, threads, degree, &result.part);
    if (what.is_quiet) {
        result.system.noise = {};
        result.system.product_noise = {};
    }
    if (!result.part) return result;
    const auto whole = std::make_shared<RightHandSide>(what, followed, result.system, result.part);
    result.followed = whole->values();
    result.system.nonlinear = [whole](double t, const Spectra& state, Spectra& rate) { (*whole)(t, state, rate); };
    return result;
}

double largest_wavenumber(const numerics::Grid& grid) {
    return std::numbers::pi * std::hypot(grid.nx > 1 ? grid.nx / grid.lx : 0.0, grid.ny > 1 ? grid.ny / grid.ly : 0.0);
}
}  // namespace

int followed_level(bool by_largest, double part, int reference_level) {
    if (!std::isfinite(part) || part <= 0.0) return reference_level;
    // Allowed: at most 1.7 times the smallest value or, its mirror image, at least 1/1.7 of the largest.
    const int side = by_largest ? 1 : -1;
    const double limit = side * 2.0 * std::log2(part) - 2.0 * std::log2(1.7);
    int level = side * reference_level;
    if (level < limit) level = static_cast<int>(std::ceil(limit));
    if (level > 0 && level - 1.5 > limit) level = std::max(0, static_cast<int>(std::ceil(limit + 0.5)));
    return std::clamp(side * level, -max_level, max_level);
}

std::optional<Followed> followed_scalar(const Equations& equations, double shortest) {
    constexpr double min_ratio = 1.5;  // of the ratio of masses, or of dampings, where a scalar is doubled
    const UniformState reference = equations.reference();
    const std::vector<StateComponent> components = components_of_state(equations);
    std::optional<Followed> found;
    for (std::size_t c = 0; c < components.size(); ++c) {
        const Field& field = equations.model().fields[components[c].field];
        if (field.spin != 0 || field.odd || !(field.reference > 0.0)) continue;
        const int component = equations.state_components()[c];
        for (std::size_t mass_field = 0; mass_field < equations.model().fields.size(); ++mass_field)
            if (equations.varying_mass(mass_field, reference) >=
                min_ratio * equations.varying_mass(mass_field, with_factor(reference, component, 0.5)))
                return Followed{.component = component, .by_largest = false, .mass_field = mass_field};
        if (found) continue;
        try {
            // What grows is a damping of short waves: a reaction is as fast in long ones.
            const double longer = shortest / 64.0;
            const std::vector<double> once = dampings(equations, component, 1.0, shortest),
                                      twice = dampings(equations, component, 2.0, shortest),
                                      once_longer = dampings(equations, component, 1.0, longer),
                                      twice_longer = dampings(equations, component, 2.0, longer);
            for (std::size_t k = 0; k < once.size(); ++k)
                if (once[k] > 0.0 && twice[k] >= min_ratio * once[k] &&
                    twice[k] - once[k] >= 2.0 * (twice_longer[k] - once_longer[k]))
                    found = {.component = component, .by_largest = true};
        } catch (const Error& error) {  // outside a table, or without slopes
            if (error.fault() != Fault::input) throw;
        }
    }
    return found;
}

numerics::System system_of(const Integrated& what, const numerics::Grid& grid, Threads& threads) {
    return system_of(what, grid, what.kept_degree, threads);
}

numerics::System system_of(const Integrated& what, const numerics::Grid& grid, int degree, Threads& threads) {
    return split(what, grid, degree, threads).system;
}

TransformCount transforms_of(const Integrated& what) {
    const TransformCount count = what.equations.transforms();
    const int times = std::isinf(what.long_waves) ? 1 : depends_on_place(what.equations) ? 5 : 4;
    return {.inverse = count.forward > 0 ? times * count.inverse : 0, .forward = times * count.forward};
}

numerics::StepWork step_work(const Integrated& what, const numerics::Grid& grid) {
    const Equations& equations = what.equations;
    const TransformCount count = transforms_of(what);
    const int components = static_cast<int>(equations.state_components().size());
    int noisy = equations.has_product_noise() ? components : 0;
    if (equations.has_noise() && noisy == 0)
        noisy =
            static_cast<int>((equations.noise(equations.reference(), {1.0, 0.0}).diagonal().array() != 0.0).count());
    return numerics::step_work(
        grid, {.components = components, .noisy = noisy, .inverse = count.inverse, .forward = count.forward});
}

double explicit_bytes(const Integrated& what, const numerics::Grid& grid, int degree) {
    const double displaced =
        std::isinf(what.long_waves) ? 0.0 : 2.0 * static_cast<double>(what.equations.state_components().size());
    return ExplicitPart::bytes(what.equations, grid, degree) +
           displaced * static_cast<double>(numerics::modes(grid)) * sizeof(numerics::Complex);
}

FieldEvolution::FieldEvolution(Integrated what, const numerics::Grid& grid, const numerics::StepControl& control,
                               std::uint64_t seed, Threads& threads)
    : what_(std::move(what)),
      followed_(what_.equations.has_explicit_part() ? followed_scalar(what_.equations, largest_wavenumber(grid))
                                                    : std::nullopt),
      grid_(grid),
      threads_(threads),
      linear_(what_.equations.linear_system(grid, what_.kept_degree)),
      split_(split(what_, grid_, what_.kept_degree, threads_, followed_)),
      stepper_(control, split_.system, seed, threads, control.watches_error ? std::optional(watched()) : std::nullopt) {
}

Integrated FieldEvolution::at_level(int reference_level) const {
    Integrated what = what_;
    if (reference_level != 0)
        what.equations = what.equations.about(
            with_factor(what.equations.reference(), followed_->component, std::exp2(0.5 * reference_level)));
    return what;
}

numerics::ErrorEquations::OnGrid FieldEvolution::equations_on_grid(int reference_level) const {
    return [what = at_level(reference_level)](const numerics::Grid& grid, int degree, Threads& threads) {
        return system_of(what, grid, degree, threads);
    };
}

numerics::ErrorEquations FieldEvolution::watched() const {
    numerics::ErrorEquations result{.fields = {},
                                    .on_grid = equations_on_grid(0),
                                    .degree = linear_.degree,
                                    .noisy = what_.equations.has_noise() && !what_.is_quiet,
                                    .shortest = what_.shortest};
    const std::vector<Field>& fields = what_.equations.model().fields;
    const std::vector<StateComponent> components = components_of_state(what_.equations);
    for (std::size_t c = 0; c < components.size(); ++c) {
        const Field& field = fields[components[c].field];
        if (components[c].part == 0)
            result.fields.push_back({static_cast<int>(c), model::components(field), field.name});
    }
    int spin = 0;  // of the order, the first field that turns
    for (const int component : turning_components(what_.equations.model())) {
        const std::vector<int>& state = what_.equations.state_components();
        const auto c = static_cast<std::size_t>(std::ranges::find(state, component) - state.begin());
        if (c == state.size()) continue;  // in balance
        const int here = fields[components[c].field].spin;
        if (spin == 0) spin = here;
        if (here == spin) result.turning.push_back(static_cast<int>(c));
    }
    return result;
}

void FieldEvolution::set_reference(int reference_level) {
    reference_level_ = reference_level;
    split_ = split(at_level(reference_level), grid_, what_.kept_degree, threads_, followed_);
    split_.system.noise_path =
        2 * static_cast<std::uint64_t>(std::abs(reference_level)) + (reference_level < 0 ? 1 : 0);
    stepper_.set_system(split_.system, equations_on_grid(reference_level));
}

void FieldEvolution::follow(const FieldEvolution& other) {
    stepper_.begin_anew();
    if (reference_level_ != other.reference_level_) set_reference(other.reference_level_);
}

/// Of the last evaluation, the value that the reference follows: the smallest as that of the mass that moves.
double FieldEvolution::part_of_reference() const {
    if (!followed_ || !split_.part) return 0.0;
    const double reference = what_.equations.reference()[static_cast<std::size_t>(followed_->component)];
    if (followed_->by_largest) return split_.followed->max / reference;
    const double part = split_.followed->min / reference, floor = split_.part->mass_floor(followed_->mass_field);
    return part * std::pow(1.0 + std::pow(floor / part, 16.0), 1.0 / 16.0);
}

void FieldEvolution::follow_values(double part) {
    if (!followed_) return;
    const int reference_level = followed_level(followed_->by_largest, part, reference_level_);
    if (reference_level == reference_level_) return;
    set_reference(reference_level);
    ++changes_;
}

void FieldEvolution::start(const Spectra& state) {
    if (!followed_ || !split_.part) return;
    Spectra rate(grid_, state.count());
    split_.system.nonlinear(0.0, state, rate);
    if (split_.system.set_step) split_.system.set_step(stepper().dt());
    follow_values(part_of_reference());
}

void FieldEvolution::advance(std::int64_t step, Spectra& state) {
    stepper_.advance(step, state);
    const double part = part_of_reference();  // of the step, not of what measures its error
    stepper_.watch(step, state);
    follow_values(part);
}

numerics::Fields FieldEvolution::balanced(double t, const Spectra& state) const {
    if (split_.part) return split_.part->balanced(t, state);
    if (!balances_) balances_ = std::make_unique<ExplicitPart>(what_.equations, linear_, threads_);
    return balances_->balanced(t, state);
}

std::vector<double> FieldEvolution::save() const {
    std::vector<double> values = stepper_.save();
    values.insert(values.begin(), static_cast<double>(reference_level_));
    return values;
}

void FieldEvolution::restore(std::span<const double> values) {
    const double reference_level = values.empty() ? NAN : values[0];
    require(reference_level == 0.0 || followed_, {},
            "the checkpoint holds a reference that follows a field, and none is followed here: it is that of another "
            "version or model; run the scene again");
    require(std::abs(reference_level) <= max_level && reference_level == std::round(reference_level), {},
            "the checkpoint contains {}; expected an integer from {} to {}; use the other checkpoint", reference_level,
            -max_level, max_level);
    set_reference(static_cast<int>(reference_level));
    stepper_.restore(values.subspan(1));
}

}  // namespace drover::model
