// base/error.cpp: locations as text, and the messages of errors.
#include "drover/base/error.hpp"

namespace drover {

std::string location_text(const SourceLocation& where) {
    if (where.file.empty() || where.line == 0) return where.file;
    if (where.column == 0) return text("{}:{}", where.file, where.line);
    return text("{}:{}:{}", where.file, where.line, where.column);
}

Error::Error(Fault fault, const SourceLocation& where, const std::string& message)
    : std::runtime_error(printable(location_text(where).empty() ? message : location_text(where) + ": " + message)),
      fault_(fault),
      place_(printable(location_text(where))),
      message_(printable(message)) {}

}  // namespace drover
