// analysis/boundary_records.hpp: the plane, the lines and the map of drover boundary as records.
#pragma once
#include <string>
#include <vector>

#include "analysis/boundary_plan.hpp"
#include "run/result.hpp"
#include "theory/boundary.hpp"

namespace drover::analysis {

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
