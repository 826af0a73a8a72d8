// model/explicit_part.hpp: N of a system: the equations of a model less their exact linear part, on a grid.
#pragma once
#include <memory>
#include <vector>

#include "base/constants.hpp"
#include "drover/model/equations.hpp"
#include "drover/numerics/field.hpp"

namespace drover::model {

/// The values of a component at the points of an evaluation.
struct Range {
    double min = infinite, max = -min;
};

class ExplicitPart {
public:
    /// `linear`: of the same equations, on its grid.
    ExplicitPart(const Equations& equations, const numerics::System& linear, Threads& threads);
    ExplicitPart(ExplicitPart&&) noexcept;
    ~ExplicitPart();

    /// Writes the kept modes of `rate`; the others must already be zero.
    void operator()(double t, const numerics::Spectra& state, numerics::Spectra& rate);

    /// For steps of dt: where a mass that varies is so small that the drag of its field acts within a step, it is
    /// bounded below so that the drag acts over one: drag/mass <= 1/dt, but at most half of the mass at the references
    /// is replaced.  There the field follows the balance of forces anyway, and the explicit part could not follow it
    /// faster.  With mass^16 in the bound, masses above twice the floor change by less than 1e-6.  0: no bound.
    void set_step(double dt);
    /// The lower bound of the mass of a field, as a part of the mass at the references; 0 for none.
    double mass_floor(std::size_t field) const;

    /// The modes of the given components, in their order, in place of those of their point sources, for the calls to
    /// come.
    void set_given(std::vector<const numerics::Complex*> arrays);

    /// Finds the extremes of a component in every evaluation that reads it at points; for others they are infinite.
    void watch(int component);
    Range range(int component) const;

    /// All components in balance on the grid, in their order.
    numerics::Fields balanced(double t, const numerics::Spectra& state) const;

    /// Memory that it holds [bytes], without the fields.
    static double bytes(const Equations& equations, const numerics::Grid& grid, int degree);

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace drover::model
