// files/record_identity.cpp: hashes of texts, and their keys compared.
#include "files/record_identity.hpp"

#include <algorithm>
#include <map>
#include <sstream>

#include "drover/base/text.hpp"
#include "files/bytes.hpp"

namespace drover::files {

std::uint64_t fingerprint(const std::string& content) { return checksum(std::as_bytes(std::span(content))); }

RecordIdentity identity_of(const std::string& job, const std::string& content) {
    return {.hash = fingerprint(job + "\n" + content), .content = content};
}

namespace {
/// Keys with their sections and values.  Those of lists are numbered: "field[2].symbol".
std::vector<std::pair<std::string, std::string>> keys_of(const std::string& words) {
    std::vector<std::pair<std::string, std::string>> keys;
    std::map<std::string, int> items;
    std::string section, line;
    std::istringstream stream(words);
    while (std::getline(stream, line)) {
        if (line.starts_with("[[")) {
            section = line.substr(2, line.find(']') - 2);
            section += text("[{}]", ++items[section]);
        } else if (line.starts_with('[')) {
            section = line.substr(1, line.find(']') - 1);
        }
        if (const std::size_t equals = line.find(" = "); equals != std::string::npos)
            keys.emplace_back(section + "." + line.substr(0, equals), line.substr(equals + 3));
    }
    return keys;
}
}  // namespace

std::vector<TextDifference> differences(const std::string& one, const std::string& other) {
    const auto a = keys_of(one), b = keys_of(other);
    const std::map<std::string, std::string> in_one(a.begin(), a.end()), in_other(b.begin(), b.end());
    std::vector<TextDifference> result;
    for (const auto& [key, value] : a) {
        const auto found = in_other.find(key);
        if (found == in_other.end()) result.push_back({key, value, {}});
        else if (found->second != value) result.push_back({key, value, found->second});
    }
    for (const auto& [key, value] : b)
        if (!in_one.contains(key)) result.push_back({key, {}, value});
    return result;
}

std::optional<TextDifference> first_difference(const std::string& one, const std::string& other) {
    const std::vector<TextDifference> all = differences(one, other);
    return all.empty() ? std::nullopt : std::optional(all.front());
}

bool are_same(const std::string& one, const std::string& other, const std::string& defaults) {
    const std::vector<TextDifference> found = differences(one, other);
    if (found.empty()) return true;
    const auto keys = keys_of(defaults);
    const std::map<std::string, std::string> default_values(keys.begin(), keys.end());
    return std::ranges::all_of(found, [&](const TextDifference& row) {
        if (row.one && row.other) return false;
        const auto value = default_values.find(row.key);
        return value != default_values.end() && value->second == (row.one ? *row.one : *row.other);
    });
}

}  // namespace drover::files
