// physics/equations.cpp: the equations of a model by the model layer, and their linearisations; the terms that a model
// can have: balances are solved for their fields, by wave or by point.
#include "physics/equations.hpp"

#include <algorithm>
#include <mutex>
#include <optional>

#include "physics/program_functions.hpp"
#include "physics/written_model.hpp"

namespace drover::physics {

namespace {
/// What multiplies the rates of some components, and its slopes in the densities.
struct MassOf {
    int first = 0, width = 0;
    double constant = 0.0;            ///< times the densities in it; 0 in a balance
    std::vector<int> densities = {};  ///< components
};

/// Left sides of right sides alone: masses, balances and noise.
class LeftSidesOf {
public:
    explicit LeftSidesOf(const Equations& e) : components_(e.right_sides().components()) {
        noise_ = flux_noise_ = Eigen::VectorXd::Zero(components_);
        for (const FieldRow& field : e.model.file->fields) {
            const int first = e.component(field.symbol), width = field.spin == 0 ? 1 : 2;
            if (first < 0) continue;
            (field.conserved ? flux_noise_ : noise_).segment(first, width).setConstant(number(e.model, field.noise));
            const Presence how = presence(e.model, field);
            if (field.mass.empty() && how == Presence::rate) continue;
            MassOf mass{.first = first, .width = width};
            if (how == Presence::rate) {
                mass.constant = mass_factor(e, field);
                for (const FieldRow* density : densities(*e.model.file))
                    if (is_in_mass(field, *density) && e.component(density->symbol) >= 0)
                        mass.densities.push_back(e.component(density->symbol));
            }
            masses_.push_back(std::move(mass));
        }
    }
    model::LeftSides operator()(const model::UniformState& about) const {
        model::LeftSides left{.mass_density = Eigen::VectorXd::Ones(components_),
                              .noise = noise_,
                              .flux_noise = flux_noise_};
        for (const MassOf& mass : masses_) {
            double value = mass.constant;
            for (const int k : mass.densities) value *= about[static_cast<std::size_t>(k)];
            left.mass_density.segment(mass.first, mass.width).setConstant(value);
            if (mass.densities.empty() || mass.constant == 0.0) continue;
            if (left.slopes.size() == 0) left.slopes = Eigen::MatrixXd::Zero(components_, components_);
            for (const int k : mass.densities) {
                double slope = mass.constant;
                for (const int other : mass.densities)
                    if (other != k) slope *= about[static_cast<std::size_t>(other)];
                left.slopes.block(mass.first, k, mass.width, 1).setConstant(slope);
            }
        }
        return left;
    }

private:
    Eigen::Index components_;
    Eigen::VectorXd noise_, flux_noise_;
    std::vector<MassOf> masses_;
};

/// A field in balance.
struct Balance {
    const Equations& equations;
    const FieldRow& field;
    std::string name, remedy;  ///< "slaved bead velocity", what to set instead
    bool is_pointwise;

    bool has_own(const std::vector<int>& components) const {
        const int first = equations.component(field.symbol), width = field.spin == 0 ? 1 : 2;
        return std::ranges::any_of(components, [&](int k) { return k >= first && k < first + width; });
    }
};

/// The text of a scene that a term is; nullptr: a term of the file.
const TextTerm* text_of(const Equations& equations, std::size_t term) {
    const std::vector<TextTerm>& texts = equations.model.text_terms;
    for (std::size_t k = 0; k < texts.size(); ++k)
        if (equations.terms()[term] == text("terms[{}]", k + 1)) return &texts[k];
    return nullptr;
}

std::string name_of(const TextTerm& term, const model::TermSummary& summary) {
    return term.function.empty() ? summary.text : text("{}, the Python function {}", summary.text, term.function);
}

/// Of every text.
void check_conserved(const Equations& equations, const TextTerm& term, std::size_t n) {
    const model::TermSummary& summary = equations.right_sides().terms()[n];
    for (const FieldRow& field : equations.model.file->fields)
        require(!field.conserved || !equations.is_of(n, field) || summary.vanishes_when_uniform, term.where,
                "{} changes the number of {} in a uniform state, which the equations conserve; use a flux",
                name_of(term, summary), field.observed.short_name);
}

void check_text(const Balance& balance, const TextTerm& term, std::size_t n) {
    const model::TermSummary& summary = balance.equations.right_sides().terms()[n];
    const std::string name = name_of(term, summary);
    const bool is_own = balance.equations.is_of(n, balance.field);
    require(!is_own || !term.is_explicit, term.where,
            "{}: explicit = true, and a {} balances its terms at every instant; expected {}, or explicit = false", name,
            balance.name, balance.remedy);
    require(!is_own || !balance.has_own(summary.reads), term.where,
            "{}: a term of the balance that depends on its field needs {}; a {} balances the others with {} only", name,
            balance.remedy, balance.name, key_of_term(balance.field.symbol, balance.field.symbol));
    require(!balance.is_pointwise || !balance.has_own(summary.derives), term.where,
            "{}: derivatives of a {} are not available when it depends on the fields at each point; set {}", name,
            balance.name, balance.remedy);
}

/// Derivatives of the field are solved for by wave, products at each point.
void check_products(const Balance& balance, const Locate& locate) {
    const Equations& e = balance.equations;
    std::string derivative;
    for (std::size_t n = 0; n < e.terms().size(); ++n)
        if (e.is_of(n, balance.field) && balance.has_own(e.right_sides().terms()[n].derives)) derivative = e.terms()[n];
    if (derivative.empty()) return;
    for (std::size_t n = 0; n < e.terms().size(); ++n) {
        if (!e.is_of(n, balance.field)) continue;
        const TextTerm* written = text_of(e, n);
        const bool is_linear = e.right_sides().terms()[n].is_linear && !e.right_sides().terms()[n].is_placed;
        if (is_linear && (written == nullptr || e.right_sides().is_isotropic(n))) continue;
        const auto found = e.coefficients.find(e.terms()[n]);
        const bool varies = found != e.coefficients.end() && found->second.varies();
        fail_input(written != nullptr ? written->where : locate(e.terms()[n] + (varies ? "_terms" : "")),
                   "{}: a {} has either terms that are not linear or not isotropic, or derivatives in its balance, of "
                   "{}; set {} to 0, or set {}",
                   written != nullptr ? e.right_sides().terms()[n].text : e.terms()[n], balance.name, derivative,
                   derivative, balance.remedy);
    }
}

void check_balances(const Equations& equations, const Locate& locate) {
    const ModelValues& model = equations.model;
    const FieldRow* pointwise = pointwise_balance(equations);
    for (const FieldRow& field : model.file->fields) {
        if (presence(model, field) != Presence::balance) continue;
        const std::string name = "slaved " + words_of(field.name);
        const Balance balance{.equations = equations,
                              .field = field,
                              .name = name,
                              .remedy = field.present + " = \"dynamic\"",
                              .is_pointwise = pointwise == &field};
        const std::string own = key_of_term(field.symbol, field.symbol);
        const double drag = equations.coefficient(own).at(mean_densities(model));
        require(drag > 0.0, locate(own),
                "{} is {} in the uniform state; expected > 0: at q = 0 nothing else limits a {}", own, drag, name);
        for (std::size_t n = 0; n < equations.terms().size(); ++n)
            if (const TextTerm* written = text_of(equations, n)) check_text(balance, *written, n);
        check_products(balance, locate);
    }
}
}  // namespace

struct Equations::Cache {
    std::mutex mutex;
    std::optional<model::Equations> solver;  // about the means of the model
};

Equations::Equations(CompiledModel compiled, const Locate& locate) : CompiledModel(std::move(compiled)) {
    compile(locate);
}
Equations::Equations(const ModelValues& the_model, const Equations& like)
    : CompiledModel(the_model, no_location, &like) {
    const auto ratios = ratios_of_terms(like, *this);
    if (!ratios) {
        compile(no_location);
        return;
    }
    right_sides_ = like.right_sides_;
    terms_ = like.terms_;
    factors_ = like.factors_;
    cache_ = std::make_shared<Cache>();
    for (std::size_t n = 0; n < terms_.size(); ++n)
        if (const auto ratio = ratios->find(terms_[n]); ratio != ratios->end()) factors_[n] *= ratio->second;
    check_terms(no_location);
}

void Equations::compile(const Locate& locate) {
    cache_ = std::make_shared<Cache>();
    const WrittenModel written = write_model(*this, Written::right_sides);
    right_sides_ = std::make_shared<const model::Equations>(written.model);
    terms_ = written.terms;
    factors_.assign(terms_.size(), 1.0);
    check_terms(locate);
}

model::Equations Equations::solver(const Densities& about) const {
    std::optional<model::Equations> base;
    {
        const std::lock_guard lock(cache_->mutex);
        if (!cache_->solver) cache_->solver.emplace(write_model(*this, Written::solver).model);
        base = cache_->solver;
    }
    model::UniformState state = base->reference();
    const std::vector<const FieldRow*> fields = densities(*model.file);
    bool differs = false;
    for (std::size_t k = 0; k < fields.size(); ++k) {
        const int at = component(fields[k]->symbol);
        if (at < 0) continue;
        double& value = state[static_cast<std::size_t>(at)];
        differs = differs || value != about[k];
        value = about[k];
    }
    return differs ? base->about(state) : *base;
}

int Equations::component(const std::string& symbol) const {
    for (const auto& [field, first] : model::placed_fields(right_sides_->model()))
        if (field.symbol == symbol) return static_cast<int>(first);
    return -1;
}

bool Equations::is_of(std::size_t term, const FieldRow& field) const {
    return right_sides_->model().fields[right_sides_->terms()[term].field].symbol == field.symbol;
}

theory::PointTheory Equations::theory() const { return theory(std::make_shared<const Equations>(*this)); }

theory::PointTheory Equations::theory(const std::shared_ptr<const Equations>& equations) {
    const Equations& e = *equations;
    require_functions(e.model);
    return {*e.right_sides_, e.factors_, LeftSidesOf(e), [equations] { return equations->solver(); }};
}

std::vector<std::string> written_terms(const Equations& equations) {
    std::map<std::string, std::string> of_scene;
    for (const SceneTerm& term : scene_terms(equations)) of_scene[term.written.name] = term.equation;
    std::vector<std::string> result;
    for (std::size_t n = 0; n < equations.terms().size(); ++n) {
        const auto found = of_scene.find(equations.terms()[n]);
        result.push_back(found == of_scene.end() ? equations.right_sides().terms()[n].text : found->second);
    }
    return result;
}

const FieldRow* pointwise_balance(const Equations& equations) {
    const std::vector<model::TermSummary>& found = equations.right_sides().terms();
    for (const FieldRow& field : equations.model.file->fields) {
        if (presence(equations.model, field) != Presence::balance) continue;
        for (std::size_t n = 0; n < found.size(); ++n)
            if (equations.is_of(n, field) &&
                (!found[n].is_linear || found[n].is_placed ||
                 (text_of(equations, n) != nullptr && !equations.right_sides().is_isotropic(n))))
                return &field;
    }
    return nullptr;
}

void Equations::check_terms(const Locate& locate) const {
    for (std::size_t n = 0; n < terms_.size(); ++n)
        if (const TextTerm* written = text_of(*this, n)) check_conserved(*this, *written, n);
    check_balances(*this, locate);
}

Equations check(const ModelValues& model, const Locate& locate) {
    CompiledModel compiled(model, locate);
    check_functions(compiled);
    Equations equations(std::move(compiled), locate);
    static_cast<void>(equations.solver());
    return equations;
}

}  // namespace drover::physics
