// measure/model_fields.hpp: the observables of the fields of a declared model: the same for every field.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "drover/measure/field_setting.hpp"
#include "drover/measure/observable.hpp"
#include "drover/measure/summary.hpp"
#include "drover/model/start.hpp"
#include "drover/numerics/field.hpp"

namespace drover::measure {

/// A field, as observables name it.
struct MeasuredField {
    std::string name, symbol, unit;
    int spin = 0;
    bool odd = false;
    int first = 0;               ///< its first component: those of a state, then those in balance
    bool is_density = false;     ///< a conserved scalar of positive mean, which is counted in boxes
    bool is_solenoidal = false;  ///< has no part along q
};

/// What the observables of a run need, prepared once.
struct ModelSetting {
    FieldSetting grid;  ///< its shells, sectors, boxes and bins
    std::vector<MeasuredField> fields;
    std::vector<model::StateComponent> components;  ///< of a state, then those in balance
    int of_state = 0;                               ///< how many are those of a state
};
/// watches_error: the run estimates the error of its time steps.  with_balanced: fields in balance are measured, too.
ModelSetting make_model_setting(const model::Equations& equations, const numerics::Grid& grid, int degree,
                                bool watches_error = false, bool with_balanced = true);

/// |a_q|^2 of each stored mode: of a scalar `along` alone; of a spin m its parts along and across q, cos(m theta) F_1 +
/// sin(m theta) F_2 and -sin(m theta) F_1 + cos(m theta) F_2, theta the angle of q.
struct FieldPowers {
    std::vector<double> along, across;
};

/// One moment of a run.  The powers are computed on construction, once for all observables.
struct ModelMoment {
    const ModelSetting& setting;
    const numerics::Spectra& state;  ///< and on the grid:
    const numerics::Fields& state_on_grid;
    const numerics::Spectra& balanced;  ///< fields in balance, and on the grid:
    const numerics::Fields& balanced_on_grid;
    double step_error = 0.0;  ///< as numerics::StepError estimates it
    std::vector<FieldPowers> powers = powers_of(*this);

    std::span<const numerics::Complex> modes(int component) const {
        return component < state.count() ? state[component] : balanced[component - state.count()];
    }
    std::span<const double> points(int component) const {
        return component < state.count() ? state_on_grid[component] : balanced_on_grid[component - state.count()];
    }
    static std::vector<FieldPowers> powers_of(const ModelMoment& moment);
};

/// The observables: of every field its mean, extremes, variance, spectral tail, structure factors and correlation; of
/// densities the number fluctuations in boxes; of pairs of scalars the cross structure factors.
Observables<ModelMoment> model_observables(const ModelSetting& setting);

/// The recorded series with what their summary needs.
Recorded model_recording(const ModelSetting& setting, std::vector<RecordedSeries> series);

}  // namespace drover::measure
