// model/right_hand_side.cpp: fields to the grid, the functions at its points, and back.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "compiled.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/numerics/wavenumbers.hpp"

namespace drover::model {

namespace {
using numerics::Complex;
using numerics::Spectra;
using numerics::Wavevector;
constexpr std::size_t points_in_cache = 256;  // of some twenty arrays: the first-level cache

/// A sum of derivatives of arrays of modes: each array times even(q) + i odd(q), real polynomials in q.
class Derivatives {
public:
    void add(std::size_t array, const Order& order, double factor) {
        auto part = std::find_if(parts_.begin(), parts_.end(), [&](const Part& one) { return one.array == array; });
        if (part == parts_.end()) part = parts_.insert(part, Part{.array = array});
        const int n = order.x + order.y;
        const double signed_factor = n % 4 < 2 ? factor : -factor;
        if (n == 0) part->value += signed_factor;
        else if (n == 1) (order.x == 1 ? part->x : part->y) += signed_factor;
        else if (n == 2) (order.x == 2 ? part->xx : order.x == 1 ? part->xy : part->yy) += signed_factor;
        else part->higher.push_back({order, signed_factor});
    }
    bool is_empty() const { return parts_.empty(); }

    /// The sum at one mode.
    Complex at(std::size_t mode, std::span<const Complex* const> arrays, const Wavevector& q) const {
        double real = 0.0, imaginary = 0.0;
        for (const Part& part : parts_) {
            double even = part.value + q.x * (part.xx * q.x + part.xy * q.y) + part.yy * q.y * q.y;
            double odd = part.x * q.x + part.y * q.y;
            for (const Monomial& m : part.higher)
                ((m.order.x + m.order.y) % 2 == 0 ? even : odd) +=
                    m.factor * power(q.x, m.order.x) * power(q.y, m.order.y);
            const Complex field = arrays[part.array][mode];
            real += even * field.real() - odd * field.imag();
            imaginary += even * field.imag() + odd * field.real();
        }
        return {real, imaginary};
    }

private:
    struct Monomial {
        Order order;
        double factor;
    };
    struct Part {
        std::size_t array;
        double value = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;  ///< factors of these powers of q
        std::vector<Monomial> higher = {};
    };
    static double power(double base, int exponent) {
        double result = 1.0;
        for (int i = 0; i < exponent; ++i) result *= base;
        return result;
    }
    std::vector<Part> parts_;
};

/// The arrays that are transformed to the grid, and the functions of them.
struct Plan {
    std::vector<LinearForm> inputs;
    std::vector<Expression> values;  ///< of the outputs; slots: position, time, inputs
};

/// Replaces slots by expressions.
Expression substituted(const Expression& expression, const std::map<int, Expression>& by) {
    GraphBuilder graph(Folding::lenient);
    std::vector<int> here;
    for (const Node& node : expression.graph().nodes) {
        const auto at = [&](int there) { return there < 0 ? -1 : here[static_cast<std::size_t>(there)]; };
        if (node.operation == Operation::number) here.push_back(graph.number(node.value));
        else if (node.operation == Operation::slot) here.push_back(graph.import(by.at(node.left).graph()).back());
        else here.push_back(graph.make(node.operation, at(node.left), at(node.right)));
    }
    return graph.expression(here.back());
}
Expression slot_expression(int slot) {
    GraphBuilder graph(Folding::exact);
    return graph.expression(graph.slot(slot, text("input {}", slot)));
}

/// A basis of linear forms: each further form is a combination of earlier ones or extends it.
class Basis {
public:
    /// The coefficients of a form in the basis; extends the basis if there are none.
    std::vector<std::pair<std::size_t, double>> coefficients(const LinearForm& form) {
        LinearForm rest = form;
        std::map<std::size_t, double> of_members;
        for (const Reduced& row : reduced_) {
            const auto pivot = rest.find(row.pivot);
            if (pivot == rest.end()) continue;
            const double factor = pivot->second / row.form.at(row.pivot);
            for (const auto& [derivative, value] : row.form) {
                double& left = rest[derivative];
                left -= factor * value;
                if (std::abs(left) <= 1e-12 * std::abs(factor * value)) rest.erase(derivative);  // rounding
            }
            rest.erase(row.pivot);
            for (const auto& [member, value] : row.of_members) of_members[member] += factor * value;
        }
        if (!rest.empty()) {
            Reduced row{rest, rest.begin()->first, {}};
            for (const auto& [member, value] : of_members) row.of_members[member] = -value;
            row.of_members[members.size()] = 1.0;
            reduced_.push_back(row);
            of_members = {{members.size(), 1.0}};
            members.push_back(form);
        }
        return {of_members.begin(), of_members.end()};
    }
    std::vector<LinearForm> members;

private:
    struct Reduced {
        LinearForm form;
        Derivative pivot;
        std::map<std::size_t, double> of_members;
    };
    std::vector<Reduced> reduced_;
};

bool is_plain(const LinearForm& form) {
    return form.size() == 1 && form.begin()->first.order == Order{} && form.begin()->second == 1.0;
}

Plan plan_of(const CompiledEquations& c) {
    std::set<int> slots;
    for (const Output& output : c.outputs) slots.merge(slots_of(output.value));
    std::vector<int> atoms;
    for (const int slot : slots)
        if (slot >= first_atom) atoms.push_back(slot);
    const auto form_of = [&](int slot) -> const LinearForm& {
        return c.atoms[static_cast<std::size_t>(slot - first_atom)];
    };
    std::stable_sort(atoms.begin(), atoms.end(), [&](int a, int b) {
        const auto key = [&](int slot) {
            return is_plain(form_of(slot)) ? form_of(slot).begin()->first.component : c.components;
        };
        return key(a) < key(b);
    });
    Basis basis;
    std::map<int, Expression> by;
    for (const int slot : {slot_x, slot_y, slot_t}) by.emplace(slot, slot_expression(slot));
    for (const int slot : atoms) {
        Expression sum(0.0);
        for (const auto& [member, coefficient] : basis.coefficients(form_of(slot)))
            sum = sum + Expression(coefficient) * slot_expression(first_atom + static_cast<int>(member));
        by.emplace(slot, sum);
    }
    Plan plan{basis.members, {}};
    for (const Output& output : c.outputs) plan.values.push_back(substituted(output.value, by));
    return plan;
}

class NonlinearPart {
public:
    NonlinearPart(std::shared_ptr<const CompiledEquations> equations, const numerics::System& system,
                  Threads& the_threads)
        : c_(std::move(equations)),
          plan_(plan_of(*c_)),
          program_(plan_.values),
          grid_(system.grid),
          threads_(the_threads),
          transform_(grid_, system.degree, threads_),
          wavenumbers_(numerics::distinct_wavenumbers(grid_, system.degree)) {
        std::set<int> slots;
        for (const Expression& value : plan_.values) slots.merge(slots_of(value));
        reads_position_ = slots.count(slot_x) + slots.count(slot_y) > 0;
        int arrays = 0;
        held_.assign(static_cast<std::size_t>(c_->components), -1);
        for (const LinearForm& input : plan_.inputs) {
            for (const auto& [derivative, coefficient] : input)
                if (c_->in_balance(derivative.component) && held_[static_cast<std::size_t>(derivative.component)] < 0)
                    held_[static_cast<std::size_t>(derivative.component)] = arrays++;
            derived_.push_back(is_plain(input) ? -1 : arrays++);
            derivatives_.emplace_back();
            for (const auto& [derivative, coefficient] : input)
                derivatives_.back().add(static_cast<std::size_t>(derivative.component), derivative.order, coefficient);
        }
        for (const Output& output : c_->outputs)
            made_.push_back(output.uses.size() == 1 && output.uses[0].order == Order{} ? -1 : arrays++);
        sources_ = c_->sources(&held_means_);
        scratch_ = Spectra(grid_, arrays);
        for (const double q : wavenumbers_.q) {
            if (!c_->has_balance() && c_->is_isotropic) break;
            averaged_.push_back(c_->averaged(c_->linear, q));
            if (!c_->has_balance()) continue;
            balance_.emplace_back();
            static_cast<void>(c_->eliminated(averaged_.back(), &balance_.back()));
        }
    }

    void operator()(double t, const Spectra& state, Spectra& rate) {
        balance(state);
        derive_inputs(state);
        if (!c_->outputs.empty())
            transform_.products(sources(state), targets(rate),
                                [&](const numerics::Strip& strip) { at_points(t, strip); });
        assemble(state, rate);
    }

private:
    const Complex* field(const Spectra& state, int component) const {
        const int array = c_->array_of[static_cast<std::size_t>(component)];
        return array >= 0 ? state[array].data() : scratch_[held_[static_cast<std::size_t>(component)]].data();
    }
    template <class Body>
    void for_modes(Body body) const {
        numerics::for_kept_modes(grid_, wavenumbers_, threads_, body);
    }

    /// Deviations of a state at a mode in the frame of q, by components; and back.
    void turn(Eigen::VectorXcd& values, const Wavevector& q, double inverse, double sign) const {
        if (inverse == 0.0) return;
        const std::complex<double> unit(q.x * inverse, sign * q.y * inverse);
        for (int k = 0; k < c_->components; ++k) {
            const int spin = c_->spin_of(k);
            if (spin == 0) continue;
            std::complex<double> angle = unit;
            for (int i = 1; i < spin; ++i) angle *= unit;
            const Complex first = values(k), second = values(k + 1);
            values(k) = angle.real() * first + angle.imag() * second;
            values(k + 1) = angle.real() * second - angle.imag() * first;
            ++k;
        }
    }
    Eigen::VectorXcd values_of(const Spectra& state, std::size_t m) const {
        Eigen::VectorXcd values = Eigen::VectorXcd::Zero(c_->components);
        for (const int k : c_->state) values(k) = field(state, k)[m];
        return values;
    }

    /// Fields in balance that are inputs.
    void balance(const Spectra& state) {
        if (std::all_of(held_.begin(), held_.end(), [](int at) { return at < 0; })) return;
        for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
            Eigen::VectorXcd values = values_of(state, m);
            turn(values, q, wavenumbers_.inverse[n], 1.0);
            values = balance_[n] * values;
            turn(values, q, wavenumbers_.inverse[n], -1.0);
            for (int k = 0; k < c_->components; ++k)
                if (const int at = held_[static_cast<std::size_t>(k)]; at >= 0) scratch_[at][m] = values(k);
        });
        for (std::size_t k = 0; k < held_.size(); ++k)
            if (held_[k] >= 0) scratch_[held_[k]][0] += held_means_[k];
    }

    void derive_inputs(const Spectra& state) {
        std::vector<const Complex*> fields;
        for (int k = 0; k < c_->components; ++k) {
            const auto component = static_cast<std::size_t>(k);
            const bool is_there = c_->array_of[component] >= 0 || held_[component] >= 0;
            fields.push_back(is_there ? field(state, k) : nullptr);
        }
        for (std::size_t i = 0; i < plan_.inputs.size(); ++i)
            if (derived_[i] >= 0) write(derivatives_[i], fields, scratch_[derived_[i]].data(), false);
    }
    /// Writes, or adds, a sum of derivatives at every kept mode.
    void write(const Derivatives& sum, std::span<const Complex* const> arrays, Complex* to, bool adds) const {
        for_modes([&](std::size_t m, std::size_t, const Wavevector& q) {
            const Complex value = sum.at(m, arrays, q);
            to[m] = adds ? to[m] + value : value;
        });
    }
    std::vector<const Complex*> sources(const Spectra& state) const {
        std::vector<const Complex*> from;
        for (std::size_t i = 0; i < plan_.inputs.size(); ++i)
            from.push_back(derived_[i] >= 0 ? scratch_[derived_[i]].data()
                                            : field(state, plan_.inputs[i].begin()->first.component));
        return from;
    }
    /// Rates straight into `rate`, the others into the scratch.
    std::vector<Complex*> targets(Spectra& rate) {
        std::vector<Complex*> to;
        for (std::size_t k = 0; k < c_->outputs.size(); ++k)
            to.push_back(made_[k] >= 0
                             ? scratch_[made_[k]].data()
                             : rate[c_->array_of[static_cast<std::size_t>(c_->outputs[k].uses[0].component)]].data());
        return to;
    }

    /// A few points at a time: all that the functions need is then in the first-level cache.
    void at_points(double t, const numerics::Strip& strip) const {
        std::array<double, points_in_cache> x, y;
        std::vector<const double*> slots(first_atom + plan_.inputs.size(), nullptr);
        std::vector<double> uniform(slots.size(), 0.0);
        uniform[slot_t] = t;
        std::vector<double*> out(strip.out.size());
        for (std::size_t begin = 0; begin < strip.size; begin += points_in_cache) {
            const std::size_t size = std::min(points_in_cache, strip.size - begin);
            for (std::size_t i = 0; i < plan_.inputs.size(); ++i) slots[first_atom + i] = strip.in[i] + begin;
            for (std::size_t k = 0; k < out.size(); ++k) {
                out[k] = strip.out[k] + begin;
                std::fill_n(out[k], size, 0.0);
            }
            if (reads_position_) {
                const auto width = static_cast<std::size_t>(grid_.nx);
                for (std::size_t i = 0; i < size; ++i) {
                    x[i] = grid_.lx / grid_.nx * static_cast<double>((strip.first + begin + i) % width);
                    y[i] = grid_.ly / grid_.ny * static_cast<double>((strip.first + begin + i) / width);
                }
                slots[slot_x] = x.data();
                slots[slot_y] = y.data();
            }
            program_.add(size, slots, uniform, out);
        }
    }

    void assemble(const Spectra& state, Spectra& rate) const {
        std::vector<const Complex*> from;
        for (const int at : made_) from.push_back(at >= 0 ? scratch_[at].data() : nullptr);
        for (std::size_t array = 0; array < c_->state.size(); ++array) {
            const int component = c_->state[array];
            Complex* to = rate[static_cast<int>(array)].data();
            Derivatives sum;
            bool is_written = false;  // by the transforms
            for (std::size_t k = 0; k < c_->outputs.size(); ++k)
                for (const Output::Use& use : c_->outputs[k].uses) {
                    if (use.component != component) continue;
                    if (made_[k] < 0) is_written = true;
                    else sum.add(k, use.order, use.factor);
                }
            if (!is_written || !sum.is_empty()) write(sum, from, to, is_written);
            to[0] += sources_[static_cast<std::size_t>(component)];
            if (c_->model.fields[c_->field(component)].conserved) to[0] = 0.0;
        }
        if (!c_->is_isotropic) add_anisotropic(state, rate);
    }

    /// The linear parts that the propagator does not have.
    void add_anisotropic(const Spectra& state, Spectra& rate) const {
        for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
            const double inverse = wavenumbers_.inverse[n];
            const Eigen::VectorXcd values = values_of(state, m);
            Eigen::VectorXcd in_propagator = values;
            turn(in_propagator, q, inverse, 1.0);
            in_propagator = averaged_[n] * in_propagator;
            turn(in_propagator, q, inverse, -1.0);
            const Eigen::VectorXcd rates = c_->form_symbol(c_->linear, q) * values - in_propagator;
            for (std::size_t array = 0; array < c_->state.size(); ++array)
                rate[static_cast<int>(array)][m] += rates(c_->state[array]);
        });
    }

    std::shared_ptr<const CompiledEquations> c_;
    Plan plan_;
    StripProgram program_;
    numerics::Grid grid_;
    Threads& threads_;
    numerics::Transform transform_;
    numerics::DistinctWavenumbers wavenumbers_;
    bool reads_position_ = false;
    std::vector<int> held_, derived_, made_;  // arrays of the scratch, -1: none
    std::vector<Derivatives> derivatives_;    // of each input, by components
    Spectra scratch_;
    std::vector<double> sources_, held_means_;
    std::vector<Symbol> averaged_, balance_;  // of each |q|
};
}  // namespace

std::function<void(double, const Spectra&, Spectra&)> nonlinear_part(std::shared_ptr<const CompiledEquations> equations,
                                                                     const numerics::System& system, Threads& threads) {
    const bool has_sources = std::any_of(equations->constants.begin(), equations->constants.end(),
                                         [](double constant) { return constant != 0.0; });
    if (equations->outputs.empty() && equations->is_isotropic && !has_sources) return {};
    auto part = std::make_shared<NonlinearPart>(std::move(equations), system, threads);
    return [part](double t, const Spectra& state, Spectra& rate) { (*part)(t, state, rate); };
}

TransformCount transforms_of(const CompiledEquations& equations) {
    const Plan plan = plan_of(equations);
    return {static_cast<int>(plan.inputs.size()), static_cast<int>(plan.values.size())};
}

}  // namespace drover::model
