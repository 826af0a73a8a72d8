// numerics/steppers/noise_path.hpp: the noise of a system as one function of time, shared by its steppers: a binary
// tree of increments.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/system.hpp"
#include "numerics/steppers/isotropic.hpp"

namespace drover::numerics {

/// One interval of a noise path: from index to index + 1 times its length, which is that of the roots/2^level.
struct NoiseInterval {
    int level = 0;
    std::uint64_t index = 0;
};

/// Increments of the linear law with noise, da = L a dt + noise, over the intervals of a binary tree of time: the roots
/// are dt 2^k long, the same for all dt that differ by a power of two, and noise_tree() divides an interval.  So an
/// increment is a function of (seed, interval, signed wavevector, law) alone: steps of dt and dt/2, and grids of N and
/// 2N points of the same cell, follow the same path, and a step that is rejected and divided keeps its noise.
class NoisePath {
public:
    /// `system` has noise.
    NoisePath(const System& system, double dt, std::uint64_t seed, Threads& threads, Stream stream = Stream::noise);

    /// Whether there is noise that is added to the fields: that of System::noise.
    bool has_sums() const { return static_cast<bool>(system_.noise); }
    /// That of System::product_noise; nullptr: none.
    NoisePath* of_products() { return of_products_.get(); }

    /// Level of the intervals of length dt.
    int level() const { return level_; }

    /// Computes the increments of all kept modes over an interval, from what is known of the intervals around it.
    void compute(const NoiseInterval& interval);

    /// The increments of the interval of that level that was computed last, for the kept modes of a row, in the
    /// variables of IsotropicBlocks: two numbers for each even part, then for each odd one.
    const double* row(int level, std::size_t row) const;

    /// Writes them as components of the fields, to the kept modes.
    void write(int level, Spectra& to);

private:
    struct Level {
        std::vector<double> draw;        ///< for each |q|: factor of the roots; regression, spread of first halves
        std::vector<double> propagator;  ///< for each |q|, over the interval; none for the roots
        std::vector<double> values;      ///< of the interval computed last
        std::uint64_t index = 0;
        bool is_known = false;
    };
    void prepare(int level);
    void draw_root(std::uint64_t index);
    void draw_first_half(int level, std::uint64_t index);
    void compute_second_half(int level);
    struct Mode;
    template <class Body>
    void for_modes(const RandomKey* key, Body body);

    System system_;
    DistinctWavenumbers wavenumbers_;
    std::uint64_t seed_;
    Stream stream_;
    Threads& threads_;
    int level_;
    double root_;                         ///< length [s]
    std::size_t numbers_;                 ///< of a mode
    std::vector<std::size_t> row_begin_;  ///< first mode of each row in `values`; the total at the end
    std::vector<Level> levels_;
    std::unique_ptr<NoisePath> of_products_;
};

/// For steps of dt and of its halves; nullptr without noise.
std::shared_ptr<NoisePath> make_noise_path(const System& system, double dt, std::uint64_t seed, Threads& threads);

/// Memory of a noise path for steps of dt that are halved up to `halvings` times [bytes].
double noise_path_bytes(const System& system, double dt, int halvings);

}  // namespace drover::numerics
