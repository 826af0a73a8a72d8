// io/scene_calibrated.hpp: a scene of fields on a table of coefficients.
#pragma once
#include "io/scene.hpp"

namespace drover::io {

/// "drag.coefficient" of the line "drag.coefficient: measured, 3.1 +- 0.2" of calibrated.filled.
std::string filled_name(const std::string& line);

/// Gives the model those numbers of the table that the scene does not give itself, and notes them in calibrated.filled.
/// A scene that gives all of them, such as a resolved one, needs no file.  Throws an input Error at its place for a
/// table or a state that will not do.
void fill_from_table(Scene& scene);

}  // namespace drover::io
