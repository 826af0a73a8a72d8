// analysis/boundary_records.hpp: the plane, the lines and the map of drover boundary as records.
#pragma once
#include <string>
#include <vector>

#include "run/result.hpp"
#include "theory/boundary.hpp"

namespace drover::analysis {

/// One axis of a plane, as files and people read it.
struct DescribedAxis {
    std::string name;
    std::string unit;     ///< as written in scenes
    std::string udunits;  ///< UDUNITS text
    double from = 0.0, to = 1.0;
};

struct DescribedPlane {
    DescribedAxis x, y;
    std::size_t draws = 0;  ///< of uncertain numbers
    int cells = 64;         ///< as boundary.cells
};

/// What is traced, and what its points show.
struct DescribedLines {
    std::string heading;
    std::vector<run::Entry> names = {};  ///< of the kind of line, in archives an entry of each vertex
    bool shows_angles = false, shows_waves = false;
};

run::Record traced_record(const DescribedPlane& plane, const DescribedLines& described,
                          const theory::Boundary& boundary);

/// The plane with the lists of its lines.
run::Record plane_record(const DescribedPlane& plane, bool complete, run::List traced);

/// Fields of draws over the plane, one for each kind of line.
class BandMaps {
public:
    explicit BandMaps(const DescribedPlane& plane) : plane_(plane) {}
    void add(const DescribedLines& described, const theory::Boundary& boundary);
    /// Adds the group /band to a record, if there is any field.
    void add_to(run::Record& root) const;

private:
    DescribedPlane plane_;
    std::vector<std::vector<run::Entry>> names_;
    std::vector<theory::DrawField> fields_;
};

/// The middles of side by side cells of a plane, rows of y first, and the axes of a map on them.
struct MapPoints {
    std::vector<numerics::PlanePoint> points;
    std::vector<files::Axis> axes;
};
MapPoints map_points(const DescribedPlane& plane, int side);

}  // namespace drover::analysis
