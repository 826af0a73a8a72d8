// physics/function_terms.hpp: what messages say of terms: functions of the calling program, keys and tables.
#pragma once
#include <string>
#include <vector>

#include "physics/compiled_model.hpp"

namespace drover::physics {

/// "terms[1] is the Python function tilt, which this program does not have", of the first such term; "" if none.
std::string missing_function(const ModelValues& model);

/// Of each function: that it is slow, how exact its linearisation is, and whether its degree is known.
std::vector<std::string> function_remarks(const CompiledModel& compiled);

/// The key of the coefficient of a term of the model file, whether a scene has the term or not: "diffusion.rods" of
/// "lap sigma" in the equation of "sigma"; "": there is no such term.
std::string key_of_term(const std::string& symbol, const std::string& factor);

/// Values of a scalar between which a table has nodes; beyond, its outermost values are held.
struct HeldRange {
    std::string symbol;
    double min = 0.0, max = 0.0;
};
/// None of a table that refuses others.
std::vector<HeldRange> held_ranges(const TableData& table);

}  // namespace drover::physics
