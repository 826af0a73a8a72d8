// app/boundary_table.cpp: drover boundary TABLE.
#include "boundary_table.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "drover/io/calibration.hpp"
#include "drover/run/onset.hpp"

namespace drover::app {

namespace {
nlohmann::json crossing_json(const calibrate::Crossing& crossing) {
    return {{"bead_area_fraction", number_json(crossing.bead_fraction)},
            {"error", number_json(crossing.error)},
            {"share", crossing.share},
            {"above_all", crossing.above_all}};
}

nlohmann::json point_json(const calibrate::OnsetCurve& curve) {
    nlohmann::json result{{"rod_area_fraction", curve.rod_fraction}};
    for (const auto convention : {calibrate::Convention::mean, calibrate::Convention::single_rod})
        result[calibrate::convention_name(convention)] = crossing_json(curve.crossings[static_cast<int>(convention)]);
    return result;
}

nlohmann::json onset_json(const calibrate::Onset& onset) {
    nlohmann::json curves = nlohmann::json::array(), line = nlohmann::json::array();
    for (const calibrate::OnsetCurve& curve : onset.curves) {
        nlohmann::json one = point_json(curve);
        for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i)
            one["points"].push_back({{"bead_area_fraction", onset.bead_fractions[i]},
                                     {"drag", number_json(curve.drag[i].value)},
                                     {"drag_error", number_json(curve.drag[i].error)},
                                     {"threshold", number_json(curve.threshold[i].value)},
                                     {"threshold_error", number_json(curve.threshold[i].error)}});
        curves.push_back(std::move(one));
    }
    for (const calibrate::OnsetCurve& point : onset.line) line.push_back(point_json(point));
    return {{"curves", curves}, {"line", line}};
}
}  // namespace

int print_table_boundary(const TableBoundaryOptions& options) {
    const files::ArchiveReader archive(options.file);
    const calibrate::Table table = io::read_calibration(archive, options.file);
    const calibrate::Onset onset =
        calibrate::find_onset(table,
                              calibrate::varied_index(table, options.varied, "--varied", {.file = options.file}));
    if (!options.output.empty()) {
        const io::Scene scene = io::parse_scene(archive.text_attribute("scene"), options.file + " (its scene)");
        write_results(options.output, "onset", scene, 1, run::onset_tables(onset), {{"table", options.file}},
                      options.overwrite);
    }
    if (options.json) std::puts(onset_json(onset).dump(2).c_str());
    else std::fputs(run::onset_text(onset, table).c_str(), stdout);
    if (!options.json && !options.output.empty())
        std::printf("\n%s: curves and line, with errors\n", options.output.c_str());
    return run::exit_done;
}

}  // namespace drover::app
