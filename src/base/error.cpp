// base/error.cpp: places and the exception that carries them.
#include "drover/base/error.hpp"

namespace drover {

std::string location_text(const SourceLocation& where) {
    if (where.file.empty() || where.line == 0) return where.file;
    if (where.column == 0) return text("{}:{}", where.file, where.line);
    return text("{}:{}:{}", where.file, where.line, where.column);
}

namespace {
std::string with_place(const SourceLocation& where, const std::string& sentence) {
    const std::string place = location_text(where);
    return place.empty() ? sentence : place + ": " + sentence;
}
}  // namespace

Error::Error(Fault fault, const SourceLocation& where, const std::string& sentence)
    : std::runtime_error(with_place(where, sentence)), fault_(fault) {}

}  // namespace drover
