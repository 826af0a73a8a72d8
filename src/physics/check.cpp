// physics/check.cpp: numbers, functions of the calling program, and terms.
#include "physics/check.hpp"

#include "physics/compiled_terms.hpp"
#include "physics/program_functions.hpp"
#include "physics/written_model.hpp"

namespace drover::physics {

void check(const ModelValues& model, const LocationOf& location_of) {
    check_numbers(model, location_of);
    const CompiledModel compiled(model);
    check_functions(compiled);
    const WrittenModel written = write_model(compiled, Written::right_sides, nullptr);
    const model::Equations right_sides(written.model);
    check_terms({.model = compiled, .right_sides = right_sides, .names = written.terms}, location_of);
    static_cast<void>(model::Equations(write_model(compiled, Written::solver, nullptr).model));
}

}  // namespace drover::physics
