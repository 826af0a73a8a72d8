// measure/fields.hpp: the observables of fields.
#pragma once
#include <optional>

#include "drover/measure/field_setting.hpp"
#include "drover/measure/observable.hpp"
#include "drover/measure/summary.hpp"
#include "drover/numerics/field.hpp"
#include "drover/physics/energy.hpp"

namespace drover::measure {

inline constexpr int direction_sectors = 8;

/// |a_q|^2 of each stored mode [mm-4].  Along: the component of p along q; across: the component along q rotated by +90
/// degrees; at q = 0 along is x, across is y.  Empty for fields that the form does not have.
struct ModePowers {
    std::vector<double> rods, beads, order_along, order_across, velocity_along, velocity_across;
    std::vector<double> cross;       ///< Re(sigma_q^* i p_along,q): even in q, zero on average where sigma is conserved
    std::vector<double> beads_rods;  ///< Re(rho_q^* sigma_q)
};
ModePowers mode_powers(const FieldSetting& setting, const numerics::Spectra& spectra,
                       const numerics::Spectra* velocity = nullptr);

/// One moment of a run.  The powers are computed on construction, once for all observables.
struct FieldMoment {
    const FieldSetting& setting;
    const numerics::Spectra& spectra;
    const numerics::Fields& fields;
    const numerics::Spectra* velocity = nullptr;        ///< of the beads, two components; null when the form has none
    const numerics::Fields* slaved_velocity = nullptr;  ///< the same on the grid, where `fields` does not hold it
    std::optional<physics::EnergyBudget> energy = {};   ///< when it is measured
    double step_error = 0.0;                            ///< as numerics::StepError estimates it
    ModePowers powers = mode_powers(setting, spectra, velocity);
};

/// Whether a mode lies beyond two thirds of the cut of the grid on either axis: observables spectral_tail_*.
bool is_in_tail(const numerics::Grid& grid, int degree, std::size_t column, std::size_t row);

/// The observables of a form; those of the energy budget when the setting has terms.
Observables<FieldMoment> field_observables(const FieldSetting& setting);

/// The recorded series with what their summary needs.  The numbers of rods and beads are those of the first sample:
/// they are conserved, and a start from a file may have other means than the uniform state of the scene.
Recorded field_recording(const FieldSetting& setting, std::vector<RecordedSeries> series);

}  // namespace drover::measure
