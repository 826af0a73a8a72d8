// numerics/steppers/stepper.cpp: exponential Runge-Kutta and multistep methods with exact linear part and exact noise.
#include "drover/numerics/stepper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "drover/base/error.hpp"
#include "numerics/steppers/combination.hpp"
#include "numerics/steppers/noise_path.hpp"

namespace drover::numerics {

namespace {
/// One stage for every mode: its plan with the matrices of each |q|.
struct Combination {
    StagePlan plan;
    std::vector<double> matrices;  ///< for each |q|, for each use: the entries of the even block, then of the odd one
    int halvings = 0;              ///< of the step, to the interval whose noise the stage includes
};

using Source = ModePlace<const Complex>;
constexpr std::size_t max_uses = 10;

Block combined(const std::vector<PhiTerm>& terms, const std::map<double, PhiFunctions>& phi, double dt) {
    Block result(phi.begin()->second.front().size);
    const std::span<double> sum = result.values();
    for (const PhiTerm& term : terms) {
        const PhiFunctions& f = phi.at(term.at);
        const std::span<const double> values = f[static_cast<std::size_t>(term.order)].values();
        for (std::size_t k = 0; k < values.size(); ++k) sum[k] += dt * term.weight * values[k];
    }
    return result;
}

template <class Visit>
void for_terms(const StepperTable& table, Visit visit) {
    for (const StepperStage& stage : table.stages)
        for (const auto& terms : stage.terms) std::ranges::for_each(terms, visit);
    for (const auto& terms : table.error) std::ranges::for_each(terms, visit);
}

/// The highest order of phi functions that a table uses, at least that for which they are accurate.
int highest_phi(const StepperTable& table) {
    int highest = 3;
    for_terms(table, [&](const PhiTerm& term) { highest = std::max(highest, term.order); });
    return highest;
}

/// exp and phi functions at every fraction of the step that a table uses.
std::map<double, PhiFunctions> phi_at_fractions(const StepperTable& table, const Block& m, double dt) {
    std::map<double, PhiFunctions> result;
    const int highest = highest_phi(table);
    int halves = 0;  // fractions 1, 1/2, ... share most of their work
    const auto add = [&](double at) {
        int exponent = 0;
        if (std::frexp(at, &exponent) == 0.5 && exponent <= 1) halves = std::max(halves, 2 - exponent);
        else if (!result.contains(at)) result.emplace(at, phi_functions(m, at * dt, highest));
    };
    for (const StepperStage& stage : table.stages) add(stage.c);
    for_terms(table, [&](const PhiTerm& term) { add(term.at); });
    std::vector<PhiFunctions> of_halves = phi_functions_of_halves(m, dt, halves, highest);
    for (int k = 0; k < halves; ++k)
        result.emplace(std::ldexp(1.0, -k), std::move(of_halves[static_cast<std::size_t>(k)]));
    return result;
}

const StepperTable& checked(const StepperTable& table) {
    check(table);
    return table;
}

const System& checked(const System& system) {
    check(system.grid);
    return system;
}

/// The exact propagator alone: sufficient for a linear system.
const StepperTable& linear_table() {
    static const StepperTable table{"linear", 1, "", {{1.0, {}}}};
    return table;
}

}  // namespace

struct Stepper::Work {
    /// The kept modes of one row, or of rows j and -j, which share their matrices.
    struct Rows {
        std::size_t first;     // mode of the first row
        std::size_t kept;      // modes of a row
        std::ptrdiff_t apart;  // from the first row to the second; 0: there is one row
    };
    System system;
    StepperTable table;
    double dt;
    std::shared_ptr<NoisePath> noise;
    int noise_level, product_level;
    Threads& threads;
    DistinctWavenumbers wavenumbers;
    std::vector<Combination> combinations;  // of each stage
    Combination estimate;                   // of the local error; without uses: the table has none
    std::shared_ptr<StepperScratch> arrays;
    std::vector<Spectra>& rates;
    Spectra &stage, &next;
    Spectra product_noise;  // increments

    // Of a multistep method; rates[0] is that of the start of the last step.
    std::unique_ptr<Stepper> starter;
    std::uint64_t following_step = 0;
    std::size_t known_rates = 0;  // of the last step and of those before it
    bool knows_new_rate = false;  // rates[stages] is that of the state after the last step
    bool can_estimate = false;
    std::int64_t right_hand_sides = 0;  // of the last step

    Work(const System& the_system, const StepperTable& the_table, double the_dt, std::shared_ptr<NoisePath> the_noise,
         int halvings, Threads& the_threads, std::shared_ptr<StepperScratch> the_scratch);
    void prepare_stages();
    /// noise_level: of the increments to add; -1: none.
    void combine(const Combination& combination, const Spectra& old, int noise_level, Spectra& out);
    Source source_of(const std::vector<WeightedInput>& inputs, const Spectra& old, const Rows& row,
                     Complex* scratch) const;
    void take_stages(double t, std::uint64_t step_number, const Spectra& state, bool knows_first_rate = false);
    std::size_t first_old_rate() const { return table.stages.size() + 1; }
    void keep_last_rate();
    void step_with_history(double t, std::uint64_t step_number, Spectra& state);
    void start_step(double t, std::uint64_t step_number, Spectra& state);
    void enforce_hermitian(Spectra& state) const;
};

Stepper::Work::Work(const System& the_system, const StepperTable& the_table, double the_dt,
                    std::shared_ptr<NoisePath> the_noise, int halvings, Threads& the_threads,
                    std::shared_ptr<StepperScratch> the_scratch)
    : system(checked(the_system)),
      table(the_system.nonlinear ? checked(the_table) : linear_table()),
      dt(the_dt),
      noise(std::move(the_noise)),
      noise_level(noise ? noise->level() + halvings : -1),
      product_level(system.product_noise ? noise->of_products()->level() + halvings : -1),
      threads(the_threads),
      wavenumbers(distinct_wavenumbers(the_system.grid, the_system.degree)),
      arrays(the_scratch && table.history == 0 ? std::move(the_scratch) : std::make_shared<StepperScratch>()),
      rates(arrays->rates),
      stage(arrays->stage),
      next(arrays->next) {
    require(std::isfinite(dt) && dt > 0.0, {}, "dt = {}; expected a positive time", dt);
    require(table.history == 0 || !noise, {}, "stepper \"{}\" with noise; expected a system without", table.name);
    prepare_stages();
    if (system.product_noise) product_noise = Spectra(system.grid, components(system.product_noise->layout));
    const int count = components(system.layout);
    const std::size_t rate_count = std::max(table.stages.size(), table.error.size());
    if (next.size > 0) {  // shared
        require(!system.nonlinear || rates.size() == rate_count, {},
                "scratch with {} rates; expected {}, those of \"{}\"", rates.size(), rate_count, table.name);
        check(next, system.grid, count);
        return;
    }
    if (system.nonlinear) {
        rates.assign(rate_count, Spectra(system.grid, count));
        stage = Spectra(system.grid, count);
    }
    next = Spectra(system.grid, count);
}

void Stepper::Work::prepare_stages() {
    for (StagePlan& plan : stage_plans(table)) combinations.push_back({.plan = std::move(plan), .matrices = {}});
    estimate.plan = error_plan(table);
    const auto check = [&](const StagePlan& plan) {
        require(plan.uses.size() <= max_uses, {}, "stepper \"{}\": a stage of {} matrices; expected at most {}",
                table.name, plan.uses.size(), max_uses);
    };
    for (const Combination& combination : combinations) check(combination.plan);
    check(estimate.plan);
    for (std::size_t s = 0; s < table.stages.size(); ++s) {
        int exponent = 0;
        const bool is_power_of_two = std::frexp(table.stages[s].c, &exponent) == 0.5;  // exact in any rounding mode
        const int halvings = 1 - exponent;
        require(!noise || is_power_of_two, {},
                "stepper \"{}\": a stage at {} of the step; expected 1, 1/2, 1/4, ... with noise", table.name,
                table.stages[s].c);
        combinations[s].halvings = halvings;
    }
    const std::size_t entries = block_entries(system.layout);
    const auto reserve = [&](Combination& combination) {
        combination.matrices.resize(wavenumbers.q.size() * combination.plan.uses.size() * entries);
    };
    std::ranges::for_each(combinations, reserve);
    reserve(estimate);
    const auto of_wavenumber = [&](std::size_t n) {
        const IsotropicBlocks rate_blocks = linear_blocks(system, wavenumbers.q[n]);
        const auto even = phi_at_fractions(table, rate_blocks.even, dt),
                   odd = phi_at_fractions(table, rate_blocks.odd, dt);
        std::vector<double> made;
        const auto store = [&](double c, Combination& to) {
            made.clear();
            for (const MatrixUse& use : to.plan.uses)
                append_entries(use.terms.empty()
                                   ? IsotropicBlocks{even.at(c).front(), odd.at(c).front()}
                                   : IsotropicBlocks{combined(use.terms, even, dt), combined(use.terms, odd, dt)},
                               made);
            std::ranges::copy(made, to.matrices.begin() + static_cast<std::ptrdiff_t>(n * made.size()));
        };
        for (std::size_t s = 0; s < table.stages.size(); ++s) store(table.stages[s].c, combinations[s]);
        store(1.0, estimate);
    };
    constexpr std::size_t wavenumbers_per_chunk = 64;
    threads.for_chunks(wavenumbers.q.size(), wavenumbers_per_chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) of_wavenumber(n);
    });
}

/// The modes of some rows of every component of a weighted sum, written to `scratch` unless they exist already.
Source Stepper::Work::source_of(const std::vector<WeightedInput>& inputs, const Spectra& old, const Rows& row,
                                Complex* scratch) const {
    const auto of = [&](const WeightedInput& input) -> const Spectra& {
        return input.input == 0 ? old : rates[static_cast<std::size_t>(input.input - 1)];
    };
    if (inputs.size() == 1 && inputs.front().weight == 1.0)
        return {of(inputs.front()).values.data() + row.first, of(inputs.front()).stride, row.apart};
    const std::size_t count = static_cast<std::size_t>(old.count()) * row.kept;
    for (std::size_t k = 0; k < inputs.size(); ++k)
        for (int c = 0; c < old.count(); ++c)
            for (const std::size_t second : {0, 1}) {
                if (second == 1 && row.apart == 0) continue;
                const Complex* from = of(inputs[k])[c].data() + row.first + (second == 0 ? 0 : row.apart);
                Complex* to = scratch + second * count + static_cast<std::size_t>(c) * row.kept;
                if (k == 0)
                    for (std::size_t i = 0; i < row.kept; ++i) to[i] = inputs[k].weight * from[i];
                else
                    for (std::size_t i = 0; i < row.kept; ++i) to[i] += inputs[k].weight * from[i];
            }
    return {scratch, row.kept, static_cast<std::ptrdiff_t>(count)};
}

void Stepper::Work::combine(const Combination& combination, const Spectra& old, int level, Spectra& out) {
    for_layout(system.layout, [&](const auto& kernel) {
        const std::size_t count = kernel.parts;
        const std::size_t width = columns(system.grid), rows = static_cast<std::size_t>(system.grid.ny);
        const std::vector<MatrixUse>& uses = combination.plan.uses;
        const Spectra* begun = combination.plan.from_previous ? &stage : nullptr;
        const std::size_t doubles = uses.size() * kernel.entries;
        // A row of each component at a time: contiguous reads from memory, then work in the first-level cache.
        const auto of_rows = [&]<class Number>(std::size_t row, const Rows& at, std::vector<Complex>& scratch, Number) {
            scratch.resize(uses.size() * 2 * count * at.kept);
            std::array<Source, max_uses> sources;
            for (std::size_t u = 0; u < uses.size(); ++u)
                sources[u] = source_of(uses[u].inputs, old, at, scratch.data() + u * 2 * count * at.kept);
            const std::size_t partner = (rows - row) % rows;
            const double *increments = level < 0 ? nullptr : noise->row(level, row),
                         *of_partner = level < 0 ? nullptr : noise->row(level, partner);
            const std::int32_t* of_mode = wavenumbers.of_mode.data() + at.first;
            const auto matrices_of = [&](std::size_t i) {
                return combination.matrices.data() + static_cast<std::size_t>(of_mode[i]) * doubles;
            };
            for (std::size_t i = 0; i < at.kept; ++i) {
                // Matrices of neighbouring modes are far apart in memory: prefetch the next.
                const double* following = matrices_of(std::min(i + 2, at.kept - 1));
                for (std::size_t k = 0; k < doubles; k += 8) __builtin_prefetch(following + k);
                const double* matrix = matrices_of(i);
                const auto frame = kernel.frame(direction(wavevector(system.grid, i, row),
                                                          wavenumbers.inverse[static_cast<std::size_t>(of_mode[i])]));
                auto sum = zero_parts<Number>(kernel);
                if (increments)
                    sum = load_parts<Number>(kernel, increments + i * 2 * count, of_partner + i * 2 * count);
                for (std::size_t u = 0; u < uses.size(); ++u) {
                    const Source& from = sources[u];
                    matrix =
                        add_blocks(kernel, matrix,
                                   parts_of<Number>(kernel, {from.values + i, from.stride, from.apart}, frame), sum);
                }
                write_parts(kernel, sum, begun ? begun->values.data() + at.first + i : nullptr,
                            {out.values.data() + at.first + i, out.stride, at.apart}, frame);
            }
        };
        threads.for_chunks(rows / 2 + 1, rows_per_chunk(system.grid), [&](std::size_t begin, std::size_t end) {
            std::vector<Complex> scratch;
            for (std::size_t row = begin; row < end; ++row) {
                const std::size_t kept = kept_in_row(system.grid, wavenumbers, row), partner = (rows - row) % rows;
                if (kept == 0) continue;
                const auto apart =
                    static_cast<std::ptrdiff_t>(partner * width) - static_cast<std::ptrdiff_t>(row * width);
                const Rows at{.first = row * width, .kept = kept, .apart = apart};
                if (apart == 0) of_rows(row, at, scratch, Pair{});
                else of_rows(row, at, scratch, Quad{});
            }
        });
    });
}

/// Inverse transforms ignore the part of column 0 that belongs to no real field.  Rounding creates such a part, which a
/// growing linear mode would amplify without bound.
void Stepper::Work::enforce_hermitian(Spectra& state) const {
    const std::size_t width = columns(system.grid), rows = static_cast<std::size_t>(system.grid.ny);
    for (int c = 0; c < state.count(); ++c) {
        const std::span<Complex> values = state[c];
        values[0] = values[0].real();
        for (std::size_t j = rows / 2 + 1; j < rows; ++j) values[j * width] = std::conj(values[(rows - j) * width]);
    }
}

Stepper::Stepper(const System& system, const StepperTable& table, double dt, std::uint64_t seed, Threads& threads,
                 std::shared_ptr<StepperScratch> scratch)
    : work_(std::make_unique<Work>(system, table, dt, make_noise_path(checked(system), dt, seed, threads), 0, threads,
                                   std::move(scratch))) {}
Stepper::Stepper(const System& system, const StepperTable& table, double dt, int halvings,
                 std::shared_ptr<NoisePath> noise, Threads& threads, std::shared_ptr<StepperScratch> scratch)
    : work_(std::make_unique<Work>(system, table, std::ldexp(dt, -halvings), std::move(noise), halvings, threads,
                                   std::move(scratch))) {}
Stepper::~Stepper() = default;
Stepper::Stepper(Stepper&&) noexcept = default;
Stepper& Stepper::operator=(Stepper&&) noexcept = default;

double Stepper::dt() const { return work_->dt; }

void Stepper::Work::take_stages(double t, std::uint64_t step_number, const Spectra& state, bool knows_first_rate) {
    const std::size_t last = table.stages.size() - 1;
    if (system.set_step) system.set_step(dt);
    for (std::size_t s = 0; s <= last; ++s) {
        const double c = s == 0 ? 0.0 : table.stages[s - 1].c;
        if (system.nonlinear && !(s == 0 && knows_first_rate))
            system.nonlinear(t + c * dt, s == 0 ? state : stage, rates[s]);
        const Combination& combination = combinations[s];
        const bool with_noise = noise && noise->has_sums() && !combination.plan.from_previous;
        const int level = noise_level + combination.halvings;
        if (with_noise) noise->compute({.level = level, .index = step_number << combination.halvings});
        combine(combination, state, with_noise ? level : -1, s == last ? next : stage);
    }
    if (system.product_noise) {
        NoisePath& path = *noise->of_products();
        path.compute({.level = product_level, .index = step_number});
        path.write(product_level, product_noise);
        system.product_noise->add(t + 0.5 * dt, state, product_noise, next);
    }
    if (system.nonlinear) enforce_hermitian(next);
}

void Stepper::step(double t, std::uint64_t step_number, Spectra& state, bool knows_first_rate) {
    check(state, work_->system.grid, components(work_->system.layout));
    if (work_->table.history > 0) return work_->step_with_history(t, step_number, state);
    work_->take_stages(t, step_number, state, knows_first_rate);
    std::swap(state.values, work_->next.values);
}

/// The rate at the start of the last step becomes the newest of the old ones; the oldest is overwritten next.
void Stepper::Work::keep_last_rate() {
    for (std::size_t k = rates.size() - 1; k > first_old_rate(); --k) std::swap(rates[k].values, rates[k - 1].values);
    std::swap(rates[first_old_rate()].values, rates[0].values);
}

void Stepper::Work::step_with_history(double t, std::uint64_t step_number, Spectra& state) {
    if (step_number != following_step) known_rates = 0;
    if (known_rates == 0) knows_new_rate = false;
    else keep_last_rate();
    if (system.set_step) system.set_step(dt);
    if (knows_new_rate) std::swap(rates[0].values, rates[table.stages.size()].values);
    else system.nonlinear(t, state, rates[0]);
    knows_new_rate = false;
    const std::size_t old_rates = rates.size() - first_old_rate();
    can_estimate = known_rates >= old_rates;
    if (known_rates < static_cast<std::size_t>(table.history)) {
        start_step(t, step_number, state);
    } else {
        starter.reset();
        right_hand_sides = static_cast<std::int64_t>(table.stages.size());
        take_stages(t, step_number, state, true);
        std::swap(state.values, next.values);
    }
    known_rates = std::min(known_rates + 1, old_rates);
    following_step = step_number + 1;
}

void Stepper::Work::start_step(double t, std::uint64_t step_number, Spectra& state) {
    const int parts = table.start_parts;
    const StepperTable& start = stepper_table(table.start);
    right_hand_sides = 1 + parts * static_cast<std::int64_t>(start.stages.size());
    if (!starter) starter = std::make_unique<Stepper>(system, start, dt / parts, 0, threads);
    for (int part = 0; part < parts; ++part)
        starter->step(t + dt * part / parts,
                      step_number * static_cast<std::uint64_t>(parts) + static_cast<std::uint64_t>(part), state);
}

bool Stepper::last_error(double t_end, const Spectra& state, Spectra& error) {
    Work& w = *work_;
    if (!w.can_estimate) return false;
    if (!w.knows_new_rate) w.system.nonlinear(t_end, state, w.rates[w.table.stages.size()]);
    w.knows_new_rate = true;
    w.combine(w.estimate, state, -1, error);
    return true;
}

std::int64_t Stepper::steps_to_error() const {
    const Work& w = *work_;
    if (w.table.history == 0) return 0;
    return static_cast<std::int64_t>(w.rates.size() - w.first_old_rate() - w.known_rates) + 1;
}

std::int64_t Stepper::right_hand_sides() const { return work_->right_hand_sides; }

std::vector<double> Stepper::save_history() const {
    const Work& w = *work_;
    if (w.known_rates == 0) return {};
    std::vector<double> saved{static_cast<double>(w.following_step)};
    for (std::size_t k = 0; k < w.known_rates; ++k) {
        const auto parts = parts_of(w.rates[k == 0 ? 0 : w.first_old_rate() + k - 1].values);
        saved.insert(saved.end(), parts.begin(), parts.end());
    }
    return saved;
}

void Stepper::restore_history(std::span<const double> saved) {
    Work& w = *work_;
    w.known_rates = 0;
    w.can_estimate = w.knows_new_rate = false;
    if (saved.empty()) return;
    const std::size_t numbers = 2 * w.next.values.size(), count = (saved.size() - 1) / numbers;
    const std::size_t max_rates = w.table.history == 0 ? 0 : w.rates.size() - w.first_old_rate();
    require(saved.size() == 1 + count * numbers && count >= 1 && count <= max_rates && saved[0] >= 0.0 &&
                saved[0] < 0x1p53,
            {},
            "the checkpoint contains {} numbers of the history of \"{}\"; expected 1 + {} for each of at most {} "
            "rates; use the other checkpoint",
            saved.size(), w.table.name, numbers, max_rates);
    w.following_step = static_cast<std::uint64_t>(saved[0]);
    w.known_rates = count;
    for (std::size_t k = 0; k < count; ++k)
        std::ranges::copy(saved.subspan(1 + k * numbers, numbers),
                          parts_of(w.rates[k == 0 ? 0 : w.first_old_rate() + k - 1].values).begin());
}

bool Stepper::estimates_error() const { return work_->table.history == 0 && !work_->estimate.plan.uses.empty(); }

void Stepper::attempt(double t, std::uint64_t step_number, const Spectra& state, Spectra& next, Spectra& error) {
    Work& w = *work_;
    require(estimates_error(), {}, "stepper \"{}\" has no estimate of its error; expected one that has", w.table.name);
    for (const Spectra* arrays : std::initializer_list<const Spectra*>{&state, &next, &error})
        check(*arrays, w.system.grid, components(w.system.layout));
    w.take_stages(t, step_number, state);
    if (w.table.error.size() > w.table.stages.size()) w.system.nonlinear(t + w.dt, w.next, w.rates.back());
    w.combine(w.estimate, state, -1, error);
    std::ranges::copy(w.next.values, next.values.begin());
}

double stepper_bytes(const System& system, const StepperTable& table, int count) {
    const StepperTable& used = system.nonlinear ? table : linear_table();
    const double spectra = static_cast<double>(modes(system.grid)) * components(system.layout) * sizeof(Complex);
    double matrices = 0.0;
    for (const StagePlan& plan : stage_plans(used)) matrices += static_cast<double>(plan.uses.size());
    matrices += static_cast<double>(error_plan(used).uses.size());
    double held = 1.0;
    if (system.nonlinear) held += 1.0 + static_cast<double>(std::max(used.stages.size(), used.error.size()));
    // On a line all modes have distinct |q|; else at most a quarter of the kept ones, an eighth on a square.
    const double shared = system.grid.ny == 1                ? 1.0
                          : system.grid.lx == system.grid.ly ? 4.0
                                                             : 2.0,
                 distinct = static_cast<double>(modes(system.grid)) / shared;
    return spectra * held * (used.history > 0 ? count : 1) +
           count * (distinct * matrices * static_cast<double>(block_entries(system.layout)) * sizeof(double) +
                    static_cast<double>(modes(system.grid)) * sizeof(std::int32_t));
}

}  // namespace drover::numerics
