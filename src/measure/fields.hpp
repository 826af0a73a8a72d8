// measure/fields.hpp: the observables of fields: the same for every field, and those of bodies that fields describe.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "drover/numerics/field.hpp"
#include "measure/field_setting.hpp"
#include "measure/observable.hpp"
#include "measure/summary.hpp"
#include "model/energy.hpp"

namespace drover::measure {

inline constexpr int direction_sectors = 8;

/// |a_q|^2 of each stored mode: of a scalar `along` alone; of a spin m its parts along and across q, cos(m theta) F_1 +
/// sin(m theta) F_2 and -sin(m theta) F_1 + cos(m theta) F_2, theta the angle of q, 0 at q = 0.
struct FieldPowers {
    std::vector<double> along, across;
    std::vector<double> sum;            ///< of both
    double variance = 0.0, tail = 0.0;  ///< over the cell; tail: in the outer third of the kept modes
};

/// One moment of a run.  The powers are computed on construction, once for all observables.
struct FieldMoment {
    const FieldSetting& setting;
    const numerics::Spectra& state;  ///< and on the grid:
    const numerics::Fields& state_on_grid;
    const numerics::Spectra& balanced;  ///< fields in balance, and on the grid:
    const numerics::Fields& balanced_on_grid;
    std::optional<model::EnergyBudget> energy = {};  ///< when it is measured
    double step_error = 0.0;                         ///< as numerics::StepError estimates it
    std::vector<FieldPowers> powers = powers_of(*this);

    std::span<const numerics::Complex> modes(int component) const {
        return component < state.count() ? state[component] : balanced[component - state.count()];
    }
    std::span<const double> points(int component) const {
        return component < state.count() ? state_on_grid[component] : balanced_on_grid[component - state.count()];
    }
    static std::vector<FieldPowers> powers_of(const FieldMoment& moment);
};

/// Whether a mode lies beyond two thirds of the cut of the grid on either axis: observables spectral_tail_*.
bool is_in_tail(const numerics::Grid& grid, int degree, std::size_t column, std::size_t row);
/// The part of the variance of `count` components that is in these waves; 0 where they do not vary.
double tail_of(const numerics::Grid& grid, int degree, const numerics::Spectra& state, int first, int count);

/// The observables: of every field its mean, extremes, variance, spectral tail, structure factors and correlation; of
/// densities the number fluctuations in boxes; of pairs of scalars the cross structure factors; of bodies their order
/// and flow; those of the energy budget when the setting has terms.
Observables<FieldMoment> field_observables(const FieldSetting& setting);

/// The recorded series with what their summary needs.  Numbers of bodies are those of the first sample: they are
/// conserved, and a start from a file may have other means than the uniform state of the scene.
Recorded field_recording(const FieldSetting& setting, std::vector<RecordedSeries> series);

}  // namespace drover::measure
