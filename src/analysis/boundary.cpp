// analysis/boundary.cpp: phase boundaries as a result.
#include "analysis/boundary.hpp"

#include "analysis/boundary_problem.hpp"

namespace drover::analysis {

namespace {
files::ResultTable map_table(const BoundaryProblem& problem, const DescribedPlane& plane, int side, Threads& threads) {
    const MapPoints map = map_points(plane, side);
    std::vector<std::vector<double>> values(problem.map.size(), std::vector<double>(map.points.size()));
    threads.for_chunks(map.points.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const std::vector<double> found = problem.map_at(map.points[n]);
            for (std::size_t k = 0; k < found.size(); ++k) values[k][n] = found[k];
        }
    });
    return {.group = {}, .axes = map.axes, .quantities = problem.map, .values = std::move(values)};
}
}  // namespace

void check_boundary(const io::Scene& scene) {
    // An axis that is missing may be given with the command.
    if (!scene.boundary.x.empty() && !scene.boundary.y.empty()) static_cast<void>(plan_boundary(scene));
}

run::Result make_boundary(const io::Scene& scene, Threads& threads, const BoundaryWork& work) {
    const PlannedBoundary planned = plan_boundary(scene);
    const BoundaryProblem problem = boundary_problem(scene, planned, work.quiet);
    const ComputeAll compute = work.compute ? work.compute : on_threads(threads);
    const DescribedPlane plane{.x = planned.x, .y = planned.y, .draws = problem.draws, .cells = scene.boundary.cells};
    const numerics::Rectangle rectangle{.x0 = plane.x.from, .x1 = plane.x.to, .y0 = plane.y.from, .y1 = plane.y.to};
    run::List traced{.name = "traced"};
    BandMaps bands(plane);
    bool complete = true;
    for (const PlaneLines& lines : problem.lines) {
        if (lines.binodals) {
            if (work.lines_alone) continue;
            const BinodalLines found = lines.binodals(threads);
            traced.rows.push_back(traced_record(plane, lines.described, found.boundary));
            traced.rows.back().footer = found.ends;
            continue;
        }
        const theory::PlaneMargins margins = lines.margins();
        const theory::Boundary boundary =
            theory::trace_boundary(rectangle, margins.at, margins.draws,
                                   {.cells = scene.boundary.cells, .chord = scene.boundary.chord}, compute);
        complete = complete && boundary.complete;
        traced.rows.push_back(traced_record(plane, lines.described, boundary));
        bands.add(lines.described, boundary);
    }
    run::Result result{.root = plane_record(plane, complete, std::move(traced)),
                       .attributes = {{"boundary_x", plane.x.name}, {"boundary_y", plane.y.name}}};
    bands.add_to(result.root);
    if (scene.boundary.map > 0 && !work.lines_alone)
        result.root.parts.push_back({"map",
                                     {.group = "/map",
                                      .maps = map_table(problem, plane, scene.boundary.map, threads),
                                      .shown = {.text = false}}});
    return result;
}

}  // namespace drover::analysis
