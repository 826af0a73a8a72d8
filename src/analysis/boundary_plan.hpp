// analysis/boundary_plan.hpp: the plane, the uncertain numbers and the lines of drover boundary, from a scene and as
// records.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "analysis/plane_models.hpp"
#include "io/scene.hpp"
#include "run/result.hpp"
#include "theory/boundary.hpp"

namespace drover::analysis {

struct PlannedBoundary {
    PlaneAxis x, y;
    std::vector<std::pair<PlaneNumber, double>> errors;  ///< standard errors, beside those of tables
    std::size_t draws = 0;                               ///< of uncertain numbers
    int cells = 64;                                      ///< as boundary.cells
    std::vector<std::string> conventions;                ///< of lambda; one that is empty in a model of one's own
    std::vector<std::string> lines;                      ///< at least one, binodals last

    numerics::Rectangle rectangle() const { return {.x0 = x.from, .x1 = x.to, .y0 = y.from, .y1 = y.to}; }
};

/// The lines that a plane may show: limits of stability in the limit of long waves, the binodals of phases that
/// coexist, and where a uniform state becomes unstable to any wave.
const std::vector<std::string>& line_names();
inline constexpr const char* binodal_name = "binodal";
inline constexpr const char *isotropic_line = "isotropic", *ordered_line = "ordered";
inline bool is_of_state(const std::string& line) { return line == isotropic_line || line == ordered_line; }

/// Whether a field of a scene turns.
bool has_order(const io::Scene& scene);

/// The component of a state with the density of an axis; -1: it is not the mean of a conserved scalar with a rate.
int density_component(const model::Equations& equations, const PlaneNumber& number);

/// Throws an input Error at the key that is wrong.
PlannedBoundary plan_boundary(const io::Scene& scene);

/// What is traced, and what its points show.
struct DescribedLines {
    std::string heading;
    std::vector<run::Entry> names = {};  ///< of the kind of line, in archives an entry of each vertex
    bool shows_angles = false, shows_waves = false;
};

run::Record traced_record(const PlannedBoundary& plane, const DescribedLines& described,
                          const theory::Boundary& boundary);

/// The plane with the lists of its lines.
run::Record plane_record(const PlannedBoundary& plane, bool complete, run::List traced);

/// Fields of draws over the plane, one for each kind of line.
class BandMaps {
public:
    explicit BandMaps(const PlannedBoundary& plane) : plane_(plane) {}
    void add(const DescribedLines& described, const theory::Boundary& boundary);
    /// Adds the group /band to a record, if there is any field.
    void add_to(run::Record& root) const;

private:
    PlannedBoundary plane_;
    std::vector<std::vector<run::Entry>> names_;
    std::vector<theory::DrawField> fields_;
};

/// The middles of side by side cells of a plane, rows of y first, and the axes of a map on them.
struct MapPoints {
    std::vector<numerics::PlanePoint> points;
    std::vector<files::Axis> axes;
};
MapPoints map_points(const PlannedBoundary& plane, int side);

}  // namespace drover::analysis
