// tests/run/restart.cpp: checkpoints that this version of drover cannot resume.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/refusal.hpp"
#include "files/checkpoint.hpp"
#include "files/support.hpp"
#include "io/scene.hpp"
#include "run/run_scene.hpp"

namespace drover::run::restart_tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Restart, of_a_checkpoint_that_another_version_wrote_names_the_version) {
    const testing_support::Folder folder;
    io::Scene scene = io::parse_scene(R"toml(
        field = [{symbol = "phi", name = "phi"}]
        equations = {phi = "lap phi - phi"}
        grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
        time = {dt = 0.1, end = 1.0}
        initial = {kind = "random", amplitude = 0.1}
        output = {sample_every = 0.1})toml",
                                      "short.toml");
    const std::filesystem::path archive = folder / "short.h5";
    scene.output.file = archive.string();
    run_scene(scene, {.quiet = true});
    const auto refusal_with = [&](const std::string& program) {
        files::Checkpoint checkpoint = files::read_newest_checkpoint(archive);
        files::remove_checkpoints(archive);
        if (!program.empty()) checkpoint.program = program;
        checkpoint.state.resize(1);
        files::write_checkpoint(archive, checkpoint);
        const std::vector<std::string> later{"time.end=2"};
        return refusal_of([&] { restart_run(archive, later, {.quiet = true}); });
    };
    EXPECT_THAT(refusal_with(""), Not(HasSubstr("another version of drover")));
    EXPECT_THAT(refusal_with("0.0 (old)"), HasSubstr("written by another version of drover, 0.0 (old)"));
}

}  // namespace
}  // namespace drover::run::restart_tests
