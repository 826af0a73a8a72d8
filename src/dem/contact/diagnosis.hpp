// dem/contact/diagnosis.hpp: what became non-finite or overlapped too far, and why, for the messages of a failed run.
#pragma once
#include <string>

#include "dem/neighbours/overlaps.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

/// A sphere, or a surface of Overlap.
Name name_of(const Spheres& spheres, std::uint32_t sphere);

/// The first body with a position, velocity, axis or spin that is not finite, and its value; empty if there is none.
std::string first_non_finite(const Spheres& spheres);

/// The first body that moves by more than its radius in a step [s], so that it could pass through others, and what to
/// change; empty if there is none.
std::string first_too_fast(const Spheres& spheres, double step);

/// A contact whose impulse is not finite: its bodies with their state before the impact, and its coefficients.
std::string describe_impact(const Overlap& overlap, const Spheres& spheres, double restitution, double friction,
                            std::size_t contacts);

/// Speed at which two overlapping spheres, or a sphere and a surface at rest, approach [mm/s]; < 0: they part.
double closing_speed(const Overlap& overlap, const Spheres& spheres);

/// The step within which two bodies come to overlap, and its input key.
struct NamedStep {
    const char* key;
    double length;  ///< [s]
};

/// Why two bodies overlap too far, and what to change.  closing: their speed of approach at the time.
std::string cause_of_overlap(const Setup& setup, double depth, double radius, double closing, const NamedStep& step);

/// The input keys behind the work that is not finite, or else the largest.
std::string cause_of_energy(const EnergyBalance& balance);

}  // namespace drover::dem
