#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "synth/modal/near_critical.hpp"
#include "synth/modal/resonators.hpp"
#include "synth/modal/row_response.hpp"

namespace carillon::synth::modal {

/// The free motion of the modes that a row hears, displacement and velocity, some time before its
/// next sample. A mode whose weights are zero at its pole counts as at rest, as does one that has
/// died away.
/// @param before   [s], less than a sample
/// @param motions  one for each mode; set
void find_motions(const Resonances& resonances, const Readout& readout, Eigen::Index row,
                  std::span<const Voice> voices, std::span<const NearCritical> near_critical,
                  double before, std::span<ModalMotion> motions);

/// Adds `factor` times the motion that respond() does not leave to free partials while a force
/// acts: the forced motion, or all of it where it has none of its own.
/// @param t  since the force's begin, at most its duration [s]
void add_contact_motions(const Resonances& resonances, const Eigen::VectorXd& excitation,
                         const ContactForce& force, double t, double factor,
                         std::span<ModalMotion> motions);

/// The reverse of find_motions(): what rings on from the motions.
/// @param voices, near_critical  emptied first; allocate nothing where they have room for all
void ring_from(const Resonances& resonances, const Readout& readout, Eigen::Index row,
               std::span<const ModalMotion> motions, double before, std::vector<Voice>& voices,
               std::vector<NearCritical>& near_critical);

}  // namespace carillon::synth::modal
