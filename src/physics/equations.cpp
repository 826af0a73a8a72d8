// physics/equations.cpp: the equations of a model by the model layer, and their linearisations.
#include "drover/physics/equations.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "program_functions.hpp"
#include "rod_bead.hpp"
#include "text_terms.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;
constexpr int rho = FieldIndex::bead_density, sigma = FieldIndex::rod_density, v_x = FieldIndex::bead_velocity_x,
              p_x = FieldIndex::polar_order_x;

bool is_same(const UniformPoint& a, const UniformPoint& b) {
    return a.bead_density == b.bead_density && a.rod_density == b.rod_density && a.velocity == b.velocity &&
           a.order == b.order;
}
}  // namespace

/// What was asked for last: linear theory asks for many wavevectors about each state.
struct Equations::Cache {
    std::mutex mutex;
    std::optional<UniformPoint> about;
    std::shared_ptr<const model::LinearisedAt> linearised;
    std::optional<model::Equations> solver;  // about the uniform state of the model
};

Equations::Equations(const Model& the_model) : CompiledModel(the_model) { compile(nullptr); }
Equations::Equations(const Model& the_model, const Equations& like) : CompiledModel(the_model, like) {
    const auto ratios = ratios_of_terms(like, *this);
    if (!ratios) {
        compile(like.has_all_ ? nullptr : &like.only_);
        return;
    }
    forces_ = like.forces_;
    terms_ = like.terms_;
    only_ = like.only_;
    has_all_ = like.has_all_;
    components_ = like.components_;
    factors_ = like.factors_;
    cache_ = std::make_shared<Cache>();
    for (std::size_t n = 0; n < terms_.size(); ++n)
        if (const auto ratio = ratios->find(terms_[n]); ratio != ratios->end()) factors_[n] *= ratio->second;
}

Equations Equations::only(const std::vector<std::string>& names) const {
    Equations result = *this;
    result.compile(&names);
    return result;
}

void Equations::compile(const std::vector<std::string>* only) {
    has_all_ = only == nullptr;
    if (only != nullptr) only_ = *only;
    cache_ = std::make_shared<Cache>();
    const WrittenModel written = write_model(*this, Written::forces, only);
    forces_ = std::make_shared<const model::Equations>(written.model);
    terms_ = written.terms;
    factors_.assign(terms_.size(), 1.0);
    components_.fill(-1);
    int next = 0;
    for (const model::Field& field : written.model.fields) {
        const int first = field.symbol == "rho"     ? rho
                          : field.symbol == "sigma" ? sigma
                          : field.symbol == "v"     ? v_x
                                                    : p_x;
        for (int k = 0; k < model::components(field) && field.left != model::LeftSide::given; ++k)
            components_[static_cast<std::size_t>(first + k)] = next + k;
        next += model::components(field);
    }
    if (model.text_terms.empty()) return;
    const bool pointwise = has_pointwise_velocity(*this);
    for (std::size_t n = 0; n < terms_.size(); ++n)
        for (std::size_t k = 0; k < model.text_terms.size(); ++k)
            if (terms_[n] == text("terms[{}]", k + 1))
                check_admissible(*this, model.text_terms[k], forces_->terms()[n], forces_->is_isotropic(n),
                                 component(v_x), pointwise);
}

model::Equations Equations::solver(const Reference& about) const {
    std::optional<model::Equations> base;
    {
        const std::lock_guard lock(cache_->mutex);
        if (!cache_->solver)
            cache_->solver.emplace(write_model(*this, Written::solver, has_all_ ? nullptr : &only_).model);
        base = cache_->solver;
    }
    model::UniformState state = base->reference();
    const auto set = [&](int field, double value) {
        const int at = component(field);
        if (at < 0 || state[static_cast<std::size_t>(at)] == value) return false;
        state[static_cast<std::size_t>(at)] = value;
        return true;
    };
    const bool beads = set(rho, about.bead_density), rods = set(sigma, about.rod_density);
    return beads || rods ? base->about(state) : *base;
}

bool Equations::is_force(std::size_t term) const {
    return component(v_x) >= 0 && forces_->model().fields[forces_->terms()[term].field].symbol == "v";
}

namespace {
/// Of all components of forces().
model::UniformState state_of(const Equations& e, const UniformPoint& at) {
    const std::array<double, FieldIndex::count> values{at.bead_density, at.rod_density, at.velocity.x(),
                                                       at.velocity.y(), at.order.x(),   at.order.y()};
    model::UniformState state(static_cast<std::size_t>(e.forces().components()), 0.0);
    for (int k = 0; k < FieldIndex::count; ++k)
        if (const int place = e.component(k); place >= 0)
            state[static_cast<std::size_t>(place)] = values[static_cast<std::size_t>(k)];
    return state;
}

/// m rho d_t v is the force on the beads, or that is 0.
model::LeftSides left_sides(const Equations& e, const UniformPoint& about) {
    const int components = e.forces().components(), beads = e.component(rho);
    const Noise& noise = e.model.noise;
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(components);
    model::LeftSides left{.moved = Eigen::VectorXd::Ones(components),
                          .noise = zero,
                          .flux_noise = zero,
                          .direction = direction_of(about)};
    if (beads >= 0) left.flux_noise(beads) = noise.beads;
    if (e.component(sigma) >= 0) left.flux_noise(e.component(sigma)) = noise.rods;
    left.noise.segment<2>(e.component(p_x)).setConstant(noise.order);
    const int v = e.component(v_x);
    if (v < 0) return left;
    const double mass = e.form.velocity == Velocity::dynamic ? e.model.inertia.bead_mass : 0.0;
    left.noise.segment<2>(v).setConstant(noise.velocity);
    left.moved.segment<2>(v).setConstant(mass * about.bead_density);
    if (beads < 0 || mass == 0.0) return left;
    left.slopes = Eigen::MatrixXd::Zero(components, components);
    left.slopes.block<2, 1>(v, beads).setConstant(mass);
    return left;
}
}  // namespace

Eigen::VectorXd Equations::uniform_forces(const UniformPoint& at) const {
    require_functions(model);
    return forces_->uniform_rates(state_of(*this, at), factors_);
}

std::shared_ptr<const model::LinearisedAt> Equations::linearised(const UniformPoint& about) const {
    require_functions(model);
    for (std::size_t n = 0; n < terms_.size(); ++n)
        require(!forces_->terms()[n].is_placed, {},
                "{} depends on position or time: no uniform state exists, so linear wave theory does not apply",
                terms_[n]);
    {
        const std::lock_guard lock(cache_->mutex);
        if (cache_->about && is_same(*cache_->about, about)) return cache_->linearised;
    }
    const model::UniformState state = state_of(*this, about);
    model::LeftSides left = left_sides(*this, about);
    left.factors = factors_;
    std::shared_ptr<const model::LinearisedAt> found;
    try {
        found = std::make_shared<const model::LinearisedAt>(*forces_, state, std::move(left));
    } catch (const Error&) {
        for (std::size_t n = 0; n < terms_.size(); ++n)
            require(forces_->has_derivative(n, state), {},
                    "{} has no finite derivative in the uniform state of |p| = {:.4g}; expected one: linear theory "
                    "about this state does not exist",
                    terms_[n], about.order.norm());
        throw;
    }
    const std::lock_guard lock(cache_->mutex);
    cache_->about = about;
    cache_->linearised = found;
    return found;
}

void check(const Model& model, const LocationOf& location_of) {
    check_numbers(model, location_of);
    check_functions(CompiledModel(model));
    static_cast<void>(Equations(model));
}

std::vector<std::string> written_terms(const Equations& equations) {
    std::map<std::string, std::string> of_scene;
    for (const SceneTerm& term : scene_terms(equations)) of_scene[term.written.name] = term.equation;
    std::vector<std::string> result;
    for (std::size_t n = 0; n < equations.terms().size(); ++n) {
        const auto found = of_scene.find(equations.terms()[n]);
        result.push_back(found == of_scene.end() ? equations.forces().terms()[n].text : found->second);
    }
    return result;
}

bool has_pointwise_velocity(const Equations& equations) {
    if (equations.form.velocity != Velocity::slaved) return false;
    const std::vector<model::TermSummary>& terms = equations.forces().terms();
    for (std::size_t n = 0; n < terms.size(); ++n)
        if (equations.is_force(n) &&
            (!terms[n].is_linear || terms[n].is_placed ||
             (equations.terms()[n].starts_with("terms[") && !equations.forces().is_isotropic(n))))
            return true;
    return false;
}

}  // namespace drover::physics
