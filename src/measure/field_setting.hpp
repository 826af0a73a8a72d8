// measure/field_setting.hpp: the fields, grid, modes, boxes and bins that the observables of fields share.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/measure/statistics.hpp"
#include "drover/model/equations.hpp"
#include "drover/numerics/grid.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::measure {

/// A field, as observables name it.
struct MeasuredField {
    std::string name, symbol, unit;
    std::string short_name;               ///< in structure factors
    std::string counted;                  ///< what number fluctuations count; "": nothing
    std::vector<std::string> components;  ///< their names
    std::size_t field = 0;                ///< its place in the model
    int spin = 0;
    int first = 0;               ///< its first component: those of a state, then those in balance
    bool is_solenoidal = false;  ///< has no part along q
    bool name_first = false;     ///< model::Observed
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

}  // namespace drover::measure
