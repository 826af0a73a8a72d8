// physics/program_functions.cpp: functions of the calling program at points, and their slopes by differences.
#include "physics/program_functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/mapped.hpp"

namespace drover::physics {

namespace {
// What products of an unknown function count as: those of the equations have at most this degree.
constexpr int unknown_degree = 3;

[[noreturn]] void fail_missing(const ProgramFunction& f) {
    fail_input(f.written.where,
               "{}: this program does not have it; run the scene in Python with scene.term(\"{}\", {}), or write the "
               "term as text: value = [...]",
               f.name, f.written.of, f.written.function);
}

using Argument = ProgramFunction::Argument;

/// A size of a field or its derivative: the mean of a density, also of the order where it is one.
double scale_of_name(const ModelValues& model, const std::string& name) {
    const ModelFile& file = *model.file;
    for (const FieldRow& field : file.fields) {
        if (name.find(field.alias) == std::string::npos) continue;
        if (!field.reference.empty()) return number(model, field.reference);
        for (const FieldRow* density : densities(file))
            if (field.unit == "[p]" && order_is_density(model) && density->symbol == file.order.density)
                return number(model, density->reference);
    }
    return 1.0;
}

/// The two components at points, one after the other.
std::vector<double> values_of(const ProgramFunction& f, std::size_t size, std::span<const PointArgument> arguments) {
    if (f.written.call == nullptr) fail_missing(f);
    // A function written for arrays gets them also in a uniform state, where a field is one number.
    std::vector<PointArgument> given(arguments.begin(), arguments.end());
    std::vector<std::vector<double>> uniform(given.size());
    for (std::size_t a = 0; a < given.size(); ++a)
        if (given[a].values == nullptr && f.arguments[a].kind == Argument::Kind::field) {
            uniform[a].assign(size, given[a].number);
            given[a].values = uniform[a].data();
        }
    std::vector<double> out(2 * size, 0.0);
    const std::array<double*, 2> components{out.data(), out.data() + size};
    try {
        (*f.written.call)(size, given, components);
    } catch (const Error& error) {
        fail_input(f.written.where, "{}: {}", f.name, error.message());
    }
    return out;
}

/// "nan at order_x = 0.5, order_y = 0" of the first value that is not finite; "" if all are.
std::string not_finite(const ProgramFunction& f, std::size_t size, std::span<const PointArgument> arguments,
                       const std::vector<double>& values) {
    const auto bad = std::ranges::find_if(values, [](double v) { return !std::isfinite(v); });
    if (bad == values.end()) return "";
    const std::size_t point = static_cast<std::size_t>(bad - values.begin()) % size;
    std::vector<std::string> at;
    for (std::size_t a = 0; a < arguments.size(); ++a)
        if (const PointArgument& one = arguments[a]; one.values || f.arguments[a].kind == Argument::Kind::field)
            at.push_back(text("{} = {:.6g}", f.written.arguments[a], one.values ? one.values[point] : one.number));
    return text("{} is {} at {}; expected finite numbers", f.name, *bad, joined(at));
}

/// Values of the arguments at points about some.
struct Points {
    std::size_t size;
    std::vector<std::vector<double>> values;

    Points(std::size_t count, std::span<const double> about) : size(count) {
        for (const double value : about) values.emplace_back(count, value);
    }
    std::vector<PointArgument> arguments(const ProgramFunction& f) const {
        std::vector<PointArgument> result;
        for (std::size_t a = 0; a < values.size(); ++a)
            if (f.arguments[a].kind == Argument::Kind::number) result.push_back({.number = values[a][0]});
            else result.push_back({.values = values[a].data()});
        return result;
    }
};

/// Throws an input Error where one is not finite.
std::vector<double> finite_values_of(const ProgramFunction& f, const Points& points) {
    const std::vector<PointArgument> arguments = points.arguments(f);
    const std::vector<double> values = values_of(f, points.size, arguments);
    if (const std::string bad = not_finite(f, points.size, arguments, values); !bad.empty())
        fail_input(f.written.where, "{}", bad);
    return values;
}

/// The arguments in the uniform state.
std::vector<double> at_rest_of(const ProgramFunction& f) { return mapped(f.arguments, &Argument::value); }

/// A change of an argument that is neither small nor large.
double scale_of(const Argument& argument, double value) {
    return argument.is_density && value != 0.0 ? std::abs(value) : argument.scale;
}

struct Slopes {
    std::vector<double> of_argument;  ///< [component][argument]
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

Slopes slopes_at(const ProgramFunction& f, std::span<const double> about) {
    const std::size_t count = f.arguments.size(), centre = differences * count;
    Points points(centre + 1, about);
    for (std::size_t a = 0; a < count; ++a) {
        if (f.arguments[a].kind != Argument::Kind::field) continue;
        for (std::size_t k = 0; k < differences; ++k)
            points.values[a][a * differences + k] += scale_of(f.arguments[a], about[a]) *
                                                     difference_steps[k / difference_offsets.size()] *
                                                     difference_offsets[k % difference_offsets.size()];
    }
    const std::vector<double> values = finite_values_of(f, points);
    Slopes slopes{.of_argument = std::vector<double>(2 * count)};
    double size = 0.0;
    for (std::size_t a = 0; a < count; ++a) {
        if (f.arguments[a].kind != Argument::Kind::field) continue;
        const std::vector<double>& x = points.values[a];
        for (std::size_t c = 0; c < 2; ++c) {
            const double* v = values.data() + c * points.size;
            const Slope found = slope_of(x.data() + a * differences, v + a * differences, x[centre], v[centre]);
            slopes.of_argument[c * count + a] = found.value;
            slopes.error = std::max(slopes.error, found.error);
            slopes.has_kink = slopes.has_kink || found.has_kink;
            size = std::max({size, found.size, std::abs(found.value)});
        }
    }
    slopes.error = size > 0.0 ? slopes.error / size : 0.0;
    return slopes;
}

/// Points near the uniform state, the same each time.
Points probe_points(const ProgramFunction& f) {
    constexpr std::size_t count = 12;
    Points points(count, at_rest_of(f));
    double fraction = 0.5;
    for (std::size_t a = 0; a < f.arguments.size(); ++a) {
        const Argument& argument = f.arguments[a];
        if (argument.kind == Argument::Kind::number) continue;
        for (double& value : points.values[a]) {
            fraction = std::fmod(fraction + 0.6180339887498949, 1.0);  // evenly spread
            value += scale_of(argument, argument.value) * (argument.is_density ? 0.1 : 0.6) * (fraction - 0.5);
        }
    }
    return points;
}

/// The second call has other points, in another order: what a mean, a shift or a transform of the arrays would notice.
void check_pointwise(const ProgramFunction& f) {
    const Points all = probe_points(f);
    const std::vector<double> values = finite_values_of(f, all);
    Points some = all;
    some.size = all.size / 2;
    for (auto& array : some.values) std::reverse(array.begin(), array.begin() + static_cast<std::ptrdiff_t>(some.size));
    const std::vector<double> again = values_of(f, some.size, some.arguments(f));
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
void check_degree(const ProgramFunction& f) {
    const int degree = f.written.degree;
    if (degree == 0) return;
    const Points probe = probe_points(f);
    const auto count = static_cast<std::size_t>(degree) + 2;
    Points line(count, at_rest_of(f));
    for (std::size_t a = 0; a < f.arguments.size(); ++a) {
        if (f.arguments[a].kind == Argument::Kind::number) continue;
        const std::vector<double>& ends = probe.values[a];
        for (std::size_t k = 0; k < count; ++k) {
            const double along = f.arguments[a].kind == Argument::Kind::field
                                     ? static_cast<double>(k) / static_cast<double>(count - 1)
                                     : 0.0;
            line.values[a][k] = ends[0] + along * (ends[1] - ends[0]);
        }
    }
    const std::vector<double> values = values_of(f, count, line.arguments(f));
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

std::map<std::string, std::string> text_names(const ModelValues& model) {
    std::map<std::string, std::string> names;
    for (const FieldRow& field : model.file->fields) {
        if (presence(model, field) == Presence::absent) continue;
        names[field.alias] = field.symbol;
        if (field.spin == 0) continue;
        for (const char* part : {"_x", "_y"}) names[field.alias + part] = field.symbol + part;
    }
    return names;
}

std::map<std::string, std::string> argument_names(const ModelValues& model) {
    std::map<std::string, std::string> names;
    const std::map<std::string, std::string> fields = text_names(model);
    for (const auto& [name, formula] : fields) {
        const bool is_vector = fields.count(name + "_x") > 0;
        if (!is_vector) names[name] = formula;
        for (const char* operation : {"d_x", "d_y", "lap"})
            if (!is_vector) names[text("{}_{}", operation, name)] = text("{} {}", operation, formula);
        for (const char* operation : {"div", "curl"})
            if (is_vector) names[text("{}_{}", operation, name)] = text("{} {}", operation, formula);
        for (const char* axis : {"x", "y"})
            if (is_vector) names[text("grad_div_{}_{}", axis, name)] = text("d_{} div {}", axis, formula);
    }
    return names;
}

ProgramFunction program_function(const CompiledModel& model, const TextTerm& written, std::size_t number) {
    ProgramFunction f{.name = text("terms[{}], the Python function {}", number, written.function), .written = written};
    require(written.value.empty() && written.flux.empty(), written.where,
            "{} has a text too; expected either a function, or value or flux", f.name);
    const std::map<std::string, std::string> fields = argument_names(model.model);
    std::vector<std::string> names{"t", "x", "y"};
    for (const auto& [name, formula] : fields) names.push_back(name);
    for (const auto& [name, value] : model.model.parameters) names.push_back(name);
    for (const std::string& name : written.arguments) {
        Argument argument;
        if (const auto found = model.model.parameters.find(name); found != model.model.parameters.end())
            argument = {.kind = Argument::Kind::number, .value = found->second};
        else if (name == "t") argument = {.kind = Argument::Kind::number};
        else if (name == "x" || name == "y") argument = {.kind = Argument::Kind::position};
        else
            require(fields.count(name) > 0, written.where,
                    "{} has the argument {}; {}expected fields of the model (order_x, ...), their derivatives "
                    "(d_x_order_x, lap_order_x, div_order, ...), x, y, t, or numbers given with the term",
                    f.name, name, suggestion(name, names, "", "did you mean {}? "));
        if (argument.kind == Argument::Kind::field) {
            argument.scale = scale_of_name(model.model, name);
            const std::vector<const FieldRow*> means = densities(*model.model.file);
            argument.is_density =
                std::ranges::any_of(means, [&](const FieldRow* field) { return field->alias == name; });
            if (argument.is_density) argument.value = argument.scale;
        }
        f.arguments.push_back(argument);
    }
    require(std::ranges::any_of(f.arguments, [](const Argument& a) { return a.kind == Argument::Kind::field; }),
            written.where, "{} has no field among its arguments; expected one or more, such as order_x, order_y",
            f.name);
    return f;
}

model::GivenFunction given_function(const ProgramFunction& f) {
    const int degree = f.written.degree;
    model::GivenFunction result{.arguments = static_cast<int>(f.arguments.size()),
                                .results = 2,
                                .degree = degree > 0 ? degree : unknown_degree,
                                .has_finite_degree = degree > 0,
                                .has_exact_slopes = false};
    result.values = [f](std::size_t size, std::span<const PointArgument> arguments, std::span<double* const> out) {
        if (f.written.call == nullptr) {  // readers of archives need the other terms; see missing_function()
            for (double* const component : out) std::fill_n(component, size, NAN);
            return;
        }
        const std::vector<double> values = values_of(f, size, arguments);
        if (const std::string bad = not_finite(f, size, arguments, values); !bad.empty()) fail_run("{}", bad);
        for (std::size_t c = 0; c < 2; ++c) std::copy_n(values.data() + c * size, size, out[c]);
    };
    result.slopes = [f](std::span<const double> arguments) {
        if (f.written.call == nullptr) return std::vector<double>(2 * arguments.size(), NAN);
        return slopes_at(f, arguments).of_argument;
    };
    return result;
}

void require_functions(const ModelValues& model) {
    for (std::size_t n = 0; n < model.text_terms.size(); ++n) {
        const TextTerm& term = model.text_terms[n];
        if (term.function.empty() || term.call != nullptr) continue;
        fail_missing({.name = text("terms[{}], the Python function {}", n + 1, term.function), .written = term});
    }
}

void check_functions(const CompiledModel& model) {
    for (std::size_t n = 0; n < model.model.text_terms.size(); ++n) {
        const TextTerm& written = model.model.text_terms[n];
        if (written.function.empty()) continue;
        const ProgramFunction f = program_function(model, written, n + 1);
        check_pointwise(f);
        check_degree(f);
    }
}

std::string missing_function(const ModelValues& model) {
    for (std::size_t n = 0; n < model.text_terms.size(); ++n)
        if (const TextTerm& term = model.text_terms[n]; !term.function.empty() && term.call == nullptr)
            return text("terms[{}] is the Python function {}, which this program does not have", n + 1, term.function);
    return "";
}

std::vector<std::string> function_remarks(const CompiledModel& compiled) {
    std::vector<std::string> remarks;
    const ModelValues& model = compiled.model;
    for (std::size_t n = 0; n < model.text_terms.size(); ++n) {
        const TextTerm& term = model.text_terms[n];
        if (term.function.empty()) continue;
        const ProgramFunction f = program_function(compiled, term, n + 1);
        const Slopes slopes = slopes_at(f, at_rest_of(f));
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
