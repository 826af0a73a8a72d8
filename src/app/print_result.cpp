// app/print_result.cpp: a result as text or JSON, and as an archive.
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "report/json.hpp"
#include "report/write_result.hpp"

namespace drover::app {

void check_output(const ResultOutput& output, const std::string& input, const io::Scene& scene) {
    if (!output.file.empty()) report::check_result_file(output.file, {input}, scene, output.overwrite);
}

int print_result(const run::Result& found, const ResultOutput& output, const io::Scene& scene, int threads) {
    const run::Result result = run::with_units(found, scene.units);
    if (!output.file.empty()) report::write_result(result, output.file, output.what, scene, threads, output.overwrite);
    if (output.json) {
        print_json(run::result_json(result));
        return run::exit_done;
    }
    print(run::result_text(result));
    if (!output.file.empty()) print(text("\n{}: {}\n", output.file, output.contents));
    return run::exit_done;
}

}  // namespace drover::app
