// files/record_identity.cpp: hashes of texts, and their keys compared.
#include "files/record_identity.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

#include "files/bytes.hpp"

namespace drover::files {

std::uint64_t fingerprint(const std::string& content) { return checksum(std::as_bytes(std::span(content))); }

TextDifference first_difference(const std::string& one, const std::string& other) {
    const auto keys_of = [](const std::string& words) {
        std::vector<std::pair<std::string, std::string>> keys;
        std::string section, line;
        std::istringstream stream(words);
        while (std::getline(stream, line)) {
            if (line.starts_with('[')) section = line.substr(1, line.find(']') - 1);
            const std::size_t equals = line.find(" = ");
            if (equals != std::string::npos)
                keys.emplace_back(section + "." + line.substr(0, equals), line.substr(equals + 3));
        }
        return keys;
    };
    const auto a = keys_of(one), b = keys_of(other);
    const auto has = [](const auto& keys, const std::string& name) {
        return std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return key.first == name; });
    };
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        if (i < a.size() && i < b.size() && a[i] == b[i]) continue;
        if (i < a.size() && i < b.size() && a[i].first == b[i].first) return {a[i].first, a[i].second, b[i].second};
        const bool is_in_one = i < a.size() && (i >= b.size() || !has(b, a[i].first));
        if (is_in_one || i >= b.size()) return {a[i].first, a[i].second, "absent"};
        return {b[i].first, "absent", b[i].second};
    }
    return {};
}

}  // namespace drover::files
