// measure/model_fields.hpp: the observables of the fields of a declared model: the same for every field.
#pragma once
#include <string>
#include <vector>

#include "drover/measure/field_setting.hpp"
#include "drover/measure/observable.hpp"
#include "drover/measure/summary.hpp"
#include "drover/model/start.hpp"
#include "drover/numerics/field.hpp"

namespace drover::measure {

/// A field with a rate, as observables name it.
struct MeasuredField {
    std::string name, symbol, unit;
    int spin = 0;
    bool odd = false;
    int first = 0;            ///< its first component in a state
    bool is_density = false;  ///< a conserved scalar of positive mean, which is counted in boxes
};

/// What the observables of a run need, prepared once.
struct ModelSetting {
    FieldSetting grid;  ///< its shells, sectors, boxes and bins
    std::vector<MeasuredField> fields;
    std::vector<model::StateComponent> components;
};
/// watches_error: the run estimates the error of its time steps.
ModelSetting make_model_setting(const model::Equations& equations, const numerics::Grid& grid, int degree,
                                bool watches_error = false);

/// |a_q|^2 of each stored mode: of a scalar `along` alone; of a spin m its parts along and across q, cos(m theta) F_1 +
/// sin(m theta) F_2 and -sin(m theta) F_1 + cos(m theta) F_2, theta the angle of q.
struct FieldPowers {
    std::vector<double> along, across;
};

/// One moment of a run.  The powers are computed on construction, once for all observables.
struct ModelMoment {
    const ModelSetting& setting;
    const numerics::Spectra& spectra;
    const numerics::Fields& fields;
    double step_error = 0.0;  ///< as numerics::StepError estimates it
    std::vector<FieldPowers> powers = powers_of(setting, spectra);

    static std::vector<FieldPowers> powers_of(const ModelSetting& setting, const numerics::Spectra& spectra);
};

/// The observables: of every field its mean, extremes, variance, spectral tail, structure factors and correlation; of
/// densities the number fluctuations in boxes; of pairs of scalars the cross structure factors.
Observables<ModelMoment> model_observables(const ModelSetting& setting);

/// The recorded series with what their summary needs.
Recorded model_recording(const ModelSetting& setting, std::vector<RecordedSeries> series);

}  // namespace drover::measure
