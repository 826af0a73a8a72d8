// files/record_identity.hpp: what records depend on, and the first difference of two such texts.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace drover::files {

/// What the records of a file depend on.
struct RecordIdentity {
    std::uint64_t hash = 0;  ///< of all of it
    std::string content;     ///< scene text of which the file keeps a copy, to name a difference; "": none
};

inline constexpr const char* absent = "absent";

/// A key of two scene texts whose values differ, and these; `absent` where a text lacks the key.
struct TextDifference {
    std::string key, one, other;
};
/// In the order of `one`, then those that it lacks.
std::vector<TextDifference> differences(const std::string& one, const std::string& other);
/// No key when there is none.
TextDifference first_difference(const std::string& one, const std::string& other);

/// 64-bit hash of a text.
std::uint64_t fingerprint(const std::string& content);

}  // namespace drover::files
