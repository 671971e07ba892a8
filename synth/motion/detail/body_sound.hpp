#pragma once

#include <optional>
#include <span>
#include <vector>

#include "synth/motion/detail/contact_places.hpp"
#include "synth/motion/detail/driven_modes.hpp"
#include "synth/motion/detail/moving_gains.hpp"
#include "synth/motion/motion_sound.hpp"

namespace carillon::synth::motion {

/// Whether a body has modes.
bool sounds(const SoundingBody& body);

/// Course of a strike's force.
modal::ContactForce pulse_of(const Impact& impact, const MotionSoundOptions& options);

/// Forces of the lasting contacts, each computed once for both of its bodies.
class ContactForces {
 public:
  ContactForces(const Motion& motion, std::span<const MovingBody> moving,
                std::span<const SoundingBody> bodies, const MotionSoundOptions& options)
      : forces_(motion, moving, with_rate(options)), found_(motion.contacts.size()) {
    for (const LastingContact& contact : motion.contacts) {
      std::size_t& last = last_.emplace_back(0);
      for (const std::size_t body : contact.bodies) {
        if (sounds(bodies[body])) last = std::max(last, body);
      }
    }
  }

  const std::vector<double>& normal_force(std::size_t contact) const {
    return forces_.normal_force(contact);
  }
  const LastingForce& force(std::size_t contact) {
    if (!found_[contact]) found_[contact] = forces_.force(contact);
    return *found_[contact];
  }
  /// A body has no more use of the contact's force: the last that sounds has it dropped.
  void leave(std::size_t contact, std::size_t body) {
    if (last_[contact] == body) found_[contact].reset();
  }

 private:
  static LastingForceOptions with_rate(const MotionSoundOptions& options) {
    LastingForceOptions contacts = options.contacts;
    contacts.sample_rate = options.sample_rate;
    return contacts;
  }
  LastingForces forces_;
  std::vector<std::optional<LastingForce>> found_;
  std::vector<std::size_t> last_;  ///< of each contact's bodies that sounds
};

/// A lasting contact as one of its bodies has it.
struct TouchingContact {
  const LastingContact* contact;
  std::size_t number;
  std::size_t side;
  ContactPlaces places;
  /// Of its force, while it lasts; where there are listeners.
  std::vector<Eigen::Matrix3Xf> slow_rates = {};

  std::size_t end_step() const { return contact->first_step + contact->steps.size(); }
};

/// One body's way through a motion. Bodies come one after the other.
class BodySound {
 public:
  /// @param report  what ran is added to it
  BodySound(const Motion& motion, std::size_t body, const SoundingBody& sounding,
            std::span<const modal::Listener> listeners, const MotionSoundOptions& options,
            ContactForces& forces, MotionSound& report);
  ~BodySound();
  BodySound(const BodySound&) = delete;
  BodySound& operator=(const BodySound&) = delete;

  /// Rows as they leave the body, samples x rows.
  Eigen::MatrixXd emitted(Eigen::Index count, Eigen::Index rows);

  const MovingGains& gains() const { return gains_; }

 private:
  void follow(std::size_t step);
  std::vector<Drive> drives(std::size_t step, Eigen::Index begin, Eigen::Index size);
  void strike(double from, double to);
  void damp(std::size_t step);

  const Motion& motion_;
  std::size_t body_;
  const SoundingBody& sounding_;
  const MotionSoundOptions& options_;
  ContactForces& forces_;
  MotionSound& report_;
  modal::SurfaceSampler sampler_;
  DrivenModes modes_;
  MovingGains gains_;
  std::vector<const Impact*> impacts_;
  std::size_t struck_ = 0;
  std::vector<TouchingContact> contacts_;  ///< in order of their begin
  std::vector<TouchingContact*> acting_;   ///< those of the present step
  std::size_t begun_ = 0;
  std::vector<Eigen::MatrixX3d> held_;  ///< mode shapes where each string holds the body
  bool heard_;                          ///< by listeners, as pressure
  bool damps_ = false;
  bool rested_ = false;
};

}  // namespace carillon::synth::motion
