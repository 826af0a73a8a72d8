// files/record_identity.hpp: what records depend on, and the first difference of two such texts.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace drover::files {

/// What the records of a file depend on.
struct RecordIdentity {
    std::uint64_t hash = 0;  ///< of all of it
    std::string content;     ///< scene text of which the file keeps a copy, to name a difference
};

/// A key of two scene texts whose values differ, and these; none where a text lacks the key.
struct TextDifference {
    std::string key;
    std::optional<std::string> one, other;
};
/// One of the values, for people.
inline std::string shown(const std::optional<std::string>& value) { return value.value_or("absent"); }

/// In the order of `one`, then those that it lacks.
std::vector<TextDifference> differences(const std::string& one, const std::string& other);
std::optional<TextDifference> first_difference(const std::string& one, const std::string& other);

/// Whether the values of two scene texts are the same, where a key that one of them lacks has its value in `defaults`.
bool are_same(const std::string& one, const std::string& other, const std::string& defaults);

/// 64-bit hash of a text.
std::uint64_t fingerprint(const std::string& content);

/// Of the records of a job, such as "sweep", which depend on this text alone.
RecordIdentity identity_of(const std::string& job, const std::string& content);

}  // namespace drover::files
