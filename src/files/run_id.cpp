// files/run_id.cpp: random bits of the kernel.
#include "files/run_id.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace drover::files {

std::string draw_run_id() {
    std::array<unsigned char, 16> bits{};
    if (::getentropy(bits.data(), bits.size()) < 0)
        throw std::system_error(errno, std::generic_category(), "drawing random bits");
    std::string digits;
    for (const unsigned char byte : bits) digits += text("{:02x}", byte);
    return digits;
}

std::string run_id_of(const ArchiveReader& archive) { return text_in(archive.attributes(), run_id_name); }

}  // namespace drover::files
