// model/right_hand_side.cpp: fields to the grid, the functions at its points, and back.
#include <algorithm>
#include <array>
#include <complex>
#include <mutex>

#include "model/compiled.hpp"
#include "model/explicit_part.hpp"
#include "model/mode_operators.hpp"
#include "model/point_functions.hpp"

namespace drover::model {

using numerics::Complex;
using numerics::Spectra;

struct ExplicitPart::Work {
    Work(std::shared_ptr<const CompiledEquations> equations, const numerics::System& system, Threads& the_threads)
        : Work(equations, equations->state, system, the_threads) {}
    /// `targets`: the components whose rates, or forces in their balances, are written.
    Work(std::shared_ptr<const CompiledEquations> equations, std::vector<int> targets, const numerics::System& system,
         Threads& the_threads);

    /// An array of modes that is a sum of derivatives of others.
    struct Derived {
        DerivativeSum sum;
        int array = -1;  ///< of the scratch
    };
    /// The rate of one component: what the transforms wrote there, if they did, and derivatives of other outputs.
    struct Assembled {
        DerivativeSum sum;  ///< of the outputs and, after them, the components
        int array = -1, component = -1;
        bool is_written = false;
    };
    /// The extremes of an input.
    struct Watched {
        int component = -1;
        std::size_t input = 0;
        Range range = {};
    };

    void hold(int component);
    void plan_inputs();
    void plan_outputs();
    void plan_balance();
    void plan_given();
    void plan_anisotropic();
    void plan_forces(const numerics::System& system);
    void plan_solenoidal();
    bool is_held(int component) const { return held_[static_cast<std::size_t>(component)] >= 0; }
    void evaluate(double t, const Spectra& state, Spectra& rate);
    void point_at(const Spectra& state, Spectra& rate);
    void find_forces(double t, const Spectra& state);
    void derive_inputs(double t, const ModeRow& row);
    void at_points(double t, const numerics::Strip& strip);
    void note(const numerics::Strip& strip);
    void assemble(Spectra& rate) const;

    std::shared_ptr<const CompiledEquations> c_;
    std::vector<int> targets_;
    TransformPlan plan_;
    PointFunctions functions_;
    numerics::Grid grid_;
    int degree_;
    Threads& threads_;
    numerics::Transform transform_;
    numerics::DistinctWavenumbers wavenumbers_;
    ModeRows rows_;
    int arrays_ = 0;               // of the scratch
    std::vector<int> held_;        // array of each component in balance that is an input, or given; -1: none
    std::vector<Derived> inputs_;  // array -1: a component itself
    std::vector<int> outputs_;     // array of each output; -1: straight to a rate
    std::vector<Assembled> assembled_;
    std::vector<double> sources_, held_means_;
    FrameOperator balance_;           // components in balance, of the others
    FrameOperator driven_;            // less the rates by given components, which the propagator does not have
    FrameOperator propagated_;        // of anisotropic equations: what the propagator has of the linear part
    FrameOperator divergence_;        // of divergence-free fields: their parts along q
    std::unique_ptr<Work> forces_;    // products in balances; nullptr: none
    std::unique_ptr<Work> balances_;  // for balanced(), once it was asked for
    Spectra force_;
    FrameOperator response_, carried_;  // less components in balance, and rates, by them
    std::vector<Watched> watched_;
    std::mutex mutex_;  // of their ranges
    Spectra scratch_;
    // At one call: arrays of the components and of what the sums of rates read, of the transforms, of the rates.
    std::vector<const Complex*> components_, summands_, from_;
    std::vector<const Complex*> given_;  // empty: point sources
    std::vector<const Complex*> force_components_;
    std::vector<Complex*> written_components_, to_, rates_;
    std::vector<const Complex*> constant_rates_;
};

ExplicitPart::Work::Work(std::shared_ptr<const CompiledEquations> equations, std::vector<int> targets,
                         const numerics::System& system, Threads& the_threads)
    : c_(std::move(equations)),
      targets_(std::move(targets)),
      plan_(transform_plan(*c_)),
      functions_(*c_, plan_, system.grid),
      grid_(system.grid),
      degree_(system.degree),
      threads_(the_threads),
      transform_(grid_, system.degree, threads_),
      wavenumbers_(numerics::distinct_wavenumbers(grid_, system.degree)),
      rows_(grid_, wavenumbers_),
      held_(static_cast<std::size_t>(c_->components), -1) {
    sources_ = c_->sources(&held_means_);
    held_means_.resize(held_.size(), 0.0);
    for (int k = 0; k < c_->components; ++k)
        if (c_->is_given(k)) held_[static_cast<std::size_t>(k)] = arrays_++;
    plan_inputs();
    plan_outputs();
    plan_balance();
    plan_given();
    if (!c_->is_isotropic) plan_anisotropic();
    if (!c_->forces.empty()) plan_forces(system);
    if (c_->has_solenoidal()) plan_solenoidal();
    scratch_ = Spectra(grid_, arrays_);
}

/// A component that is read, of a field in balance with those that turn with it.
void ExplicitPart::Work::hold(int component) {
    if (!c_->in_balance(component) || is_held(component)) return;
    const std::size_t field = c_->field(component);
    for (int k = 0; k < components(c_->model.fields[field]); ++k)
        held_[static_cast<std::size_t>(c_->first_component[field] + k)] = arrays_++;
}

void ExplicitPart::Work::plan_inputs() {
    if (!c_->is_isotropic)
        for (const int k : c_->state)
            for (const auto& [derivative, coefficient] : c_->linear[static_cast<std::size_t>(k)])
                hold(derivative.component);
    for (const LinearForm& input : plan_.inputs) {
        Derived derived;
        for (const auto& [derivative, coefficient] : input) {
            derived.sum.add(static_cast<std::size_t>(derivative.component), derivative.order, coefficient);
            hold(derivative.component);
        }
        if (!is_plain(input)) derived.array = arrays_++;
        inputs_.push_back(std::move(derived));
    }
}

void ExplicitPart::Work::plan_outputs() {
    for (const RateFunction& output : c_->outputs)
        outputs_.push_back(output.uses.size() == 1 && output.uses[0].order == Order{} ? -1 : arrays_++);
    for (std::size_t array = 0; array < targets_.size(); ++array) {
        Assembled rate{.sum = {}, .array = static_cast<int>(array), .component = targets_[array]};
        for (std::size_t k = 0; k < c_->outputs.size(); ++k)
            for (const RateFunction::Use& use : c_->outputs[k].uses) {
                if (use.component != rate.component) continue;
                if (outputs_[k] < 0) rate.is_written = true;
                else rate.sum.add(k, use.order, use.factor);
            }
        assembled_.push_back(std::move(rate));
    }
}

void ExplicitPart::Work::plan_balance() {
    std::vector<bool> results;
    for (int k = 0; k < c_->components; ++k) results.push_back(is_held(k) && c_->in_balance(k));
    if (std::ranges::find(results, true) == results.end()) return;
    std::vector<Symbol> matrices;
    for (const double q : wavenumbers_.q) {
        Symbol& balance = matrices.emplace_back();
        static_cast<void>(c_->eliminated(c_->averaged(c_->linear, q), &balance));
        for (int k = 0; k < c_->components; ++k)
            if (!results[static_cast<std::size_t>(k)]) balance.row(k).setZero();
    }
    balance_ = FrameOperator(*c_, matrices, wavenumbers_, results);
}

void ExplicitPart::Work::plan_given() {
    if (c_->free.size() == c_->state.size() || targets_ != c_->state) return;
    std::vector<Symbol> matrices;
    for (const double q : wavenumbers_.q) {
        Symbol& less = matrices.emplace_back(-c_->eliminated(c_->averaged(c_->linear, q)));
        for (int k = 0; k < c_->components; ++k)
            if (c_->is_given(k)) less.row(k).setZero();
            else less.col(k).setZero();
    }
    driven_ = FrameOperator(*c_, matrices, wavenumbers_, std::vector<bool>(held_.size(), false));
}

/// The linear part joins the rates, without what the propagator has of it.
void ExplicitPart::Work::plan_anisotropic() {
    for (Assembled& rate : assembled_)
        for (const auto& [derivative, coefficient] : c_->linear[static_cast<std::size_t>(rate.component)])
            rate.sum.add(outputs_.size() + static_cast<std::size_t>(derivative.component), derivative.order,
                         coefficient);
    std::vector<Symbol> matrices;
    for (const double q : wavenumbers_.q) {
        Symbol& of_state = matrices.emplace_back(c_->averaged(c_->linear, q));
        for (int k = 0; k < c_->components; ++k)
            if (c_->array_of[static_cast<std::size_t>(k)] < 0) of_state.row(k).setZero();
    }
    propagated_ = FrameOperator(*c_, matrices, wavenumbers_, std::vector<bool>(held_.size(), false));
}

/// A balance m v + ... + f = 0 with a product f gives v less m^-1 f, and rates less what v does to them.
void ExplicitPart::Work::plan_forces(const numerics::System& system) {
    const std::vector<int>& held = c_->held;
    forces_ = std::make_unique<Work>(with_forces_as_outputs(*c_), held, system, threads_);
    force_ = Spectra(grid_, static_cast<int>(held.size()));
    force_components_.assign(held_.size(), nullptr);
    for (std::size_t k = 0; k < held.size(); ++k)
        force_components_[static_cast<std::size_t>(held[k])] = force_[static_cast<int>(k)].data();
    std::vector<Symbol> responses, carried;
    for (const double q : wavenumbers_.q) {
        const Symbol m = c_->averaged(c_->linear, q);
        Symbol inverse = Symbol::Zero(c_->components, c_->components);
        inverse(held, held) = c_->inverse_of_balance(m, q);
        carried.push_back(Symbol::Zero(c_->components, c_->components));
        carried.back()(c_->state, held) = m(c_->state, held) * inverse(held, held);
        responses.push_back(inverse);
        for (const int k : held)
            if (!is_held(k)) responses.back().row(k).setZero();
    }
    const std::vector<bool> none(held_.size(), false);
    response_ = FrameOperator(*c_, responses, wavenumbers_, none);
    carried_ = FrameOperator(*c_, carried, wavenumbers_, none);
}

void ExplicitPart::Work::plan_solenoidal() {
    std::vector<Symbol> matrices;
    for (const double q : wavenumbers_.q) {
        Symbol& along = matrices.emplace_back(Symbol::Zero(c_->components, c_->components));
        for (const int k : targets_)
            if (q > 0.0 && c_->is_solenoidal(k) && c_->part_of(k) == 0) along(k, k) = 1.0;
    }
    divergence_ = FrameOperator(*c_, matrices, wavenumbers_, std::vector<bool>(held_.size(), false));
}

void ExplicitPart::Work::find_forces(double t, const Spectra& state) {
    if (!forces_) return;
    force_.values.assign(force_.values.size(), Complex(0.0));
    forces_->given_ = given_;
    forces_->evaluate(t, state, force_);
}

void ExplicitPart::Work::evaluate(double t, const Spectra& state, Spectra& rate) {
    for (Watched& one : watched_) one.range = {};
    find_forces(t, state);
    point_at(state, rate);
    rows_.for_each(threads_, [&](const ModeRow& row) { derive_inputs(t, row); });
    if (!c_->outputs.empty())
        transform_.products(from_, to_, [&](const numerics::Strip& strip) { at_points(t, strip); });
    assemble(rate);
}

void ExplicitPart::Work::point_at(const Spectra& state, Spectra& rate) {
    components_.assign(held_.size(), nullptr);
    written_components_.assign(held_.size(), nullptr);
    rates_.assign(held_.size(), nullptr);
    from_.clear();
    to_.clear();
    summands_.clear();
    for (std::size_t k = 0; k < held_.size(); ++k) {
        if (const int array = c_->array_of[k]; array >= 0) components_[k] = state[array].data();
        else if (held_[k] >= 0) {
            components_[k] = scratch_[held_[k]].data();
            if (c_->in_balance(static_cast<int>(k))) written_components_[k] = scratch_[held_[k]].data();
        }
    }
    for (std::size_t k = 0; k < targets_.size(); ++k)
        rates_[static_cast<std::size_t>(targets_[k])] = rate[static_cast<int>(k)].data();
    constant_rates_.assign(rates_.begin(), rates_.end());
    for (std::size_t i = 0; i < inputs_.size(); ++i)
        from_.push_back(inputs_[i].array >= 0
                            ? scratch_[inputs_[i].array].data()
                            : components_[static_cast<std::size_t>(plan_.inputs[i].begin()->first.component)]);
    for (std::size_t k = 0; k < outputs_.size(); ++k)
        to_.push_back(outputs_[k] >= 0 ? scratch_[outputs_[k]].data()
                                       : rates_[static_cast<std::size_t>(c_->outputs[k].uses[0].component)]);
    summands_.assign(to_.begin(), to_.end());
    summands_.insert(summands_.end(), components_.begin(), components_.end());
}

namespace {
/// The modes of a source at a time.
void write_source(const PointSource& source, int part, const numerics::Grid& grid, double t, const ModeRow& row,
                  Complex* to) {
    const double x = source.at_x + source.velocity_x * t, y = source.at_y + source.velocity_y * t;
    const double strength = (part == 0 ? source.x : source.y) / numerics::area(grid);
    for (std::size_t i = 0; i < row.size; ++i) {
        const double q = row.x[2 * i], square = q * q + row.y * row.y;
        to[row.first + i] =
            strength * std::exp(-0.5 * source.width * source.width * square) * std::polar(1.0, -(q * x + row.y * y));
    }
}

/// Equations whose functions at points are the components in balance.
std::shared_ptr<const CompiledEquations> with_balances_as_outputs(const CompiledEquations& equations) {
    auto c = std::make_shared<CompiledEquations>(equations);
    c->outputs.clear();
    for (int k = 0; k < c->components; ++k) {
        if (!c->in_balance(k) && !c->is_substituted[c->field(k)]) continue;
        RateFunction& output = c->outputs.emplace_back();
        const LinearForm itself{{{k, Order{}}, 1.0}};
        if (c->in_balance(k)) {
            GraphBuilder graph(Folding::exact);
            output.value = graph.expression(graph.slot(c->slots()));
            c->atoms.push_back(itself);
            continue;
        }
        for (const Term& term : c->substitutes)
            if (term.summary.field == c->field(k))
                for (const PointFunction& function : term.rows[static_cast<std::size_t>(c->part_of(k))].functions)
                    output.value = output.value + function.value;
    }
    return c;
}
}  // namespace

void ExplicitPart::Work::derive_inputs(double t, const ModeRow& row) {
    std::size_t given = 0;
    for (int k = 0; k < c_->components; ++k) {
        if (!c_->is_given(k)) continue;
        Complex* to = scratch_[held_[static_cast<std::size_t>(k)]].data();
        if (given < given_.size()) std::copy_n(given_[given++] + row.first, row.size, to + row.first);
        else write_source(c_->model.fields[c_->field(k)].source, c_->part_of(k), grid_, t, row, to);
    }
    balance_.apply(row, components_, written_components_, false);
    if (forces_) response_.apply(row, force_components_, written_components_, true);
    if (row.first == 0)
        for (std::size_t k = 0; k < held_.size(); ++k)
            if (written_components_[k] != nullptr) scratch_[held_[k]][0] += held_means_[k];
    for (const Derived& input : inputs_)
        if (input.array >= 0) input.sum.write(row, components_, scratch_[input.array].data(), false);
}

void ExplicitPart::Work::note(const numerics::Strip& strip) {
    for (Watched& one : watched_) {
        const double* values = strip.in[one.input];
        constexpr std::size_t lanes = 8;  // for the vector instructions of the processor
        std::array<double, lanes> low, high;
        low.fill(Range{}.min);
        high.fill(Range{}.max);
        std::size_t i = 0;
        for (; i + lanes <= strip.size; i += lanes)
            for (std::size_t k = 0; k < lanes; ++k) {
                low[k] = values[i + k] < low[k] ? values[i + k] : low[k];
                high[k] = values[i + k] > high[k] ? values[i + k] : high[k];
            }
        for (; i < strip.size; ++i) {
            low[0] = std::min(low[0], values[i]);
            high[0] = std::max(high[0], values[i]);
        }
        const std::lock_guard lock(mutex_);
        one.range.min = std::min(one.range.min, *std::ranges::min_element(low));
        one.range.max = std::max(one.range.max, *std::ranges::max_element(high));
    }
}

void ExplicitPart::Work::at_points(double t, const numerics::Strip& strip) {
    note(strip);
    functions_.write(t, strip);
}

void ExplicitPart::Work::assemble(Spectra& rate) const {
    rows_.for_each(threads_, [&](const ModeRow& row) {
        for (const Assembled& one : assembled_)
            if (!one.is_written || !one.sum.is_empty())
                one.sum.write(row, summands_, rate[one.array].data(), one.is_written);
        driven_.apply(row, components_, rates_, true);
        if (!c_->is_isotropic) propagated_.apply(row, components_, rates_, true);
        if (forces_) carried_.apply(row, force_components_, rates_, true);
        divergence_.apply(row, constant_rates_, rates_, true);
    });
    if (targets_ != c_->state) return;  // sources are parts of the balances
    for (const Assembled& one : assembled_) {
        Complex& mean = rate[one.array][0];
        mean += sources_[static_cast<std::size_t>(one.component)];
        if (c_->model.fields[c_->field(one.component)].conserved) mean = 0.0;
    }
}

ExplicitPart::ExplicitPart(const Equations& equations, const numerics::System& linear, Threads& threads)
    : work_(std::make_unique<Work>(equations.compiled_, linear, threads)) {}
ExplicitPart::ExplicitPart(ExplicitPart&&) noexcept = default;
ExplicitPart::~ExplicitPart() = default;

void ExplicitPart::operator()(double t, const Spectra& state, Spectra& rate) { work_->evaluate(t, state, rate); }

void ExplicitPart::set_given(std::vector<const Complex*> arrays) { work_->given_ = std::move(arrays); }
void ExplicitPart::set_step(double dt) {
    work_->functions_.set_step(dt);
    if (work_->forces_) work_->forces_->functions_.set_step(dt);
}
double ExplicitPart::mass_floor(std::size_t field) const { return work_->functions_.mass_floor(field); }

void ExplicitPart::watch(int component) {
    const std::vector<LinearForm>& inputs = work_->plan_.inputs;
    for (std::size_t n = 0; n < inputs.size(); ++n)
        if (is_plain(inputs[n]) && inputs[n].begin()->first.component == component)
            work_->watched_.push_back({.component = component, .input = n});
}

Range ExplicitPart::range(int component) const {
    for (const Work::Watched& one : work_->watched_)
        if (one.component == component) return one.range;
    return {};
}

numerics::Fields ExplicitPart::balanced(double t, const Spectra& state) const {
    if (!work_->balances_) {
        numerics::System system{.grid = work_->grid_};
        system.degree = work_->degree_;
        work_->balances_ = std::make_unique<Work>(with_balances_as_outputs(*work_->c_), system, work_->threads_);
    }
    Work& values = *work_->balances_;
    numerics::Fields result(work_->grid_, static_cast<int>(values.outputs_.size()));
    Spectra rate(work_->grid_, state.count());
    values.find_forces(t, state);
    values.point_at(state, rate);
    values.rows_.for_each(values.threads_, [&](const ModeRow& row) { values.derive_inputs(t, row); });
    values.transform_.products(values.from_, values.to_, [&](const numerics::Strip& strip) {
        values.at_points(t, strip);
        for (std::size_t k = 0; k < strip.out.size(); ++k)
            std::copy_n(strip.out[k], strip.size, result[static_cast<int>(k)].data() + strip.first);
    });
    return result;
}

double ExplicitPart::bytes(const Equations& equations, const numerics::Grid& grid, int degree) {
    if (!equations.has_nonlinear_part()) return 0.0;
    const TransformPlan plan = transform_plan(*equations.compiled_);
    const double spectra = static_cast<double>(numerics::modes(grid)) * sizeof(Complex);
    const auto inputs = static_cast<double>(plan.inputs.size()), outputs = static_cast<double>(plan.values.size());
    const auto derived =
        static_cast<double>(std::ranges::count_if(plan.inputs, [](const auto& form) { return !is_plain(form); }));
    double total = spectra * (derived + outputs + 2.0 * (inputs + outputs) / (degree + 1));
    if (const CompiledEquations& c = *equations.compiled_; !c.forces.empty())
        total +=
            bytes(Equations(with_forces_as_outputs(c)), grid, degree) + spectra * static_cast<double>(c.held.size());
    for (const NoiseProducts& one : equations.compiled_->products)
        total +=
            bytes(Equations(one.equations), grid, degree) + spectra * static_cast<double>(one.equations->components);
    return total;
}

}  // namespace drover::model
