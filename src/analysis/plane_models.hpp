// analysis/plane_models.hpp: the models of a scene over a plane of its numbers, and draws of its uncertain numbers.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/scene.hpp"
#include "physics/equations.hpp"
#include "theory/limits.hpp"

namespace drover::analysis {

/// A number of the model, a mean density or an area fraction, as an axis of a plane.
struct PlaneNumber {
    std::string name;        ///< "driving.strength", "coefficients.a", "uniform.rod_density", "rod_area_fraction"
    std::string unit = "1";  ///< as written in scenes
    Range range = any_number;
    std::string key;           ///< what it sets: a key of a scene; of a model of one's own a symbol or a coefficient
    std::string density;       ///< the field of a mean density; "": none
    double area = 1.0;         ///< of a density: its value on the axis over the density [mm^2]; 1: that of a mean
    bool is_fraction = false;  ///< an area fraction: the density times the area of one particle

    double in(const io::Scene& scene) const;
    void set(io::Scene& scene, double value) const;
};
/// One with its values in a plane.
struct PlaneAxis : PlaneNumber {
    std::string udunits = "1";  ///< the unit as UDUNITS text
    double from = 0.0, to = 1.0;
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
    PlaneModels(io::Scene base, PlaneAxis x, PlaneAxis y, const PlaneModels* like = nullptr);

    /// use(margin): what margin(limit) gives is of one model, whose states are searched once.  Throws an input Error
    /// that names a point whose model is invalid.
    using MarginOfLimit = std::function<theory::Margin(theory::Limit)>;
    void visit(const numerics::PlanePoint& point, const std::function<void(const MarginOfLimit&)>& use) const;
    theory::Margin margin(const numerics::PlanePoint& point, theory::Limit limit) const;  ///< throws the same
    /// The equations at a point.  Throws the same.
    model::Equations equations(const numerics::PlanePoint& point) const;

private:
    io::Scene changed(const numerics::PlanePoint& point) const;
    void visit_changes(const numerics::PlanePoint& point, const std::function<void(const MarginOfLimit&)>& use) const;
    void visit_theory(const theory::PointTheory& theory, const model::UniformState& means,
                      const std::function<void(const MarginOfLimit&)>& use) const;
    std::string place_of(const numerics::PlanePoint& point) const;
    /// Of rods and beads: with the mean densities of a model.
    model::UniformState means_of(const physics::ModelValues& model) const;

    io::Scene base_;
    PlaneAxis x_, y_;
    theory::OrderSearch search_;
    // Of rods and beads, at the middle.
    std::shared_ptr<const physics::Equations> compiled_;
    std::shared_ptr<const theory::PointTheory> theory_;
    model::UniformState means_;  // of the base
    /// What an axis changes, where that is a mean density or the constant coefficient of some terms.
    struct Change {
        int component = -1;              ///< of the density; -1: none
        std::vector<std::size_t> terms;  ///< of the coefficient
        double base = 1.0;
    };
    std::optional<Change> change_of(const PlaneAxis& axis, const io::Scene& middle) const;
    std::optional<Change> x_change_, y_change_;
};

/// The scene with its uncertain numbers drawn within their errors: those of tables, and those of `errors`.
/// Fewer where draws are no valid models; empty if there are no such numbers.
std::vector<io::Scene> drawn_scenes(const io::Scene& scene, const std::vector<std::pair<PlaneNumber, double>>& errors);

}  // namespace drover::analysis
