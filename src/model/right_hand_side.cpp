// model/right_hand_side.cpp: fields to the grid, the functions at its points, and back.
#include <algorithm>
#include <array>
#include <set>

#include "compiled.hpp"
#include "drover/numerics/transform.hpp"
#include "frame_operator.hpp"
#include "mode_rows.hpp"
#include "transform_plan.hpp"

namespace drover::model {

namespace {
using numerics::Complex;
using numerics::Spectra;

class NonlinearPart {
public:
    NonlinearPart(std::shared_ptr<const CompiledEquations> equations, const numerics::System& system,
                  Threads& the_threads);
    void operator()(double t, const Spectra& state, Spectra& rate);

private:
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

    void plan_inputs();
    void plan_outputs();
    void plan_balance();
    void plan_anisotropic();
    bool is_held(int component) const { return held_[static_cast<std::size_t>(component)] >= 0; }
    void point_at(const Spectra& state, Spectra& rate);
    void derive_inputs(const ModeRow& row);
    void at_points(double t, const numerics::Strip& strip) const;
    void assemble(Spectra& rate) const;

    std::shared_ptr<const CompiledEquations> c_;
    TransformPlan plan_;
    StripProgram program_;
    numerics::Grid grid_;
    Threads& threads_;
    numerics::Transform transform_;
    numerics::DistinctWavenumbers wavenumbers_;
    ModeRows rows_;
    bool reads_position_ = false;
    int arrays_ = 0;               // of the scratch
    std::vector<int> held_;        // array of each component in balance that is an input; -1: none
    std::vector<Derived> inputs_;  // array -1: a component itself
    std::vector<int> outputs_;     // array of each output; -1: straight to a rate
    std::vector<Assembled> assembled_;
    std::vector<double> sources_, held_means_;
    FrameOperator balance_;     // components in balance, of the state
    FrameOperator propagated_;  // of anisotropic equations: what the propagator has of the linear part
    Spectra scratch_;
    // At one call: arrays of the components and of what the sums of rates read, of the transforms, of the rates.
    std::vector<const Complex*> components_, summands_, from_;
    std::vector<Complex*> written_components_, to_, rates_;
};

NonlinearPart::NonlinearPart(std::shared_ptr<const CompiledEquations> equations, const numerics::System& system,
                             Threads& the_threads)
    : c_(std::move(equations)),
      plan_(transform_plan(*c_)),
      program_(plan_.values),
      grid_(system.grid),
      threads_(the_threads),
      transform_(grid_, system.degree, threads_),
      wavenumbers_(numerics::distinct_wavenumbers(grid_, system.degree)),
      rows_(grid_, wavenumbers_),
      held_(static_cast<std::size_t>(c_->components), -1) {
    std::set<int> slots;
    for (const Expression& value : plan_.values) slots.merge(slots_of(value));
    reads_position_ = slots.count(slot_x) + slots.count(slot_y) > 0;
    sources_ = c_->sources(&held_means_);
    plan_inputs();
    plan_outputs();
    if (std::any_of(held_.begin(), held_.end(), [](int array) { return array >= 0; })) plan_balance();
    if (!c_->is_isotropic) plan_anisotropic();
    scratch_ = Spectra(grid_, arrays_);
}

void NonlinearPart::plan_inputs() {
    for (const LinearForm& input : plan_.inputs) {
        Derived derived;
        for (const auto& [derivative, coefficient] : input) {
            derived.sum.add(static_cast<std::size_t>(derivative.component), derivative.order, coefficient);
            if (!c_->in_balance(derivative.component) || is_held(derivative.component)) continue;
            const std::size_t field = c_->field(derivative.component);  // both components turn together
            for (int k = 0; k < components(c_->model.fields[field]); ++k)
                held_[static_cast<std::size_t>(c_->first_component[field] + k)] = arrays_++;
        }
        if (!is_plain(input)) derived.array = arrays_++;
        inputs_.push_back(std::move(derived));
    }
}

void NonlinearPart::plan_outputs() {
    for (const Output& output : c_->outputs)
        outputs_.push_back(output.uses.size() == 1 && output.uses[0].order == Order{} ? -1 : arrays_++);
    for (std::size_t array = 0; array < c_->state.size(); ++array) {
        Assembled rate{.sum = {}, .array = static_cast<int>(array), .component = c_->state[array]};
        for (std::size_t k = 0; k < c_->outputs.size(); ++k)
            for (const Output::Use& use : c_->outputs[k].uses) {
                if (use.component != rate.component) continue;
                if (outputs_[k] < 0) rate.is_written = true;
                else rate.sum.add(k, use.order, use.factor);
            }
        assembled_.push_back(std::move(rate));
    }
}

void NonlinearPart::plan_balance() {
    std::vector<Symbol> matrices;
    for (const double q : wavenumbers_.q) {
        Symbol& balance = matrices.emplace_back();
        static_cast<void>(c_->eliminated(c_->averaged(c_->linear, q), &balance));
        for (int k = 0; k < c_->components; ++k)
            if (!is_held(k)) balance.row(k).setZero();
    }
    std::vector<bool> results;
    for (int k = 0; k < c_->components; ++k) results.push_back(is_held(k));
    balance_ = FrameOperator(*c_, matrices, wavenumbers_, results);
}

/// The linear part joins the rates, without what the propagator has of it.
void NonlinearPart::plan_anisotropic() {
    for (Assembled& rate : assembled_)
        for (const auto& [derivative, coefficient] : c_->linear[static_cast<std::size_t>(rate.component)])
            rate.sum.add(outputs_.size() + static_cast<std::size_t>(derivative.component), derivative.order,
                         coefficient);
    std::vector<Symbol> matrices;
    for (const double q : wavenumbers_.q) matrices.push_back(c_->averaged(c_->linear, q));
    propagated_ = FrameOperator(*c_, matrices, wavenumbers_, std::vector<bool>(held_.size(), false));
}

void NonlinearPart::operator()(double t, const Spectra& state, Spectra& rate) {
    point_at(state, rate);
    rows_.for_each(threads_, [&](const ModeRow& row) { derive_inputs(row); });
    if (!c_->outputs.empty())
        transform_.products(from_, to_, [&](const numerics::Strip& strip) { at_points(t, strip); });
    assemble(rate);
}

void NonlinearPart::point_at(const Spectra& state, Spectra& rate) {
    components_.assign(held_.size(), nullptr);
    written_components_.assign(held_.size(), nullptr);
    rates_.assign(held_.size(), nullptr);
    from_.clear();
    to_.clear();
    summands_.clear();
    for (std::size_t k = 0; k < held_.size(); ++k) {
        if (const int array = c_->array_of[k]; array >= 0) {
            components_[k] = state[array].data();
            rates_[k] = rate[array].data();
        } else if (held_[k] >= 0) components_[k] = written_components_[k] = scratch_[held_[k]].data();
    }
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

void NonlinearPart::derive_inputs(const ModeRow& row) {
    balance_.apply(row, components_, written_components_, false);
    if (row.first == 0)
        for (std::size_t k = 0; k < held_.size(); ++k)
            if (held_[k] >= 0) scratch_[held_[k]][0] += held_means_[k];
    for (const Derived& input : inputs_)
        if (input.array >= 0) input.sum.write(row, components_, scratch_[input.array].data(), false);
}

/// All that the functions read at a few points is then in the first-level cache.
void NonlinearPart::at_points(double t, const numerics::Strip& strip) const {
    constexpr std::size_t most_placed = 256;
    std::array<double, most_placed> x, y;
    const std::size_t step = reads_position_ ? most_placed : strip.size;
    std::vector<const double*> slots(first_atom + plan_.inputs.size(), nullptr);
    std::vector<double> uniform(slots.size(), 0.0);
    uniform[slot_t] = t;
    std::vector<double*> out(strip.out.size());
    for (std::size_t begin = 0; begin < strip.size; begin += step) {
        const std::size_t size = std::min(step, strip.size - begin);
        for (std::size_t i = 0; i < plan_.inputs.size(); ++i) slots[first_atom + i] = strip.in[i] + begin;
        for (std::size_t k = 0; k < out.size(); ++k) out[k] = strip.out[k] + begin;
        if (reads_position_) {
            const auto width = static_cast<std::size_t>(grid_.nx);
            for (std::size_t i = 0; i < size; ++i) {
                x[i] = grid_.lx / grid_.nx * static_cast<double>((strip.first + begin + i) % width);
                y[i] = grid_.ly / grid_.ny * static_cast<double>((strip.first + begin + i) / width);
            }
            slots[slot_x] = x.data();
            slots[slot_y] = y.data();
        }
        program_.write(size, slots, uniform, out);
    }
}

void NonlinearPart::assemble(Spectra& rate) const {
    rows_.for_each(threads_, [&](const ModeRow& row) {
        for (const Assembled& one : assembled_)
            if (!one.is_written || !one.sum.is_empty())
                one.sum.write(row, summands_, rate[one.array].data(), one.is_written);
        if (!c_->is_isotropic) propagated_.apply(row, components_, rates_, true);
    });
    for (const Assembled& one : assembled_) {
        Complex& mean = rate[one.array][0];
        mean += sources_[static_cast<std::size_t>(one.component)];
        if (c_->model.fields[c_->field(one.component)].conserved) mean = 0.0;
    }
}
}  // namespace

std::function<void(double, const Spectra&, Spectra&)> nonlinear_part(std::shared_ptr<const CompiledEquations> equations,
                                                                     const numerics::System& system, Threads& threads) {
    const bool has_sources = std::any_of(equations->constants.begin(), equations->constants.end(),
                                         [](double constant) { return constant != 0.0; });
    if (equations->outputs.empty() && equations->is_isotropic && !has_sources) return {};
    auto part = std::make_shared<NonlinearPart>(std::move(equations), system, threads);
    return [part](double t, const Spectra& state, Spectra& rate) { (*part)(t, state, rate); };
}

}  // namespace drover::model
