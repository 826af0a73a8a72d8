// physics/model_values.cpp: values by key, and which fields a model has.
#include "physics/model_values.hpp"

#include <algorithm>

namespace drover::physics {

namespace {
std::map<std::string, Value> standards_of(const ModelFile& file) {
    std::map<std::string, Value> result;
    for (const CoefficientRow& row : file.coefficients) result.emplace(row.key(), row.standard);
    for (const KeyRow& row : file.keys) result.emplace(row.key(), row.description.default_value);
    return result;
}

const Value& value_of(const ModelValues& model, const std::string& key) {
    const auto found = model.values.find(key);
    require(found != model.values.end(), {}, "{} is no key of the model file", key);
    return found->second;
}

const FieldRow* find_field(const ModelFile& file, const std::string& symbol) {
    for (const FieldRow& field : file.fields)
        if (field.symbol == symbol) return &field;
    return nullptr;
}

/// The fields of a model: "rate" or "balance" of each.
NamedTexts present_fields(const ModelValues& model) {
    NamedTexts present;
    for (const FieldRow& field : model.file->fields)
        if (const Presence how = presence(model, field); how != Presence::absent)
            present.emplace_back(field.symbol, how == Presence::rate ? "rate" : "balance");
    return present;
}

const std::string* named_form(const ModelValues& model) {
    const NamedTexts present = present_fields(model);
    for (const auto& [name, fields] : model.file->forms)
        if (fields == present) return &name;
    return nullptr;
}
}  // namespace

ModelValues::ModelValues(const ModelFile& of) : file(&of) {
    static const std::map<std::string, Value> shipped = standards_of(shipped_model());
    values = &of == &shipped_model() ? shipped : standards_of(of);
}

const TableColumn& TableData::column(const std::string& key) const {
    static const TableColumn none;
    const auto found = columns.find(key);
    return found == columns.end() ? none : found->second;
}

bool TableData::has_values() const {
    return std::ranges::any_of(columns, [](const auto& one) { return !one.second.values.empty(); });
}

double number(const ModelValues& model, const std::string& key) { return std::get<double>(value_of(model, key)); }
bool flag(const ModelValues& model, const std::string& key) { return std::get<bool>(value_of(model, key)); }
const std::string& word(const ModelValues& model, const std::string& key) {
    return std::get<std::string>(value_of(model, key));
}
bool is_standard(const ModelValues& model, const std::string& key) {
    for (const KeyRow& row : model.file->keys)
        if (row.key() == key) return value_of(model, key) == row.description.default_value;
    return number(model, key) == coefficient_row(key, *model.file).standard;
}

double& number_in(ModelValues& model, const std::string& key) {
    return std::get<double>(const_cast<Value&>(value_of(model, key)));
}

void set_convention(ModelValues& model, const std::string& convention) {
    if (const CoefficientRow* row = with_conventions(*model.file)) model.values.at(row->factor_key) = convention;
}

const std::vector<std::string>& monomials_of(const ModelValues& model, const std::string& key) {
    static const std::vector<std::string> none;
    const auto found = model.monomials.find(key);
    return found == model.monomials.end() ? none : found->second;
}

bool is_given(const ModelValues& model, const CoefficientRow& row) {
    return number(model, row.key()) != 0.0 || !monomials_of(model, row.key()).empty();
}

Presence presence(const ModelValues& model, const FieldRow& field) {
    if (field.present.empty()) return Presence::rate;
    const Value& value = value_of(model, field.present);
    if (const bool* is_there = std::get_if<bool>(&value)) return *is_there ? Presence::rate : Presence::absent;
    return value_named<Presence>(std::get<std::string>(value)).value_or(Presence::rate);
}

Presence presence(const ModelValues& model, const std::string& symbol) {
    const FieldRow* field = find_field(*model.file, symbol);
    return field == nullptr ? Presence::absent : presence(model, *field);
}

bool has_fields(const ModelValues& model, const std::vector<std::string>& symbols) {
    return std::ranges::all_of(symbols,
                               [&](const std::string& symbol) { return presence(model, symbol) != Presence::absent; });
}

SourceKind source_kind(const ModelValues& model) {
    return value_named<SourceKind>(word(model, model.file->source.section + ".kind")).value();
}

Densities mean_densities(const ModelValues& model) {
    Densities means{};
    const std::vector<const FieldRow*> fields = densities(*model.file);
    for (std::size_t k = 0; k < fields.size(); ++k) means[k] = number(model, fields[k]->reference);
    return means;
}

bool has_noise(const ModelValues& model) {
    const auto& rows = model.file->coefficients;
    return std::ranges::any_of(rows, [&](const CoefficientRow& row) {
        return !row.noise_of.empty() && number(model, row.key()) != 0.0;
    });
}

void remove_noise(ModelValues& model) {
    for (const CoefficientRow& row : model.file->coefficients)
        if (!row.noise_of.empty()) number_in(model, row.key()) = 0.0;
}

bool order_is_density(const ModelValues& model) {
    const OrderUnit& unit = model.file->order;
    return has_fields(model, {unit.density}) && word(model, unit.key) == unit.value;
}

std::string unit_of(const ModelValues& model, const std::string& unit) {
    constexpr std::string_view name = "[p]";
    const OrderUnit& order = model.file->order;
    const std::string of_order = order_is_density(model) ? order.unit : order.otherwise;
    if (unit == name) return of_order;
    std::string result = unit;
    if (const std::size_t over = result.find("/[p]"); of_order == "1" && over != std::string::npos)
        result.erase(over, std::string_view("/[p]").size());
    for (std::size_t at = result.find(name); at != std::string::npos; at = result.find(name))
        result.replace(at, name.size(), of_order == "1" ? of_order : "(" + of_order + ")");
    return result;
}

bool is_named_form(const ModelValues& model) { return named_form(model) != nullptr; }

std::string form_name(const ModelValues& model) {
    if (const std::string* name = named_form(model)) return *name;
    std::string list;
    for (const bool is_choice : {false, true})  // what every model has comes first
        for (const FieldRow& field : model.file->fields) {
            const Presence how = presence(model, field);
            if (how == Presence::absent || field.present.empty() == is_choice) continue;
            const char* dynamics = field.mass.empty() ? "" : how == Presence::rate ? "dynamic " : "slaved ";
            list += (list.empty() ? "" : ", ") + std::string(dynamics) + words_of(field.name);
        }
    return list;
}

}  // namespace drover::physics
