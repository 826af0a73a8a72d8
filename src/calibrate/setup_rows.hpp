// calibrate/setup_rows.hpp: the rows of a table that follow from its setups alone.
#pragma once
#include <span>
#include <string>

#include "drover/dem/setup.hpp"

namespace drover::calibrate {

/// Numbers of a setup, from the integer numbers of bodies in the cell; zero if it has none.
struct SetupContent {
    double rods = 0.0, beads = 0.0, bead_mass_density = 0.0;  ///< per area of the cell
    double bead_mass = 0.0, bead_area = 0.0, rod_area = 0.0;  ///< of one body; of a rod without size tolerance
};

struct SetupRow {
    const char *name, *unit, *formula;
    bool by_rods, of_rods;  ///< whether it depends on the area fraction of rods; whether it describes rods
    double SetupContent::*number;
};
std::span<const SetupRow> setup_rows();

/// The number of a row.  Throws as dem::make_bodies().
double number_of(const SetupRow& row, const dem::Setup& setup);

/// Of the density of rods: that a whole number of them covers another part of the cell than was asked for, by more than
/// a fiftieth; "" where it does not.
std::string remark_on(const SetupRow& row, const dem::Setup& setup);

}  // namespace drover::calibrate
