// physics/term_names.cpp: fields, their components and their derivatives by name.
#include "physics/term_names.hpp"

namespace drover::physics {

std::map<std::string, std::string> text_names(const ModelValues& model) {
    std::map<std::string, std::string> names;
    for (const FieldRow& field : model.file->fields) {
        if (presence(model, field) == Presence::absent) continue;
        names[field.alias] = field.symbol;
        if (field.spin == 0) continue;
        for (const char* part : {"_x", "_y"}) names[field.alias + part] = field.symbol + part;
    }
    return names;
}

std::map<std::string, std::string> argument_names(const ModelValues& model) {
    std::map<std::string, std::string> names;
    const std::map<std::string, std::string> fields = text_names(model);
    for (const auto& [name, formula] : fields) {
        const bool is_vector = fields.count(name + "_x") > 0;
        if (!is_vector) names[name] = formula;
        for (const char* operation : {"d_x", "d_y", "lap"})
            if (!is_vector) names[text("{}_{}", operation, name)] = text("{} {}", operation, formula);
        for (const char* operation : {"div", "curl"})
            if (is_vector) names[text("{}_{}", operation, name)] = text("{} {}", operation, formula);
        for (const char* axis : {"x", "y"})
            if (is_vector) names[text("grad_div_{}_{}", axis, name)] = text("d_{} div {}", axis, formula);
    }
    return names;
}

}  // namespace drover::physics
