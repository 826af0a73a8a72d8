// app/boundary_table.hpp: drover boundary of a table of coefficients in place of a scene.
#pragma once
#include <optional>
#include <string>

#include "command.hpp"

namespace drover::app {

struct TableBoundaryOptions {
    std::string file, output;
    std::optional<double> varied;
    bool json = false, overwrite = false;
};
int print_table_boundary(const TableBoundaryOptions& options);

}  // namespace drover::app
