// base/error.cpp: locations as text, and the messages of errors.
#include "drover/base/error.hpp"

#include <new>
#include <system_error>

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

Error error_of(const std::exception& exception) {
    if (const auto* error = dynamic_cast<const Error*>(&exception)) return *error;
    if (dynamic_cast<const std::bad_alloc*>(&exception) != nullptr) return {Fault::environment, {}, no_memory_text};
    const std::string what = printable(exception.what());
    if (dynamic_cast<const std::system_error*>(&exception) != nullptr)
        return {Fault::environment,
                {},
                text("the operating system reports: {}; check the disk and the limits of this user", what)};
    return {Fault::defect, {}, text("{}; this is a bug in drover: please report it with the scene", what)};
}

}  // namespace drover
