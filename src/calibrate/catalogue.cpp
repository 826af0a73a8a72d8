// calibrate/catalogue.cpp: the list of all assays.
#include "calibrate/catalogue.hpp"

#include "drover/base/error.hpp"

namespace drover::calibrate {

std::vector<Assay> make_assays(const Plans& plans) {
    return std::apply([&](const auto&... row) { return std::vector<Assay>{row.make(plans.*row.plan)...}; }, catalogue);
}

const Assay& find_assay(std::span<const Assay> assays, const std::string& name) {
    std::vector<std::string> names;
    for (const Assay& assay : assays) {
        if (assay.name == name) return assay;
        names.push_back(assay.name);
    }
    fail_input({}, "there is no assay \"{}\"; expected one of {}", name, joined(names));
}

}  // namespace drover::calibrate
