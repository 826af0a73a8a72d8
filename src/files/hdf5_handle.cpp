// files/hdf5_handle.cpp: the innermost message of HDF5's error stack, and names in a file.
#include "files/hdf5_handle.hpp"

#include <cstdio>

namespace drover::files {
namespace {

using Message = std::array<char, 256>;

/// Keeps the first entry, the innermost.  HDF5 calls it: it must not throw.
extern "C" herr_t keep_innermost(unsigned number, const H5E_error2_t* entry, void* message) noexcept {
    auto& kept = *static_cast<Message*>(message);
    if (number == 0 && entry->desc != nullptr) std::snprintf(kept.data(), kept.size(), "%s", entry->desc);
    return 0;
}

extern "C" herr_t keep_first(hid_t stack, void* failure) noexcept {
    auto& first = *static_cast<Hdf5Failure*>(failure);
    if (!first.happened) H5Ewalk2(stack, H5E_WALK_UPWARD, keep_innermost, &first.message);
    first.happened = true;
    return 0;
}

}  // namespace

QuietErrors::QuietErrors(Hdf5Failure* first) {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, first == nullptr ? nullptr : keep_first, first);
}

void Hdf5Errors::fail(std::string_view doing) const {
    Message innermost{};
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &innermost);
    const std::string message = innermost[0] == '\0' ? "no message" : innermost.data();
    if (throw_cause) throw_cause();
    if (fault == Fault::input)
        fail_input({file},
                   "{} failed (HDF5: {}); expected an archive: the file is damaged or was not written by drover{}",
                   doing, message, message.find("alloc") == message.npos ? "" : ", or too little memory is free");
    throw Error(fault, {file}, text("{} failed (HDF5: {})", doing, message));
}

std::vector<std::string> attribute_names(hid_t object, const Hdf5Errors& errors) {
    const std::string doing = "listing attributes";
    H5O_info_t about;
    errors.check(H5Oget_info2(object, &about, H5O_INFO_NUM_ATTRS), doing);
    std::vector<std::string> names;
    for (hsize_t i = 0; i < about.num_attrs; ++i) {
        const auto read = [&](char* to, std::size_t size) {
            return errors.check(H5Aget_name_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, i, to, size, H5P_DEFAULT),
                                doing);
        };
        names.emplace_back(static_cast<std::size_t>(read(nullptr, 0)), '\0');
        read(names.back().data(), names.back().size() + 1);
    }
    return names;
}

}  // namespace drover::files
