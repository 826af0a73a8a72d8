// physics/equations.cpp: the equations of a model by the model layer, and their linearisations.
#include "physics/equations.hpp"

#include <algorithm>
#include <mutex>
#include <optional>

#include "physics/program_functions.hpp"
#include "physics/written_model.hpp"

namespace drover::physics {

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
}  // namespace

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

}  // namespace drover::physics
