// model/energy.cpp: power of each term: its rate times the derivative of the energy.
#include "model/energy.hpp"

#include <algorithm>
#include <deque>

#include "drover/numerics/transform.hpp"
#include "model/compiled.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/linear_operator.hpp"

namespace drover::model {

namespace {
using numerics::Complex;
using numerics::Spectra;

constexpr const char* no_energy = "none";

/// "psi" of the parts "psi_re" and "psi_im".
std::string name_of_whole(const Field& field) {
    return field.part == Part::whole ? field.name : field.name.substr(0, field.name.size() - 3);
}

/// Integral over the cell of the product of two fields.
double integral(const numerics::Grid& grid, std::span<const Complex> a, std::span<const Complex> b) {
    double sum = 0.0;
    for (std::size_t m = 0; m < a.size(); ++m)
        sum += numerics::mode_weight(grid, m % numerics::columns(grid)) *
               (a[m].real() * b[m].real() + a[m].imag() * b[m].imag());
    return numerics::area(grid) * sum;
}

/// A mass that varies, with its slopes by what it reads of the fields.
struct VaryingMass {
    VaryingMass(const CompiledEquations& equations, const Mass& mass);
    void find_calls(const Expression& expression);
    /// Values of the slots at a point, from those of position, time and atoms.
    void call(std::vector<double>& slots) const;

    const CompiledEquations& c;
    Expression value;
    std::vector<int> atoms;  ///< slots
    std::vector<Expression> slopes;
    std::vector<bool> is_called;
};

VaryingMass::VaryingMass(const CompiledEquations& equations, const Mass& mass)
    : c(equations), value(c.calls[mass.call].values[0]), is_called(c.calls.size(), false) {
    const std::string& symbol = c.model.fields[mass.field].symbol;
    for (const int slot : c.slots_read(value)) {
        require(slot != slot_t, mass.where,
                "the mass of {} depends on time, and its energy is measured; expected a mass of the fields, or "
                "output.powers = false",
                symbol);
        if (slot < first_atom) continue;
        atoms.push_back(slot);
        for (const auto& [derivative, coefficient] : c.form_of(slot))
            require(c.array_of[static_cast<std::size_t>(derivative.component)] >= 0, mass.where,
                    "the mass of {} depends on {}, which has no rate, and its energy is measured; expected a mass of "
                    "fields with a rate, or output.powers = false",
                    symbol, c.model.fields[c.field(derivative.component)].symbol);
    }
    for (const int slot : atoms) slopes.push_back(c.slope(value, slot, mass.where));
    find_calls(value);
    for (const Expression& slope : slopes) find_calls(slope);
}

void VaryingMass::find_calls(const Expression& expression) {
    for (const int slot : slots_of(expression))
        if (const Call* found = c.call_at(slot)) {
            is_called[static_cast<std::size_t>(found - c.calls.data())] = true;
            for (const Expression& argument : found->values) find_calls(argument);
        }
}

void VaryingMass::call(std::vector<double>& slots) const {
    for (std::size_t n = 0; n < c.calls.size(); ++n)
        if (is_called[n]) c.call(c.calls[n], true, slots);
}
}  // namespace

struct EnergyMeter::Work {
    Work(const Equations& whole, std::shared_ptr<const CompiledEquations> compiled, const numerics::Grid& on,
         int degree, Threads& threads)
        : c(std::move(compiled)),
          grid(on),
          energies(energies_of(whole)),
          transform(grid, whole.linear_system(grid, degree).degree, threads) {
        for (const std::size_t n : terms_with_power(whole))
            parts.emplace_back(whole.only(n).system(grid, threads, degree));
        for (const Mass& mass : c->masses)
            if (has_energy(mass.field)) masses.emplace(mass.field, VaryingMass(*c, mass));
    }

    bool has_energy(std::size_t field) const {
        return std::ranges::any_of(energies, [&](const Energy& one) { return std::ranges::count(one.fields, field); });
    }
    /// Adds the energy of a field, and its slopes in all components.
    void add(std::size_t field, double t, const Spectra& state, double& energy, Spectra& slopes) const;
    void add_varying(const VaryingMass& mass, std::size_t field, double t, const Spectra& state, double& energy,
                     Spectra& slopes) const;
    /// The modes of what a mass reads.
    void write_atom(int slot, const Spectra& state, std::span<Complex> to) const;
    /// What a slope in an atom is of slopes in the components.
    void add_slopes(int slot, std::span<const Complex> slope, Spectra& slopes) const;
    int array(std::size_t field) const { return c->array_of[static_cast<std::size_t>(c->first_component[field])]; }

    std::shared_ptr<const CompiledEquations> c;
    numerics::Grid grid;
    std::vector<Energy> energies;
    numerics::Transform transform;
    std::deque<numerics::WholeRate> parts;      // of one term each, and of the balances
    std::map<std::size_t, VaryingMass> masses;  // by field
};

void EnergyMeter::Work::add(std::size_t field, double t, const Spectra& state, double& energy, Spectra& slopes) const {
    if (const auto found = masses.find(field); found != masses.end())
        return add_varying(found->second, field, t, state, energy, slopes);
    const auto constant = c->constant_masses.find(field);
    const double mass = constant == c->constant_masses.end() ? 1.0 : constant->second;
    const int first = array(field);
    for (int k = first; k < first + components(c->model.fields[field]); ++k) {
        energy += 0.5 * mass * integral(grid, state[k], state[k]);
        for (std::size_t m = 0; m < state.size; ++m) slopes[k][m] += mass * state[k][m];
    }
}

void EnergyMeter::Work::write_atom(int slot, const Spectra& state, std::span<Complex> to) const {
    for (const auto& [derivative, coefficient] : c->form_of(slot)) {
        const auto from = state[c->array_of[static_cast<std::size_t>(derivative.component)]];
        for (std::size_t row = 0, m = 0; row < static_cast<std::size_t>(grid.ny); ++row)
            for (std::size_t column = 0; column < numerics::columns(grid); ++column, ++m)
                to[m] += coefficient * factor_of(derivative.order, numerics::wavevector(grid, column, row)) * from[m];
    }
}

/// Integrated by parts: the adjoint of i q is - i q.
void EnergyMeter::Work::add_slopes(int slot, std::span<const Complex> slope, Spectra& slopes) const {
    for (const auto& [derivative, coefficient] : c->form_of(slot)) {
        const auto to = slopes[c->array_of[static_cast<std::size_t>(derivative.component)]];
        for (std::size_t row = 0, m = 0; row < static_cast<std::size_t>(grid.ny); ++row)
            for (std::size_t column = 0; column < numerics::columns(grid); ++column, ++m)
                to[m] += coefficient * std::conj(factor_of(derivative.order, numerics::wavevector(grid, column, row))) *
                         slope[m];
    }
}

void EnergyMeter::Work::add_varying(const VaryingMass& mass, std::size_t field, double t, const Spectra& state,
                                    double& energy, Spectra& slopes) const {
    const int first = array(field), width = components(c->model.fields[field]);
    const int count = width + static_cast<int>(mass.atoms.size());
    Spectra read(grid, count), made_modes(grid, count);
    for (int k = 0; k < width; ++k) std::ranges::copy(state[first + k], read[k].begin());
    for (int a = width; a < count; ++a) write_atom(mass.atoms[static_cast<std::size_t>(a - width)], state, read[a]);
    numerics::Fields at(grid, count), made(grid, count);
    transform.backward(read, at);
    std::vector<double> slots(static_cast<std::size_t>(c->slots()), 0.0);
    slots[slot_t] = t;
    double sum = 0.0;
    for (std::size_t i = 0; i < at.size; ++i) {
        const auto nx = static_cast<std::size_t>(grid.nx);
        slots[slot_x] = grid.lx / grid.nx * static_cast<double>(i % nx);
        slots[slot_y] = grid.ly / grid.ny * static_cast<double>(i / nx);
        for (int a = width; a < count; ++a)
            slots[static_cast<std::size_t>(mass.atoms[static_cast<std::size_t>(a - width)])] = at[a][i];
        mass.call(slots);
        const double m = evaluate(mass.value, slots);
        double square = 0.0;
        for (int k = 0; k < width; ++k) {
            square += at[k][i] * at[k][i];
            made[k][i] = m * at[k][i];
        }
        sum += 0.5 * m * square;
        for (int a = width; a < count; ++a)
            made[a][i] = 0.5 * square * evaluate(mass.slopes[static_cast<std::size_t>(a - width)], slots);
    }
    energy += sum * numerics::area(grid) / static_cast<double>(at.size);
    transform.forward(made, made_modes);
    for (int k = 0; k < width; ++k)
        for (std::size_t m = 0; m < state.size; ++m) slopes[first + k][m] += made_modes[k][m];
    for (int a = width; a < count; ++a)
        add_slopes(mass.atoms[static_cast<std::size_t>(a - width)], made_modes[a], slopes);
}

std::vector<Energy> energies_of(const Equations& equations) {
    std::vector<Energy> result;
    for (const std::size_t n : drawn_fields(equations.model())) {
        const Field& field = equations.model().fields[n];
        if (field.left != LeftSide::rate || field.observed.energy == no_energy) continue;
        const bool follows = field.part == Part::imaginary && !result.empty();
        if (follows) result.back().fields.push_back(n);
        else result.push_back({field.observed.energy.empty() ? name_of_whole(field) : field.observed.energy, {n}});
    }
    return result;
}

std::vector<std::size_t> terms_with_power(const Equations& equations) {
    std::vector<std::size_t> result;
    for (std::size_t n = 0; n < equations.terms().size(); ++n)
        if (equations.model().fields[equations.terms()[n].field].left == LeftSide::rate) result.push_back(n);
    return result;
}

EnergyMeter::EnergyMeter(const Equations& equations, const numerics::Grid& grid, int kept_degree, Threads& threads)
    : work_(std::make_unique<Work>(equations, equations.compiled_, grid, kept_degree, threads)) {}
EnergyMeter::~EnergyMeter() = default;

EnergyBudget EnergyMeter::measure(double t, const Spectra& state) const {
    const Work& w = *work_;
    EnergyBudget budget;
    std::vector<Spectra> slopes;
    for (const Energy& energy : w.energies) {
        budget.energies.push_back(0.0);
        slopes.emplace_back(w.grid, state.count());
        for (const std::size_t field : energy.fields) w.add(field, t, state, budget.energies.back(), slopes.back());
    }
    budget.powers.resize(w.energies.size());
    Spectra rate(w.grid, state.count());
    for (const numerics::WholeRate& part : w.parts) {
        part.write(t, state, rate);
        for (std::size_t n = 0; n < slopes.size(); ++n) {
            double power = 0.0;
            for (int k = 0; k < state.count(); ++k) power += integral(w.grid, slopes[n][k], rate[k]);
            budget.powers[n].push_back(power);
        }
    }
    return budget;
}

}  // namespace drover::model
