// files/hdf5_handle.hpp: owning HDF5 identifiers, HDF5's error messages as Errors, and names.
#pragma once
#include <hdf5.h>

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::files {

/// An identifier and the function that closes it.
class Handle {
public:
    using Close = herr_t (*)(hid_t);
    Handle() = default;
    Handle(hid_t id, Close close) : id_(id), close_(close) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    operator hid_t() const { return id_; }

private:
    hid_t id_ = -1;
    Close close_ = nullptr;
};

/// The first failure of an HDF5 call, also of one whose result nobody sees: the closing of a dataset, which writes what
/// HDF5 has kept of it in memory.
struct Hdf5Failure {
    bool happened = false;
    std::array<char, 256> message{};  ///< not a string, whose memory may be what is missing
};

/// Stops HDF5 from printing its error stack while it lives, and keeps the first failure; restores the previous setting.
class QuietErrors {
public:
    explicit QuietErrors(Hdf5Failure* first = nullptr);
    ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;

private:
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

/// Turns a negative HDF5 result into an Error with the file, the operation and HDF5's innermost message.
struct Hdf5Errors {
    std::string file;
    Fault fault = Fault::environment;
    std::function<void()> throw_cause = {};  ///< throws the failure of the disk behind HDF5's, if there is one

    template <class Result>
    Result check(Result result, std::string_view doing) const {
        if (result < 0) fail(doing);
        return result;
    }
    Handle own(hid_t id, Handle::Close close, std::string_view doing) const { return {check(id, doing), close}; }
    [[noreturn]] void fail(std::string_view doing) const;
};

/// Bytes of an array of numbers with these sizes: a double, which does not overflow.
template <class Sizes>
double bytes_of(const Sizes& sizes) {
    double bytes = sizeof(double);
    for (const auto size : sizes) bytes *= static_cast<double>(size);
    return bytes;
}

/// The names of the attributes of an object, in order.
std::vector<std::string> attribute_names(hid_t object, const Hdf5Errors& errors);

}  // namespace drover::files
