// io/trial_file.cpp: a trial as bytes: its number, its results, the message of its failure.
#include "drover/io/trial_file.hpp"

#include "drover/base/error.hpp"
#include "drover/files/bytes.hpp"

namespace drover::io {

namespace {
std::vector<std::byte> encoded(const calibrate::Attempt& attempt) {
    std::vector<std::byte> bytes;
    files::put(bytes, attempt.number);
    files::put_list(bytes, std::span<const double>(attempt.numbers));
    files::put_text(bytes, attempt.failure);
    if (attempt.core_seconds > 0.0) files::put(bytes, attempt.core_seconds);
    return bytes;
}

std::optional<calibrate::Attempt> decoded(std::span<const std::byte> bytes) {
    files::ByteReader reader{bytes};
    calibrate::Attempt attempt{.number = reader.take<std::uint64_t>(), .numbers = {}, .failure = {}};
    attempt.numbers = reader.take_list<std::vector<double>>();
    attempt.failure = reader.take_list<std::string>();
    if (reader.is_complete && !reader.rest.empty()) attempt.core_seconds = reader.take<double>();
    if (!reader.is_complete || !reader.rest.empty()) return std::nullopt;
    return attempt;
}

std::vector<calibrate::Attempt> attempts_of(const std::vector<std::string>& records, const std::string& file) {
    std::vector<calibrate::Attempt> attempts;
    for (const std::string& record : records) {
        auto attempt = decoded(std::as_bytes(std::span(record)));
        require(attempt.has_value(), {file}, "record {} is not a trial; expected a file of this version of drover",
                attempts.size());
        attempts.push_back(std::move(*attempt));
    }
    return attempts;
}
}  // namespace

TrialFile::TrialFile(const std::filesystem::path& file, const files::RecordIdentity& identity)
    : file_(file, identity), attempts_(attempts_of(file_.records(), file.string())) {}

const std::vector<calibrate::Attempt>& TrialFile::attempts() const { return attempts_; }
std::uint64_t TrialFile::cut() const { return file_.cut(); }
void TrialFile::append(const calibrate::Attempt& attempt) { file_.append(files::text_of(encoded(attempt))); }

std::vector<calibrate::Attempt> read_trials(const std::filesystem::path& file, const files::RecordIdentity& identity) {
    return attempts_of(files::read_records(file, identity), file.string());
}

std::string attempt_bytes(const calibrate::Attempt& attempt) {
    std::vector<std::byte> bytes = encoded(attempt);
    files::put(bytes, files::checksum(bytes));
    return files::text_of(bytes);
}

calibrate::Attempt attempt_of(const std::string& bytes) {
    const auto content = files::without_checksum(std::as_bytes(std::span(bytes)));
    auto attempt = content ? decoded(*content) : std::nullopt;
    if (!attempt)
        fail_environment("a worker returned {} bytes that are not a trial; run the command again", bytes.size());
    return std::move(*attempt);
}

}  // namespace drover::io
