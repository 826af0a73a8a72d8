// tests/base/refusal.hpp: the message of an Error.
#pragma once
#include <functional>
#include <string>

#include "drover/base/error.hpp"

namespace drover {

inline std::string refusal_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "no refusal";
}

}  // namespace drover
