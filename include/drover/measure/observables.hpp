// measure/observables.hpp: what is measured on fields, each as one row: name, unit, axes, formula, function.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "drover/numerics/shells.hpp"
#include "drover/physics/form.hpp"

namespace drover::measure {

inline constexpr int direction_sectors = 8;

/// All that observables need to know of a run, prepared once.
struct Setting {
    numerics::Grid grid;
    physics::Form form;
    numerics::Shells shells;
    numerics::Sectors sectors;
    std::vector<int> boxes;  ///< box sides, in cells: a box has as many cells along x as along y
};
Setting make_setting(const numerics::Grid& grid, const physics::Form& form, int degree);

/// |a_q|^2 of each stored mode [mm-4].  Along: the part of p along q; across: the part along q turned by +90 degrees;
/// at q = 0 along is x, across is y.  Empty for fields that the form has not.
struct ModePowers {
    std::vector<double> rods, order_along, order_across;
    std::vector<double> cross;  ///< Re(sigma_q^* i p_along,q): even in q, zero on average where sigma is conserved
};
ModePowers mode_powers(const Setting& setting, const numerics::Spectra& spectra);

/// One moment of a run.  The powers are computed when it is made, once for all observables.
struct Moment {
    const Setting& setting;
    const numerics::Spectra& spectra;
    const numerics::Fields& fields;
    ModePowers powers = mode_powers(setting, spectra);
};

/// An axis of an observable.
enum class ObservableAxis { shell, sector, box };

struct Observable {
    std::string name;
    std::string unit;                                                          ///< UDUNITS text
    std::vector<ObservableAxis> axes;                                          ///< slowest first; none: a single number
    std::string formula;                                                       ///< what it is, for people
    std::function<void(const Moment& moment, std::span<double> out)> measure;  ///< out: size_of() numbers
};

/// The rows that a form can measure.
std::vector<Observable> observables(const physics::Form& form);

/// Numbers on an axis in a setting.
std::size_t size_of(ObservableAxis axis, const Setting& setting);

/// Numbers that an observable has in a setting: the product of its axes.
std::size_t size_of(const Observable& observable, const Setting& setting);

}  // namespace drover::measure
