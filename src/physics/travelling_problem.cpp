// physics/travelling_problem.cpp: the systems of a family of rod-bead models.
#include "drover/physics/travelling_problem.hpp"

#include "drover/physics/whole_rate.hpp"

namespace drover::physics {

numerics::TravellingFamily travelling_family(const TravellingProblem& problem, Threads& threads) {
    return {
        .system =
            [problem, &threads](double parameter) {
                Model model = problem.model(parameter);
                model.noise = {};
                const Equations equations(model);
                require(nonuniform_term(equations).empty(), {},
                        "the term {} depends on position or time; expected terms without: a travelling state has none",
                        nonuniform_term(equations));
                return WholeRate(equations, problem.grid, reference(model.uniform), threads, problem.dealiasing).system;
            },
        .mean =
            [problem](double parameter, int component) {
                const Model model = problem.model(parameter);
                return component == form(model).bead_density ? model.uniform.bead_density : model.uniform.rod_density;
            },
        .parameter = problem.parameter};
}

}  // namespace drover::physics
