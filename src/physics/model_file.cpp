// physics/model_file.cpp: what a scene chooses of rod_bead.toml.
#include "model_file.hpp"

#include "drover/base/error.hpp"

namespace drover::physics {

const std::string& current_of(const std::string& kind) {
    for (const auto& [known, formula] : rod_bead().currents)
        if (known == kind) return formula;
    fail_input({}, "current.kind = \"{}\"; expected one of those of the model file", kind);
}

std::string unit_of(const RodBead::Field& field, bool order_is_density) {
    if (field.unit != "[p]") return field.unit;
    return order_is_density ? "mm-2" : "1";
}

}  // namespace drover::physics
