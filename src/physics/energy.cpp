// physics/energy.cpp: power of each term: its rate times the derivative of the energy.
#include "drover/physics/energy.hpp"

#include <algorithm>
#include <deque>

#include "drover/numerics/shells.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/whole_rate.hpp"

namespace drover::physics {

namespace {
using numerics::Spectra;

/// The rates by some terms, on the modes that the whole system keeps.
numerics::System system_of(const Equations& terms, const numerics::System& whole, Threads& threads) {
    model::Integrated what = integrated(terms, reference(terms.model.uniform));
    what.kept_degree = whole.degree;
    return model::system_of(what, whole.grid, threads);
}

/// Integral over the cell of the product of two fields.
double integral(const numerics::Grid& grid, std::span<const numerics::Complex> a,
                std::span<const numerics::Complex> b) {
    double sum = 0.0;
    for (std::size_t m = 0; m < a.size(); ++m)
        sum += numerics::mode_weight(grid, m % numerics::columns(grid)) *
               (a[m].real() * b[m].real() + a[m].imag() * b[m].imag());
    return numerics::area(grid) * sum;
}
}  // namespace

struct EnergyMeter::Work {
    Equations e;
    numerics::System whole;
    numerics::Transform transform;
    std::vector<std::string> names;
    std::deque<WholeRate> parts;

    Work(const Equations& equations, const numerics::Grid& grid, const Dealiasing& dealiasing, Threads& threads)
        : e(equations),
          whole(linear_system(equations, grid, reference(equations.model.uniform), dealiasing)),
          transform(grid, whole.degree, threads) {
        const bool slaved = e.form.velocity == Velocity::slaved;
        // A slaved velocity requires the complete force balance.
        std::vector<std::string> forces;
        for (std::size_t n = 0; n < e.terms().size(); ++n)
            if (slaved && e.is_force(n)) forces.push_back(e.terms()[n]);
        for (std::size_t n = 0; n < e.terms().size(); ++n) {
            if (slaved && e.is_force(n)) continue;
            std::vector<std::string> chosen = forces;
            chosen.push_back(e.terms()[n]);
            names.push_back(e.terms()[n]);
            parts.emplace_back(system_of(e.only(chosen), whole, threads));
        }
    }
    /// Slopes of the kinetic energy in rho and v; of the order it is p itself.
    void kinetic_slopes(const Spectra& state, double& energy, Spectra& slopes) const;
};

void EnergyMeter::Work::kinetic_slopes(const Spectra& state, double& energy, Spectra& slopes) const {
    const Form& form = e.form;
    numerics::Fields fields(whole.grid, state.count()), made(whole.grid, 3);
    transform.backward(state, fields);
    const auto vx = fields[form.bead_velocity], vy = fields[form.bead_velocity + 1];
    double sum = 0.0;
    for (std::size_t i = 0; i < fields.size; ++i) {
        const double rho = form.bead_density >= 0 ? fields[form.bead_density][i] : e.model.uniform.bead_density;
        const double moved = e.model.inertia.bead_mass * rho, square = vx[i] * vx[i] + vy[i] * vy[i];
        made[0][i] = 0.5 * e.model.inertia.bead_mass * square;
        made[1][i] = moved * vx[i];
        made[2][i] = moved * vy[i];
        sum += 0.5 * moved * square;
    }
    energy = sum * numerics::area(whole.grid) / static_cast<double>(fields.size);
    transform.forward(made, slopes);
}

EnergyMeter::EnergyMeter(const Equations& equations, const numerics::Grid& grid, const Dealiasing& dealiasing,
                         Threads& threads)
    : work_(std::make_unique<Work>(equations, grid, dealiasing, threads)) {}
EnergyMeter::~EnergyMeter() = default;

std::vector<std::string> EnergyMeter::terms() const { return work_->names; }

EnergyBudget EnergyMeter::measure(double t, const Spectra& state) const {
    Work& w = *work_;
    const Form& form = w.e.form;
    const numerics::Grid& grid = w.whole.grid;
    EnergyBudget budget;
    Spectra slopes(grid, 3), rate(grid, state.count());
    const bool moves = form.bead_velocity >= 0;
    if (moves) w.kinetic_slopes(state, budget.kinetic, slopes);
    for (int i = 0; i < 2; ++i)
        budget.order += 0.5 * integral(grid, state[form.polar_order + i], state[form.polar_order + i]);
    for (const WholeRate& part : w.parts) {
        part.write(t, state, rate);
        double kinetic = 0.0, order = 0.0;
        if (moves && form.bead_density >= 0) kinetic += integral(grid, slopes[0], rate[form.bead_density]);
        for (int i = 0; i < 2; ++i) {
            if (moves) kinetic += integral(grid, slopes[1 + i], rate[form.bead_velocity + i]);
            order += integral(grid, state[form.polar_order + i], rate[form.polar_order + i]);
        }
        budget.kinetic_powers.push_back(kinetic);
        budget.order_powers.push_back(order);
    }
    return budget;
}

}  // namespace drover::physics
