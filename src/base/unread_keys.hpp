// base/unread_keys.hpp: keys that a choice of another key leaves without effect.
#pragma once
#include <map>
#include <string>

#include "drover/base/error.hpp"
#include "drover/base/schema.hpp"

namespace drover {

/// Whether a key is read with what is chosen, and the choices that read it, for people.
struct Reading {
    bool is_read;
    std::string readers;
};

/// Throws an input Error at a key of a section that is not read and has another value than in `without_keys`.
/// \param chosen what leaves it without effect, such as `initial.kind = "uniform"`
/// \param readings of keys by name; a key that is not among them is always read
template <class Struct>
void reject_unread(const Struct& section, const std::string& name, const std::string& chosen,
                   const std::map<std::string, Reading>& readings, const Locate& locate,
                   const Struct& without_keys = {}) {
    const auto values = values_of(section), defaults = values_of(without_keys);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto found = readings.find(values[i].first);
        if (found == readings.end() || found->second.is_read || values[i].second == defaults[i].second) continue;
        const std::string key = name + "." + values[i].first;
        fail_input(locate(key), "{} = {} has no effect with {}; expected its default, {}, or {}", key,
                   toml_text(values[i].second), chosen, toml_text(defaults[i].second), found->second.readers);
    }
}

}  // namespace drover
