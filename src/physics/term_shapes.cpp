// physics/term_shapes.cpp: what terms of one shape have in common.
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

Equation equation_of(const std::string& written) {
    if (written.starts_with("d_t rho")) return Equation::bead_density;
    if (written.starts_with("d_t sigma")) return Equation::rod_density;
    return written.starts_with("m rho") ? Equation::bead_velocity : Equation::polar_order;
}

/// "d_t p: K3 lap p, K3 = 0.5 mm^2/s".
std::string with_value(const char* equation, const CoefficientRow& row, const std::string& value) {
    return text("{}, {} = {} {}", equation, row.symbol, value, row.unit);
}
}  // namespace

void add_slopes(const Dependence& c, const Eigen::Vector2d& vector, double sign, int row, Symbol& m) {
    for (int i = 0; i < 2; ++i) {
        m(row + i, rho) += sign * c.by_beads * vector(i);
        m(row + i, sigma) += sign * c.by_rods * vector(i);
    }
}

void add_self_advection(double strength, const VectorStrip<const double>& v, const double* curl, std::size_t size,
                        const VectorStrip<double>& rate, double* potential) {
    for_points(size, [=](std::size_t i) {
        const double turning = strength * curl[i];
        rate.x[i] += turning * v.y[i];
        rate.y[i] -= turning * v.x[i];
        potential[i] -= 0.5 * strength * (v.x[i] * v.x[i] + v.y[i] * v.y[i]);
    });
}

bool is_of_velocity(int input) {
    if (input >= Input::velocity_grad_div) return input < Input::order_grad_div;
    if (input >= Input::velocity_curl) return input == Input::velocity_curl || input == Input::velocity_divergence;
    const int field = input % FieldIndex::count;
    return field == v_x || field == v_y;
}

std::uint64_t reads_of(const Coefficient& c) {
    return (c.depends_on_beads() ? reads(Input::bead_density) : 0) |
           (c.depends_on_rods() ? reads(Input::rod_density) : 0);
}

Term linear(const char* equation, const char* key, Operator operation) {
    const CoefficientRow& row = coefficient_row(key);
    return {.name = key,
            .of = equation_of(equation),
            .is_active =
                [&row](const CompiledModel& e) {
                    return has_fields(e.model.fields, row.needs) && row.value_in(e.model) != 0.0;
                },
            .equation =
                [equation, &row](const CompiledModel& e) {
                    return with_value(equation, row, text("{}", row.value_in(e.model)));
                },
            .linearise = [operation, &row](const CompiledModel& e, const UniformPoint&, const Wavevector& q,
                                           Symbol& m) { operation(row.value_in(e.model), q, m); }};
}

Term proportional(const char* equation, const char* key, double sign, int vector, int row_of) {
    const CoefficientRow& row = coefficient_row(key);
    const auto of = [&row](const CompiledModel& e) -> const Coefficient& { return e.*row.compiled; };
    const bool of_velocity = vector == v_x;
    const int output = row_of == v_x ? int{Output::force} : int{Output::order};
    return {.name = key,
            .of = equation_of(equation),
            .is_active =
                [of, &row](const CompiledModel& e) {
                    return has_fields(e.model.fields, row.needs) && of(e).is_active();
                },
            .equation = [equation, of,
                         &row](const CompiledModel& e) { return with_value(equation, row, of(e).text_of()); },
            .linearise =
                [of, sign, vector, row_of](const CompiledModel& e, const UniformPoint& about, const Wavevector&,
                                           Symbol& m) {
                    const Dependence c = of(e).at(about.bead_density, about.rod_density);
                    add_diagonal(sign * c.value, row_of, vector, m);
                    add_slopes(c, vector == v_x ? about.velocity : about.order, sign, row_of, m);
                },
            .cost =
                [of, of_velocity, vector, output](const CompiledModel& e, bool pointwise_velocity) {
                    const Coefficient& c = of(e);
                    // A slaved velocity divides by the drag as it is; its linear remainder needs no term.
                    const bool drag = of_velocity && output == Output::force;
                    if (drag && e.form.velocity != Velocity::dynamic) return PointCost{};
                    if (!c.varies() && !(of_velocity && pointwise_velocity)) return PointCost{};
                    return PointCost{.reads = reads_of(c) | (vector == v_x ? reads_velocity : reads_order),
                                     .writes = writes(output),
                                     .degree = 1 + c.degree()};
                },
            .remainder =
                [of, sign, of_velocity, output](const CompiledModel& e, const Reference& ref, const PointFields& f,
                                                const PointRates& r) {
                    const Coefficient& c = of(e);
                    const double at_reference = c.at(ref.bead_density, ref.rod_density).value;
                    const auto rate = r.vector(output);
                    if (of_velocity && output == Output::order) {
                        // The linear part has the linear velocity.
                        const auto v = f.velocity();
                        for_coefficient(c, 0.0, f, [&](std::size_t i, double value) {
                            rate.x[i] += value * v.x[i] - at_reference * f.linear_velocity.x[i];
                            rate.y[i] += value * v.y[i] - at_reference * f.linear_velocity.y[i];
                        });
                        return;
                    }
                    const auto u = of_velocity ? f.velocity() : f.order();
                    for_coefficient(c, at_reference, f, [&](std::size_t i, double value) {
                        rate.x[i] += sign * value * u.x[i];
                        rate.y[i] += sign * value * u.y[i];
                    });
                }};
}

Term product(const char* equation, const char* key, const PointCost& cost, ProductSymbol symbol, ProductAction action) {
    const CoefficientRow& row = coefficient_row(key);
    const auto constant = [&row](const CompiledModel& e) { return row.value_in(e.model); };
    return {.name = key,
            .of = equation_of(equation),
            .is_active =
                [constant, &row](const CompiledModel& e) {
                    return has_fields(e.model.fields, row.needs) && constant(e) != 0.0;
                },
            .equation = [equation, constant,
                         &row](const CompiledModel& e) { return with_value(equation, row, text("{}", constant(e))); },
            .linearise = [constant, symbol](const CompiledModel& e, const UniformPoint& about, const Wavevector& q,
                                            Symbol& m) { symbol(constant(e), about, q, m); },
            .cost = [cost](const CompiledModel&, bool) { return cost; },
            .remainder = [constant, action](const CompiledModel& e, const Reference&, const PointFields& f,
                                            const PointRates& r) { action(constant(e), f, r); }};
}

}  // namespace drover::physics
