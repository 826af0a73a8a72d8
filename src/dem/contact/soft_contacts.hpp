// dem/contact/soft_contacts.hpp: contacts of soft bodies: forces that grow with the overlap, and springs that last as
// long as a contact.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/bodies/plate_motion.hpp"
#include "dem/contact/contact_law.hpp"
#include "dem/contact/contact_report.hpp"
#include "dem/flight/rod_flight.hpp"

namespace drover::dem {

/// One contact.  Its spheres are identified for good: beads by their number in the caller's list, rod spheres by their
/// index.
struct SoftRecord {
    std::uint32_t first = 0, second = 0;  ///< first < second; `second` may be a surface of Overlap
    double overlap = 0.0;                 ///< [mm]
    Vector normal;                        ///< towards first
    Vector arm_first, arm_second;         ///< from the centres of mass to the point of contact [mm]
    Vector surface_velocity;              ///< [mm/s]
    Vector force;                         ///< on first [mg mm/s^2]
    double damping = 0.0;                 ///< its dissipative normal part
    Vector stretch;                       ///< of the tangential spring [mm]
    double stored = 0.0;                  ///< elastic energy [mg mm^2/s^2]
    double ahead = 0.5;                   ///< share of the next step for which its force has acted already
};

/// All contacts of a world.
///
/// A step is kick(dt/2), free motion for dt, find(), apply(law), kick(dt/2): velocity Verlet.  Damping uses velocities
/// that are advanced to the end of the step with the forces at its start.  Where a contact begins or ends within a
/// step, forces that jump there are weighted by the time in contact.  Momentum is conserved to rounding; the energy
/// balance closes to O(dt^2).
class SoftContacts {
public:
    /// Changes velocities by the forces over half a step.  at_start: the half before the motion.
    void kick(Spheres& spheres, const StepRules& rules, bool at_start, EnergyBalance& balance);

    /// Finds all contacts at the end of the step.  Those of the last step keep their springs.
    void find(const Walls& walls, const Spheres& spheres, const Neighbours& neighbours, const PlateMotion& plates,
              const StepRules& rules, Threads& threads, ContactReport& report);

    template <SoftLaw Law>
    void apply(const Law& law, ContactReport& report) {
        for (std::size_t c = 0; c < records_.size(); ++c) set_force(law(contacts_[c]), records_[c], report);
    }

    /// Changes the spins of rods whose contacts with the plates began in this step.
    void kick_rods(Spheres& spheres, const StepRules& rules, ContactReport& report) const;

    /// Elastic energy of all contacts [mg mm^2/s^2].
    double energy() const;

    /// The state that passes from step to step.
    std::vector<SoftRecord>& records() { return records_; }

private:
    /// An impact of a rod on a plate that began in this step.
    struct Start {
        std::uint32_t rod = 0;
        double approach = 0.0;
    };

    static void set_force(const SoftForce& force, SoftRecord& record, ContactReport& report);
    void set_slots(const Spheres& spheres);
    std::uint32_t slot_of(std::uint32_t sphere) const { return sphere < slot_.size() ? slot_[sphere] : sphere; }
    std::int32_t local_body(const Spheres& spheres, std::uint32_t body);
    void clear_bodies();
    ImpactBody predicted(const Spheres& spheres, std::size_t local) const;
    Contact contact_of(const SoftRecord& record, const Spheres& spheres);
    void add_overlap(Overlap overlap, const Spheres& spheres);
    void add_plates(const Spheres& spheres, const PlateMotion& plates, double dt);
    void sort_overlaps(const Spheres& spheres);
    SoftRecord record_of(const Overlap& overlap, const Spheres& spheres, const PlateState& base) const;
    const SoftRecord* previous_of(const SoftRecord& record) const;
    void set_contact(std::size_t c, const Spheres& spheres, const std::vector<ImpactBody>& end_bodies,
                     const StepRules& rules, ContactReport& report);

    OverlapSearch search_;
    std::vector<Overlap> overlaps_;           // of the records
    std::vector<SoftRecord> records_, last_;  // sorted by spheres
    std::vector<SoftContact> contacts_;       // of the records
    std::vector<Start> starts_;
    std::vector<std::uint32_t> slot_;                        // index now of each bead
    std::vector<ImpactBody> bodies_;                         // those in contact
    std::vector<std::uint32_t> indices_;                     // of bodies_
    std::vector<std::int32_t> local_;                        // index in bodies_ of every body, or -1
    std::vector<Vector> velocity_change_, momentum_change_;  // of every body by the first kick of the step
};

}  // namespace drover::dem
