// io/trial_record.cpp: a trial as bytes: its number, its results, the message of its failure, its time.
#include "io/trial_record.hpp"

#include <optional>

#include "drover/base/error.hpp"
#include "files/bytes.hpp"

namespace drover::io {

namespace {
std::optional<calibrate::Attempt> decoded(std::span<const std::byte> bytes) {
    files::ByteReader reader{bytes};
    calibrate::Attempt attempt;
    reader(attempt.number, attempt.numbers, attempt.failure);
    if (reader.is_complete && !reader.rest.empty()) reader(attempt.core_seconds);
    if (!reader.has_ended()) return std::nullopt;
    return attempt;
}

}  // namespace

std::string attempt_bytes(const calibrate::Attempt& attempt) {
    files::ByteWriter to;
    to(attempt.number, attempt.numbers, attempt.failure);
    if (attempt.core_seconds > 0.0) to(attempt.core_seconds);
    return files::text_of(to.bytes);
}

calibrate::Attempt attempt_of(const std::string& bytes, const std::string& name) {
    auto attempt = decoded(std::as_bytes(std::span(bytes)));
    require(attempt.has_value(), {name}, "is not a trial; expected a record of this version of drover");
    return std::move(*attempt);
}

}  // namespace drover::io
