// tests/fuzz/targets.cpp: the readers of scenes, formulas and files.
#include "fuzz/targets.hpp"

#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/log.hpp"
#include "drover/base/expression.hpp"
#include "files/checkpoint.hpp"
#include "files/record_folder.hpp"
#include "io/calibration.hpp"
#include "io/export.hpp"
#include "io/scene.hpp"
#include "run/simulation_type.hpp"

namespace drover::fuzz {
namespace {

/// A file with these bytes, in memory if the system has a folder for that.
class File {
public:
    File(std::span<const char> bytes, const std::string& ending = "") {
        const std::filesystem::path shared = "/dev/shm";
        const std::filesystem::path folder =
            std::filesystem::exists(shared) ? shared : std::filesystem::temp_directory_path();
        base_ = folder / ("drover-fuzz-" + std::to_string(::getpid()) + ".h5");
        written_ = base_.string() + ending;
        std::ofstream(written_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    ~File() { std::filesystem::remove(written_); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    const std::filesystem::path& base() const { return base_; }

private:
    std::filesystem::path base_, written_;
};

template <class Read>
void reject_or_read(Read read) {
    try {
        read();
    } catch (const Error&) {
        return;  // with a sentence
    }
}

void read_formula(std::span<const char> bytes) {
    reject_or_read([&] {
        const Expression formula = parse_expression({bytes.begin(), bytes.end()}, {.variables = {{"x", 0}, {"y", 1}}});
        evaluate(formula, std::array{0.5, 2.0});
    });
}

/// The text of a term in an otherwise valid scene.
void read_term(std::span<const char> bytes) {
    reject_or_read([&] {
        const std::string written = toml_text(Value(std::string(bytes.begin(), bytes.end())));
        io::parse_scene("[[terms]]\nof = \"rod_density\"\nvalue = " + written +
                            "\nparameters = { W = 0.7 }\n[[terms]]\nof = \"order\"\nvalue = [\"0\", " + written +
                            "]\n[grid]\nnx = 8\nny = 8\n[time]\ndt = 0.1\nend = 1.0\n[initial]\nkind = \"uniform\"\n",
                        "fuzz.toml");
    });
}

}  // namespace

const std::vector<Target>& targets() {
    static const std::vector<Target> all{
        {"scene",
         [](std::span<const char> bytes) {
             reject_or_read([&] { io::parse_scene({bytes.begin(), bytes.end()}, "fuzz.toml"); });
         }},
        {"term", read_term},
        {"formula", read_formula},
        {"archive",
         [](std::span<const char> bytes) {
             const File file(bytes);
             reject_or_read([&] { files::ArchiveReader(file.base()).contents(); });
             reject_or_read([&] { run::make_report(files::ArchiveReader(file.base())); });
         }},
        {"table",
         [](std::span<const char> bytes) {
             const File file(bytes);
             reject_or_read([&] { io::read_calibration(file.base()); });
         }},
        {"checkpoint",
         [](std::span<const char> bytes) {
             const File file(bytes, ".checkpoint-a");
             reject_or_read([&] { files::read_newest_checkpoint(file.base()); });
         }},
        {"trials",
         [](std::span<const char> bytes) {
             files::RecordIdentity identity;  // as the file has it, so that its records are read
             if (bytes.size() >= 16) std::memcpy(&identity.hash, bytes.data() + 8, sizeof identity.hash);
             if (bytes.size() >= 16) identity.content = files::records_in(std::as_bytes(bytes.subspan(16))).of;
             reject_or_read([&] {
                 for (const std::string& record : files::content_of(std::as_bytes(bytes), identity, "trials").records)
                     io::attempt_of(record, "record");
             });
         }},
        {"xyz", [](std::span<const char> bytes) {
             const File file(bytes);
             reject_or_read([&] {
                 if (io::is_xyz(file.base())) io::read_xyz_info(file.base());
             });
         }}};
    return all;
}

}  // namespace drover::fuzz
