// physics/compiled_function.cpp: functions of the calling program at points, and their slopes by differences.
#include "compiled_function.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>

#include "drover/physics/function_terms.hpp"
#include "term_inputs.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

// What products of an unknown function count as: those of the equations have at most this degree.
constexpr int unknown_degree = 3;

/// A function with its arguments: slots of inputs, or parameters by their number behind Input::count.
struct Function {
    std::string name;  // terms[1], the Python function tilt
    TextTerm written;
    Equation of = Equation::polar_order;
    int row = p_x, output = Output::order;
    bool is_flux = false;
    std::vector<int> slots;       // of the arguments
    std::vector<double> numbers;  // values of those that are parameters
    double order_unit = 1.0;      // of complete order
    const Target* target = nullptr;

    bool reads_slot(int from, int to) const {
        return std::any_of(slots.begin(), slots.end(), [=](int slot) { return slot >= from && slot < to; });
    }
};

[[noreturn]] void fail_missing(const Function& f) {
    fail_input(f.written.where,
               "{}: this program does not have it; run the scene in Python with scene.term(\"{}\", {}), or write the "
               "term as text: value = [...]",
               f.name, f.written.of, f.written.function);
}

/// The names that arguments may have: "order_x", "d_x_order_x", "div_order".
std::map<std::string, int> argument_slots(const CompiledModel& model) {
    const Vocabulary names = vocabulary_of(model);
    std::map<std::string, int> slots(names.variables.begin(), names.variables.end());
    for (const auto& [operation, fields] : names.operators)
        for (const auto& [field, slot] : fields) slots.emplace(operation + "_" + field, slot);
    return slots;
}

Function read_function(const CompiledModel& model, const TextTerm& written, std::size_t number) {
    const Target& target = target_of(model, written);
    Function f{.name = text("terms[{}], the Python function {}", number, written.function),
               .written = written,
               .of = target.which,
               .row = target.row,
               .output = target.flux >= 0 ? target.flux : target.rate,
               .is_flux = target.flux >= 0,
               .slots = {},
               .numbers = {},
               .order_unit = model.form.order_is_density ? model.model.uniform.rod_density : 1.0,
               .target = &target};
    require(written.value.empty() && written.flux.empty(), written.where,
            "{} has a text too; expected either a function, or value or flux", f.name);
    const std::map<std::string, int> known = argument_slots(model);
    std::vector<std::string> names;
    for (const auto& [name, slot] : known) names.push_back(name);
    bool reads_field = false;
    for (const std::string& argument : written.arguments) {
        const auto found = known.find(argument);
        const std::string near = nearest_name(argument, names);
        require(
            found != known.end(), written.where,
            "{} has the argument {}; {}expected fields of the model (order_x, ...), their derivatives (d_x_order_x, "
            "lap_order_x, div_order, ...), x, y, t, or numbers given with the term",
            f.name, argument, near.empty() ? "" : text("did you mean {}? ", near));
        const auto parameter = model.model.parameters.find(argument);
        f.slots.push_back(found->second);
        f.numbers.push_back(found->second >= parameters_begin ? parameter->second : 0.0);
        reads_field = reads_field || found->second < position_begin;
    }
    require(reads_field, written.where,
            "{} has no field among its arguments; expected one or more, such as order_x, order_y", f.name);
    return f;
}

/// Values of the arguments at points, by slot.
using Inputs = std::array<const double*, Input::count>;

/// The two components at points, one after the other.
std::vector<double> values_of(const Function& f, std::size_t size, const Inputs& inputs, double time) {
    if (f.written.call == nullptr) fail_missing(f);
    std::vector<PointArgument> arguments;
    for (std::size_t a = 0; a < f.slots.size(); ++a) {
        const int slot = f.slots[a];
        if (slot < Input::t) arguments.push_back({.values = inputs[static_cast<std::size_t>(slot)]});
        else arguments.push_back({.number = slot == Input::t ? time : f.numbers[a]});
    }
    std::vector<double> out(2 * size, 0.0);
    const std::array<double*, 2> components{out.data(), out.data() + size};
    try {
        (*f.written.call)(size, arguments, components);
    } catch (const Error& error) {
        fail_input(f.written.where, "{}: {}", f.name, error.message());
    }
    return out;
}

/// "nan at order_x = 0.5, order_y = 0" of the first value that is not finite; "" if all are.
std::string not_finite(const Function& f, std::size_t size, const Inputs& inputs, const std::vector<double>& values) {
    const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
    if (bad == values.end()) return "";
    const std::size_t point = static_cast<std::size_t>(bad - values.begin()) % size;
    std::vector<std::string> at;
    for (std::size_t a = 0; a < f.slots.size(); ++a)
        if (f.slots[a] < Input::t)
            at.push_back(
                text("{} = {:.6g}", f.written.arguments[a], inputs[static_cast<std::size_t>(f.slots[a])][point]));
    return text("{} is {} at {}; expected finite numbers", f.name, *bad, joined(at));
}

/// Points about a state, with room for a value of every input.
struct Points {
    std::size_t size;
    std::array<std::vector<double>, Input::count> values;

    Points(std::size_t count, const UniformPoint& about) : size(count) {
        const auto uniform = slots_at(about);
        for (std::size_t i = 0; i < values.size(); ++i) values[i].assign(count, uniform[i]);
    }
    std::vector<double>& at(int input) { return values[static_cast<std::size_t>(input)]; }
    Inputs inputs() const {
        Inputs from{};
        for (std::size_t i = 0; i < from.size(); ++i) from[i] = values[i].data();
        return from;
    }
};

/// A change of an input that is neither small nor large.
double scale_of(const Function& f, int slot, const UniformPoint& about) {
    if (slot == Input::velocity_curl || slot == Input::velocity_divergence || slot == Input::velocity_grad_div ||
        slot == Input::velocity_grad_div + 1)
        return 1.0;
    if (slot >= Input::velocity_curl) return f.order_unit;  // derivatives of the order
    const int field = slot % FieldIndex::count;
    if (field == rho) return about.bead_density;
    if (field == sigma) return about.rod_density;
    return field >= p_x ? f.order_unit : 1.0;
}

struct Slopes {
    UniformPoint about;
    std::vector<std::array<double, 2>> of_argument;
    double error = 0.0;  // the largest, relative to the largest slope or to changes over a hundredth of the scale
    bool has_kink = false;
};

/// Of one component in one argument: the slope and its error, the size of slopes, and whether there is a kink.
struct Slope {
    double value = 0.0, error = INFINITY, size = 0.0;
    bool has_kink = false;
};

constexpr std::array difference_steps{1e-2, 1e-3, 1e-4, 1e-5};             // of the scale of the argument
constexpr std::array<double, 4> difference_offsets{1.0, -1.0, 0.5, -0.5};  // of each step
constexpr std::size_t differences = difference_steps.size() * difference_offsets.size();

/// Central differences at four steps, each extrapolated from two: error h^4, and rounding/h; the best step is taken.
Slope slope_of(const double* x, const double* f, double x0, double f0) {
    Slope slope{.size = std::max(std::abs(f[0] - f0), std::abs(f[1] - f0)) / std::abs(x[0] - x0)};
    for (std::size_t first = 0; first < differences; first += difference_offsets.size()) {
        const double *at = x + first, *v = f + first;
        const double wide = (v[0] - v[1]) / (at[0] - at[1]), near = (v[2] - v[3]) / (at[2] - at[3]);
        const double rounding = 1e-16 * (std::abs(v[0]) + std::abs(v[1])) / std::abs(at[2] - at[3]);
        const double found = (4.0 * near - wide) / 3.0, error = std::abs(found - near) + rounding;
        if (error < slope.error) {
            slope.error = error;
            slope.value = found;
        }
    }
    // The slopes to both sides differ by h f'' where the function is smooth.
    constexpr std::size_t last = differences - difference_offsets.size();
    const double right = (f[last] - f0) / (x[last] - x0), left = (f[last + 1] - f0) / (x[last + 1] - x0);
    slope.has_kink = std::abs(right - left) > 0.1 * slope.size;
    // An even function has no slope here but what differences leave.
    if (std::abs(slope.value) <= slope.error) slope.value = 0.0;
    return slope;
}

Slopes slopes_at(const Function& f, const UniformPoint& about) {
    const std::size_t centre = differences * f.slots.size();
    Points points(centre + 1, about);
    for (std::size_t a = 0; a < f.slots.size(); ++a) {
        if (f.slots[a] >= position_begin) continue;
        const double scale = scale_of(f, f.slots[a], about);
        for (std::size_t k = 0; k < differences; ++k)
            points.at(f.slots[a])[a * differences + k] += scale * difference_steps[k / difference_offsets.size()] *
                                                          difference_offsets[k % difference_offsets.size()];
    }
    const std::vector<double> values = values_of(f, points.size, points.inputs(), 0.0);
    if (const std::string bad = not_finite(f, points.size, points.inputs(), values); !bad.empty())
        fail_input(f.written.where, "{}", bad);
    Slopes slopes{.about = about, .of_argument = std::vector<std::array<double, 2>>(f.slots.size())};
    double size = 0.0;
    for (std::size_t a = 0; a < f.slots.size(); ++a) {
        if (f.slots[a] >= position_begin) continue;
        const std::vector<double>& x = points.at(f.slots[a]);
        for (std::size_t c = 0; c < 2; ++c) {
            const double* v = values.data() + c * points.size;
            const Slope found = slope_of(x.data() + a * differences, v + a * differences, x[centre], v[centre]);
            slopes.of_argument[a][c] = found.value;
            slopes.error = std::max(slopes.error, found.error);
            slopes.has_kink = slopes.has_kink || found.has_kink;
            size = std::max({size, found.size, std::abs(found.value)});
        }
    }
    slopes.error = size > 0.0 ? slopes.error / size : 0.0;
    return slopes;
}

/// The slopes about the last state: linear theory asks for many wavevectors about each.
class LastSlopes {
public:
    Slopes at(const Function& f, const UniformPoint& about) {
        {
            const std::lock_guard lock(mutex_);
            const auto same = [&](const UniformPoint& other) {
                return about.bead_density == other.bead_density && about.rod_density == other.rod_density &&
                       about.velocity == other.velocity && about.order == other.order;
            };
            if (last_ && same(last_->about)) return *last_;
        }
        Slopes found = slopes_at(f, about);  // without the lock: it calls the program
        const std::lock_guard lock(mutex_);
        last_ = found;
        return found;
    }

private:
    std::mutex mutex_;
    std::optional<Slopes> last_;
};

PointCost cost_of(const Function& f) {
    PointCost cost{.writes = writes(f.output),
                   .degree = f.written.degree > 0 ? f.written.degree : unknown_degree,
                   .has_finite_degree = f.written.degree > 0 && !f.reads_slot(Input::x, Input::t + 1)};
    for (const int slot : f.slots)
        if (slot < Input::count) cost.reads |= reads(slot);
    for (const std::uint64_t pair : {reads_velocity, reads_order})
        if (cost.reads & pair) cost.reads |= pair;
    return cost;
}

bool reads_any_velocity(const Function& f, int from) {
    return std::any_of(f.slots.begin(), f.slots.end(),
                       [from](int slot) { return slot >= from && slot < Input::x && is_of_velocity(slot); });
}

/// Points near the uniform state, the same each time.
Points probe_points(const Function& f, const UniformPoint& rest) {
    constexpr std::size_t count = 12;
    Points points(count, rest);
    double fraction = 0.5;
    for (const int slot : f.slots) {
        if (slot >= Input::t) continue;
        const double scale = slot < position_begin ? scale_of(f, slot, rest) : 1.0;
        const bool is_density = slot == rho || slot == sigma;
        for (double& value : points.at(slot)) {
            fraction = std::fmod(fraction + 0.6180339887498949, 1.0);  // evenly spread
            value += scale * (is_density ? 0.1 : 0.6) * (fraction - 0.5);
        }
    }
    return points;
}

/// The second call has other points, in another order: what a mean, a shift or a transform of the arrays would notice.
void check_pointwise(const Function& f, const UniformPoint& rest) {
    const Points all = probe_points(f, rest);
    const std::vector<double> values = values_of(f, all.size, all.inputs(), 0.0);
    if (const std::string bad = not_finite(f, all.size, all.inputs(), values); !bad.empty())
        fail_input(f.written.where, "{}", bad);
    Points some = all;
    some.size = all.size / 2;
    for (auto& array : some.values) std::reverse(array.begin(), array.begin() + static_cast<std::ptrdiff_t>(some.size));
    const std::vector<double> again = values_of(f, some.size, some.inputs(), 0.0);
    double largest = 0.0, wrong = 0.0;
    for (const double value : values) largest = std::max(largest, std::abs(value));
    for (std::size_t c = 0; c < 2; ++c)
        for (std::size_t i = 0; i < some.size; ++i)
            wrong = std::max(wrong, std::abs(again[c * some.size + i] - values[c * all.size + some.size - 1 - i]));
    require(
        wrong <= 1e-9 * largest, f.written.where,
        "{} gives other values at the same points in other arrays; expected a function of the values at each point: "
        "no means, shifts, transforms or random numbers (derivatives are arguments: d_x_order_x, lap_order_x, ...)",
        f.name);
}

/// Differences of order degree + 1 along a line through the fields vanish.
void check_degree(const Function& f, const UniformPoint& rest) {
    const int degree = f.written.degree;
    if (degree == 0) return;
    const Points probe = probe_points(f, rest);
    const auto count = static_cast<std::size_t>(degree) + 2;
    Points line(count, rest);
    for (const int slot : f.slots) {
        if (slot >= Input::t) continue;
        std::vector<double> ends = probe.values[static_cast<std::size_t>(slot)];
        for (std::size_t k = 0; k < count; ++k) {
            const double along = slot < position_begin ? static_cast<double>(k) / static_cast<double>(count - 1) : 0.0;
            line.at(slot)[k] = ends[0] + along * (ends[1] - ends[0]);
        }
    }
    const std::vector<double> values = values_of(f, count, line.inputs(), 0.0);
    for (std::size_t c = 0; c < 2; ++c) {
        double sum = 0.0, size = 0.0, factor = 1.0;
        for (std::size_t k = 0; k < count; ++k) {
            const double part = factor * values[c * count + k];
            sum += part;
            size += std::abs(part);
            factor *= -static_cast<double>(count - 1 - k) / static_cast<double>(k + 1);
        }
        require(std::abs(sum) <= 1e-10 * size, f.written.where,
                "{} is no polynomial of degree {} in its fields; expected its degree, or none: then products count as "
                "of degree {}, and aliases may remain",
                f.name, degree, unknown_degree);
    }
}
}  // namespace

Term compiled_function(const CompiledModel& model, const TextTerm& written, std::size_t number,
                       bool pointwise_velocity) {
    const Function f = read_function(model, written, number);
    check_admissible(model, written.where,
                     {.name = f.name,
                      .of = f.of,
                      .conserves = f.is_flux,
                      .reads_velocity = reads_any_velocity(f, 0),
                      .derives_velocity = reads_any_velocity(f, Input::d_x),
                      .is_linear = false},
                     pointwise_velocity);
    Term term{.name = text("terms[{}]", number), .of = f.of};
    std::string equation = text(f.is_flux ? "{}: -div of the Python function {}({}), linearised by differences"
                                          : "{}: the Python function {}({}), linearised by differences",
                                f.target->equation, written.function, joined(written.arguments));
    for (const std::string& name : written.parameters)
        equation += text(", {} = {}", name, model.model.parameters.at(name));
    term.equation = [equation](const CompiledModel&) { return equation; };
    term.linearise = [f, slopes = std::make_shared<LastSlopes>()](const CompiledModel&, const UniformPoint& about,
                                                                  const Wavevector& q, Symbol& m) {
        const Slopes found = slopes->at(f, about);
        for (std::size_t a = 0; a < f.slots.size(); ++a)
            for (std::size_t c = 0; c < 2; ++c)
                if (found.of_argument[a][c] != 0.0)
                    add_derivative(f.row, f.is_flux, c, found.of_argument[a][c], f.slots[a], q, m);
    };
    const bool placed = f.reads_slot(position_begin, Input::count);
    const bool slaved_force = model.form.velocity == Velocity::slaved && f.of == Equation::bead_velocity;
    term.linear_part = placed || slaved_force ? LinearPart::none : LinearPart::averaged;
    term.degree_in_q = f.is_flux && f.reads_slot(Input::laplacian, Input::x) ? 4 : 2;
    term.is_uniform_in_space = !placed;
    term.closed_uniform_states = false;
    term.cost = [cost = cost_of(f)](const CompiledModel&, bool) { return cost; };
    term.whole = [f](const CompiledModel&, const Reference&, const PointFields& fields, const PointRates& rates) {
        const std::vector<double> values = values_of(f, fields.size, fields.values, fields.time);
        if (const std::string bad = not_finite(f, fields.size, fields.values, values); !bad.empty())
            fail_run("{}", bad);
        for (int c = 0; c < 2; ++c) {
            double* rate = rates[f.output + c];
            const double* from = values.data() + static_cast<std::size_t>(c) * fields.size;
            for (std::size_t i = 0; i < fields.size; ++i) rate[i] += from[i];
        }
    };
    return term;
}

void check_functions(const CompiledModel& model) {
    const UniformPoint rest = at_rest(reference(model.model.uniform));
    for (std::size_t n = 0; n < model.model.text_terms.size(); ++n) {
        const TextTerm& written = model.model.text_terms[n];
        if (written.function.empty()) continue;
        const Function f = read_function(model, written, n + 1);
        check_pointwise(f, rest);
        check_degree(f, rest);
    }
}

std::string missing_function(const Model& model) {
    for (std::size_t n = 0; n < model.text_terms.size(); ++n)
        if (const TextTerm& term = model.text_terms[n]; !term.function.empty() && term.call == nullptr)
            return text("terms[{}] is the Python function {}, which this program does not have", n + 1, term.function);
    return "";
}

std::vector<std::string> function_remarks(const CompiledModel& compiled) {
    std::vector<std::string> remarks;
    const Model& model = compiled.model;
    for (std::size_t n = 0; n < model.text_terms.size(); ++n) {
        const TextTerm& term = model.text_terms[n];
        if (term.function.empty()) continue;
        const Slopes slopes = slopes_at(read_function(compiled, term, n + 1), at_rest(reference(model.uniform)));
        std::string remark =
            text("terms[{}] is the Python function {}: slow; linearised by differences, to {:.1g} of its slopes", n + 1,
                 term.function, std::max(slopes.error, 1e-15));
        if (slopes.has_kink || slopes.error > 1e-3)
            remark += " (it is not smooth at the uniform state: its growth rates are uncertain)";
        if (term.degree == 0)
            remark += text(
                "; its degree is not known, so products count as of degree {}, and aliases may remain (see "
                "spectral_tail): give degree= if it is a polynomial",
                unknown_degree);
        remarks.push_back(remark);
    }
    return remarks;
}

}  // namespace drover::physics
