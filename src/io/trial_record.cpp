// io/trial_record.cpp: a trial as bytes: its number, its results, the message of its failure, its time.
#include "io/trial_record.hpp"

#include "drover/base/error.hpp"
#include "files/bytes.hpp"

namespace drover::io {

std::string attempt_bytes(const calibrate::Attempt& attempt) {
    files::ByteWriter to;
    to(attempt.number, attempt.numbers, attempt.failure.value_or(""));
    if (attempt.core_seconds > 0.0) to(attempt.core_seconds);
    return files::text_of(to.bytes);
}

calibrate::Attempt attempt_of(const std::string& bytes, const std::string& name) {
    files::ByteReader reader{std::as_bytes(std::span(bytes))};
    calibrate::Attempt attempt;
    std::string failure;  // of earlier versions, in which a failed trial was a unit that is done
    reader(attempt.number, attempt.numbers, failure);
    if (!failure.empty()) attempt.failure = failure;
    if (reader.is_complete && !reader.rest.empty()) reader(attempt.core_seconds);
    require(reader.has_ended(), {name}, "is not a trial; expected a record of this version of drover");
    return attempt;
}

}  // namespace drover::io
