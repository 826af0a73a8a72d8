// run/result_json.hpp: a result as JSON.  Numbers that are not finite become null.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "run/result.hpp"

namespace drover::run {

/// A number, or null when it is not finite.
nlohmann::json number_json(double value);

nlohmann::json result_json(const Result& result);

}  // namespace drover::run
