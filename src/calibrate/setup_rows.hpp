// calibrate/setup_rows.hpp: the rows of a table that follow from its setups alone.
#pragma once
#include <string>
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::calibrate {

struct SetupRow {
    const char *name, *unit, *formula;
    bool by_rods, of_rods;  ///< whether it depends on the area fraction of rods; whether it describes rods
    double number;
    std::string remark = {};
};

/// Densities, masses and areas of the bodies of a setup, from their integer numbers in the cell; zero if it has none.
/// The density of rods has a remark where a whole number of them covers another part of the cell than was asked for, by
/// more than a fiftieth.  Throws as dem::make_bodies().
std::vector<SetupRow> setup_rows(const dem::Setup& setup);

}  // namespace drover::calibrate
