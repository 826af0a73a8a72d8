// analysis/plane_models.hpp: the models of a scene over a plane of its numbers, and draws of its uncertain numbers.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/scene.hpp"
#include "theory/limits.hpp"

namespace drover::analysis {

/// The part of a scene that has its equations.
struct SceneModel {
    physics::ModelValues model;
    io::DeclaredModel declared;
};
inline SceneModel scene_model(const io::Scene& scene) { return {.model = scene.model, .declared = scene.declared}; }

/// A number of the model, a mean density or an area fraction, as an axis of a plane.
struct PlaneNumber {
    std::string name;        ///< "driving.strength", "coefficients.a", "uniform.rod_density", "rod_area_fraction"
    std::string unit = "1";  ///< as written in scenes
    Range range = any_number;
    std::function<double(const SceneModel&)> get;
    std::function<void(SceneModel&, double)> set;
    std::string density;       ///< the field of a mean density; "": none
    double area = 1.0;         ///< of a density: its value on the axis over the density [mm^2]; 1: that of a mean
    bool is_fraction = false;  ///< an area fraction: the density times the area of one particle
};
/// list: what names it, for messages.  Throws an input Error at `where` for a name that is none.
PlaneNumber plane_number(const io::Scene& scene, const std::string& list, const std::string& name,
                         const SourceLocation& where);
/// Whether it is a mean density or an area fraction of the same field, or the same number.
bool are_same(const PlaneNumber& one, const PlaneNumber& other);

/// Models at the points of a plane.
class PlaneModels {
public:
    /// `like`: of the same plane with other numbers, with which it shares what it can.  Throws where the middle of the
    /// plane has no valid model.
    PlaneModels(io::SceneKind kind, SceneModel base, PlaneNumber x, PlaneNumber y, const numerics::Rectangle& plane,
                const PlaneModels* like = nullptr);

    /// The margin of a limit.  Throws an input Error that names a point whose model is invalid.
    theory::Margin margin(const numerics::PlanePoint& point, theory::Limit limit) const;
    /// The equations at a point.  Throws the same.
    model::Equations equations(const numerics::PlanePoint& point) const;
    bool has_order() const { return has_order_; }

private:
    SceneModel changed(const numerics::PlanePoint& point) const;
    theory::Margin margin_of_changes(const numerics::PlanePoint& point, theory::Limit limit) const;
    std::string place_of(const numerics::PlanePoint& point) const;
    /// Of rods and beads: with the mean densities of a model.
    model::UniformState means_of(const SceneModel& changed) const;

    io::SceneKind kind_;
    SceneModel base_;
    PlaneNumber x_, y_;
    bool has_order_ = false;
    theory::OrderSearch search_;
    // Of rods and beads, at the middle.
    std::shared_ptr<const physics::Equations> compiled_;
    std::shared_ptr<const theory::PointTheory> theory_;
    std::vector<std::pair<std::size_t, PlaneNumber>> densities_;  // by component
    model::UniformState means_;                                   // of the base
    /// What an axis changes, where that is a mean density or the constant coefficient of some terms.
    struct Change {
        int component = -1;              ///< of the density; -1: none
        std::vector<std::size_t> terms;  ///< of the coefficient
        double base = 1.0;
    };
    /// least: its smallest value in the plane.
    std::optional<Change> change_of(const PlaneNumber& number, const SceneModel& middle, double min_value) const;
    std::optional<Change> x_change_, y_change_;
};

/// The scene with its uncertain numbers drawn within their errors: those of tables, and those of `errors` by key.
/// Fewer where draws are no valid models; empty if there are no such numbers.
std::vector<SceneModel> drawn_scenes(const io::Scene& scene, const std::vector<std::pair<std::string, double>>& errors);

}  // namespace drover::analysis
