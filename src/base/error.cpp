// base/error.cpp: locations as text, and the messages of errors.
#include "drover/base/error.hpp"

namespace drover {

std::string location_text(const SourceLocation& where) {
    if (where.file.empty() || where.line == 0) return where.file;
    if (where.column == 0) return text("{}:{}", where.file, where.line);
    return text("{}:{}:{}", where.file, where.line, where.column);
}

namespace {
std::string with_location(const SourceLocation& where, const std::string& message) {
    const std::string location = location_text(where);
    return location.empty() ? message : location + ": " + message;
}
}  // namespace

Error::Error(Fault fault, const SourceLocation& where, const std::string& message)
    : std::runtime_error(printable(with_location(where, message))), fault_(fault) {}

}  // namespace drover
