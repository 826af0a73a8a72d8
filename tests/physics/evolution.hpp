// tests/physics/evolution.hpp: a model on a grid, from fields given as functions of the place to fields at a later
// time.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "full_model.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics {

using FieldFunction = std::function<double(double x, double y)>;

/// On one thread, about the uniform densities of the model.
class Evolution {
public:
    Evolution(const Model& model, const numerics::Grid& the_grid)
        : grid(the_grid),
          form(physics::form(model)),
          threads(1),
          whole(whole_rate(Equations(model), grid, mean_densities(model), threads)),
          transform(grid, whole.system.degree, threads) {}

    /// The modes that the grid keeps of functions, one for each component.
    numerics::Spectra spectra(const std::vector<FieldFunction>& functions) const {
        const numerics::Fields cells = sampled(functions);
        numerics::Spectra state(grid, cells.count());
        transform.forward(cells, state);
        return state;
    }
    numerics::Fields sampled(const std::vector<FieldFunction>& functions) const {
        numerics::Fields cells(grid, static_cast<int>(functions.size()));
        for (int c = 0; c < cells.count(); ++c)
            for (std::size_t i = 0; i < cells.size; ++i)
                cells[c][i] = functions[static_cast<std::size_t>(c)](x(i), y(i));
        return cells;
    }
    numerics::Fields fields(const numerics::Spectra& state) const {
        numerics::Fields cells(grid, state.count());
        transform.backward(state, cells);
        return cells;
    }
    numerics::Stepper stepper(const std::string& method, double dt) {
        return {whole.system, numerics::stepper_table(method), dt, 1, threads};
    }
    /// From t = 0.
    void advance(numerics::Spectra& state, const std::string& method, double dt, int steps) {
        numerics::Stepper by = stepper(method, dt);
        for (int i = 0; i < steps; ++i) by.step(i * dt, static_cast<std::uint64_t>(i), state);
    }

    double x(std::size_t cell) const { return grid.lx / grid.nx * static_cast<double>(cell % width()); }
    double y(std::size_t cell) const { return grid.ly / grid.ny * static_cast<double>(cell / width()); }

    numerics::Grid grid;
    Form form;
    Threads threads;
    numerics::WholeRate whole;
    numerics::Transform transform;

private:
    std::size_t width() const { return static_cast<std::size_t>(grid.nx); }
};

/// The largest difference of any component in any cell.
inline double largest_difference(const numerics::Fields& a, const numerics::Fields& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.values.size(); ++i) largest = std::max(largest, std::abs(a.values[i] - b.values[i]));
    return largest;
}

}  // namespace drover::physics
