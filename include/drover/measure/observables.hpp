// measure/observables.hpp: what is measured on fields, each as one row: name, unit, axes, formula, function.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "drover/numerics/shells.hpp"
#include "drover/physics/energy.hpp"
#include "drover/physics/form.hpp"

namespace drover::measure {

inline constexpr int direction_sectors = 8;

/// All that observables need to know of a run, prepared once.
struct Setting {
    numerics::Grid grid;
    physics::Form form;
    numerics::Shells shells;
    numerics::Sectors sectors;
    std::vector<int> boxes;           ///< box sides, in cells: a box has as many cells along x as along y
    std::vector<int> long_boxes;      ///< shorter sides of the boxes that are four times longer one way, in cells
    int degree = 1;                   ///< of the products: which modes are kept
    std::vector<double> separations;  ///< mean distance in each bin of the pair correlation [mm]
    std::vector<int> separation_bin;  ///< of each grid point as a displacement, -1 for none
    std::vector<std::string> terms;   ///< whose powers are measured
};
Setting make_setting(const numerics::Grid& grid, const physics::Form& form, int degree,
                     std::vector<std::string> power_terms = {});

/// |a_q|^2 of each stored mode [mm-4].  Along: the part of p along q; across: the part along q turned by +90 degrees;
/// at q = 0 along is x, across is y.  Empty for fields that the form has not.
struct ModePowers {
    std::vector<double> rods, beads, order_along, order_across, velocity_along, velocity_across;
    std::vector<double> cross;       ///< Re(sigma_q^* i p_along,q): even in q, zero on average where sigma is conserved
    std::vector<double> beads_rods;  ///< Re(rho_q^* sigma_q)
};
ModePowers mode_powers(const Setting& setting, const numerics::Spectra& spectra,
                       const numerics::Spectra* velocity = nullptr);

/// One moment of a run.  The powers are computed when it is made, once for all observables.
struct Moment {
    const Setting& setting;
    const numerics::Spectra& spectra;
    const numerics::Fields& fields;
    const numerics::Spectra* velocity = nullptr;       ///< of the beads, two components; null when the form has none
    std::optional<physics::EnergyBudget> energy = {};  ///< when it is measured
    ModePowers powers = mode_powers(setting, spectra, velocity);
};

/// An axis of an observable.
enum class ObservableAxis { shell, sector, box, long_box, separation, term };
std::string name_of(ObservableAxis axis);
std::vector<std::string> names_of(std::span<const ObservableAxis> axes);

/// Boxes of one shape, by size: their results end in `ending`.
struct BoxFamily {
    const char* ending;
    const char* shape;  ///< for people
    ObservableAxis axis;
    std::vector<int> Setting::*sides;  ///< the shorter one, in cells
    int along_x, along_y;              ///< times that side
};
/// Squares; and boxes four times longer along x and along y, which tell the directions of a flock apart.
std::span<const BoxFamily> box_families();

struct Observable {
    std::string name;
    std::string unit;                                                          ///< UDUNITS text
    std::vector<ObservableAxis> axes;                                          ///< slowest first; none: a single number
    std::string formula;                                                       ///< what it is, for people
    std::function<void(const Moment& moment, std::span<double> out)> measure;  ///< out: size_of() numbers
};

/// The rows that a form can measure; with `energies`, those of the energy budget too.
std::vector<Observable> observables(const physics::Form& form, bool energies = false);

/// Numbers on an axis in a setting.
std::size_t size_of(ObservableAxis axis, const Setting& setting);

/// Numbers that an observable has in a setting: the product of its axes.
std::size_t size_of(const Observable& observable, const Setting& setting);

}  // namespace drover::measure
