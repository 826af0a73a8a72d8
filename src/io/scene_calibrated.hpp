// io/scene_calibrated.hpp: a scene of fields on a table of coefficients.
#pragma once
#include "io/scene.hpp"

namespace drover::io {

/// Gives the model those numbers of the table that the scene does not give itself, and notes them in Scene::found.
/// A scene that gives all of them, such as a resolved one, needs no file.  Throws an input Error at its place for a
/// table or a state that will not do.
void fill_from_table(Scene& scene);

}  // namespace drover::io
