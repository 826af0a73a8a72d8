// physics/term.hpp: the terms as rows: each with its exact linearisation and its action at points of the grid.
#pragma once
#include <Eigen/Core>
#include <complex>
#include <span>
#include <string>
#include <string_view>

#include "drover/numerics/grid.hpp"
#include "drover/physics/model.hpp"

namespace drover::physics {

/// Places in a Symbol, whatever the form.
struct FieldIndex {
    enum Value : int {
        bead_density,
        rod_density,
        bead_velocity_x,
        bead_velocity_y,
        polar_order_x,
        polar_order_y,
        count
    };
};

/// d/dt of small deviations ~ exp(i q.r) from a uniform state: rates = symbol * deviations.  The velocity rows hold forces on the
/// beads [mg/(mm^2 s^2)...], before what they have to move is divided out.
using Symbol = Eigen::Matrix<std::complex<double>, FieldIndex::count, FieldIndex::count>;

/// Fields at some points of the grid; null where not needed.
template <class Number>
struct VectorStrip {
    Number* x = nullptr;
    Number* y = nullptr;
};
struct PointFields {
    std::size_t size = 0;
    const double* bead_density = nullptr;
    const double* rod_density = nullptr;
    VectorStrip<const double> velocity;         ///< of the beads, v
    VectorStrip<const double> linear_velocity;  ///< slaved: v by the linear part alone; dynamic: v
    VectorStrip<const double> order;            ///< p
    VectorStrip<const double> linear_force;     ///< on the beads, by the linear part [mg/(mm s^2)]
    const double* velocity_curl = nullptr;      ///< d_x v_y - d_y v_x
    const double* order_curl = nullptr;         ///< d_x p_y - d_y p_x
};

/// What the terms add there, beyond the linear part.  Heads: their gradients are added to the rate.
struct PointRates {
    VectorStrip<double> bead_flux, rod_flux;  ///< d_t rho = -div of it, d_t sigma = -div of it
    VectorStrip<double> force;                ///< on the beads
    VectorStrip<double> velocity, order;      ///< d_t v, d_t p
    double* velocity_head = nullptr;
    double* order_head = nullptr;
};

/// What a term reads and writes at points: each costs transforms (a vector two).
enum Input : unsigned {
    reads_beads = 1,
    reads_rods = 2,
    reads_velocity = 4,
    reads_order = 8,
    reads_velocity_curl = 16,
    reads_order_curl = 32
};
enum Output : unsigned {
    writes_bead_flux = 1,
    writes_rod_flux = 2,
    writes_force = 4,
    writes_velocity = 8,
    writes_order = 16,
    writes_velocity_head = 32,
    writes_order_head = 64
};
struct Action {
    unsigned reads = 0, writes = 0;  ///< none: the term is linear
    int degree = 1;                  ///< of its products
};

/// One term.  To add another: its struct in terms.hpp, its functions in terms.cpp, its row in terms().
struct Term {
    const char* name;  ///< its table in the scene
    bool (*is_active)(const Equations&);
    std::string (*equation)(const Equations&);  ///< for people
    /// Adds the exact linearisation about a uniform state.
    void (*linearise)(const Equations&, const UniformPoint& about, const numerics::Wavevector& q, Symbol& symbol);
    /// What the action costs; nullptr: the term is linear.
    Action (*cost)(const Equations&);
    /// Adds the term less its linearisation about the reference.  Reads fields, writes rates, allocates nothing.
    void (*act)(const Equations&, const Reference&, const PointFields& fields, const PointRates& rates);
};

/// All terms, in the order of the equations.
std::span<const Term> terms();

/// Whether a term is a force on the beads.
bool is_force_on_beads(const Term& term);

/// Whether a term, by its name, has a part in a model.
bool has_term(const Equations& equations, std::string_view name);

/// Sum of the linearisations of the active terms; forces on the beads not yet divided by what they move.
Symbol force_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// The linearised equations of the form about any uniform state: rows and columns of absent fields are zero, a slaved velocity is
/// eliminated.  Exact for any state, stationary or not.
Symbol linear_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

}  // namespace drover::physics
