// measure/fields.hpp: the observables of fields: the same for every field, and those of bodies that fields describe;
// and the fields, grid, modes, boxes and bins that they share.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/measure/statistics.hpp"
#include "drover/model/equations.hpp"
#include "drover/numerics/field.hpp"
#include "drover/numerics/grid.hpp"
#include "measure/observable.hpp"
#include "measure/summary.hpp"
#include "model/energy.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::measure {

/// A field, as observables name it.
struct MeasuredField : model::Field {
    std::string short_name;               ///< in structure factors
    std::string counted;                  ///< what number fluctuations count; "": nothing
    std::vector<std::string> components;  ///< their names
    std::size_t field = 0;                ///< its place in the model
    int first = 0;                        ///< its first component: those of a state, then those in balance
};

/// The name of the cross structure factor of two fields.
inline std::string cross_name(const MeasuredField& a, const MeasuredField& b) {
    return "structure_factor_" + a.short_name + "_" + b.short_name;
}

/// A vector of bodies: the order of rods, the flow of beads.
struct BodyVector {
    int first = 0;        ///< its first component
    int density = -1;     ///< of the bodies; -1: they are uniform
    bool is_sum = false;  ///< over the bodies of a unit of area, not their mean
};

/// The energy of a field, as observables name it.
struct MeasuredEnergy {
    std::string name;  ///< "flow" of energy_flow
    std::string unit;
    std::string of;       ///< for people: "bead velocity"
    std::string formula;  ///< "m rho |v|^2/2"
};

/// What the observables of a run need, prepared once.
struct FieldSetting {
    numerics::Grid grid;
    numerics::Shells shells;
    numerics::Sectors sectors;
    std::vector<int> boxes;                         ///< box sides, in cells: a box has as many cells along x as along y
    std::vector<int> long_boxes;                    ///< shorter sides of the boxes with the aspect ratio 4, in cells
    int degree = 1;                                 ///< of the products: sets which modes are kept
    std::vector<double> separations;                ///< mean distance in each bin of the pair correlation [mm]
    std::vector<int> separation_bin;                ///< of each grid point as a displacement, -1 for none
    std::optional<std::vector<std::string>> terms;  ///< whose powers are measured; nullopt: no energy budget
    bool watches_error = true;                      ///< the run estimates the error of its time steps
    std::vector<MeasuredEnergy> energies;           ///< in the order of model::energies_of()
    std::vector<MeasuredField> fields;              ///< in the order of their observables
    int of_state = 0;                               ///< components of a state
    int in_balance = 0;                             ///< components in balance
    std::optional<BodyVector> order, flow;          ///< of bodies; the flow is a velocity
};
inline double cell_width(const FieldSetting& setting) { return setting.grid.lx / setting.grid.nx; }
inline double cell_height(const FieldSetting& setting) { return setting.grid.ly / setting.grid.ny; }
FieldSetting make_field_setting(const model::Equations& equations, const numerics::Grid& grid, int degree);

/// The name of the field of a vector of bodies; "": there is none.
std::string name_of(const FieldSetting& setting, const std::optional<BodyVector>& vector);

/// Boxes of one shape, by size.  The names of their observables end in `ending`.
struct BoxFamily {
    const char* ending;
    const char* shape;                      ///< for people
    std::vector<int> FieldSetting::*sides;  ///< the shorter side, in cells
    int along_x, along_y;                   ///< sides in units of the shorter one
};
/// Boxes with equal numbers of cells along x and y, and with four times as many along one, which resolve the directions
/// of a flock.
std::span<const BoxFamily> box_families();

/// For people: "square box" where cells are square.
std::string shape_of(const BoxFamily& family, const FieldSetting& setting);

/// "mean_phi", of a part "mean_p_x", or with the name of the field first.
std::string statistic_name(const MeasuredField& field, const std::string& statistic, std::size_t part);
std::string statistic_name(const MeasuredField& field, const std::string& statistic);
/// Of the number of bodies in the cell.
std::string total_name(const MeasuredField& field);

inline constexpr int direction_sectors = 8;

/// |a_q|^2 of each stored mode: of a scalar `along` alone; of a spin m its parts along and across q, cos(m theta) F_1 +
/// sin(m theta) F_2 and -sin(m theta) F_1 + cos(m theta) F_2, theta the angle of q, 0 at q = 0.
struct FieldPowers {
    std::vector<double> along, across;
    std::vector<double> sum;            ///< of both
    double variance = 0.0, tail = 0.0;  ///< over the cell; tail: in the outer third of the kept modes
};

/// One moment of a run.  The powers are computed on construction, once for all observables.
struct FieldMoment {
    const FieldSetting& setting;
    const numerics::Spectra& state;  ///< and on the grid:
    const numerics::Fields& state_on_grid;
    const numerics::Spectra& balanced;  ///< fields in balance, and on the grid:
    const numerics::Fields& balanced_on_grid;
    std::optional<model::EnergyBudget> energy = {};  ///< when it is measured
    double step_error = 0.0;                         ///< as numerics::StepError estimates it
    std::vector<FieldPowers> powers = powers_of(*this);

    std::span<const numerics::Complex> modes(int component) const {
        return component < state.count() ? state[component] : balanced[component - state.count()];
    }
    std::span<const double> points(int component) const {
        return component < state.count() ? state_on_grid[component] : balanced_on_grid[component - state.count()];
    }
    static std::vector<FieldPowers> powers_of(const FieldMoment& moment);
};

/// Whether a mode lies beyond two thirds of the cut of the grid on either axis: observables spectral_tail_*.
bool is_in_tail(const numerics::Grid& grid, int degree, std::size_t column, std::size_t row);
/// The part of the variance of `count` components that is in these waves; 0 where they do not vary.
double tail_of(const numerics::Grid& grid, int degree, const numerics::Spectra& state, int first, int count);

/// The observables: of every field its mean, extremes, variance, spectral tail, structure factors and correlation; of
/// densities the number fluctuations in boxes; of pairs of scalars the cross structure factors; of bodies their order
/// and flow; those of the energy budget when the setting has terms.
Observables<FieldMoment> field_observables(const FieldSetting& setting);

/// The recorded series with what their summary needs.  Numbers of bodies are those of the first sample: they are
/// conserved, and a start from a file may have other means than the uniform state of the scene.
Recorded field_recording(const FieldSetting& setting, std::vector<RecordedSeries> series);

}  // namespace drover::measure
