#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "synth/motion/contact_path.hpp"
#include "synth/motion/fractal_noise.hpp"
#include "synth/motion/motion.hpp"
#include "synth/motion/traced_face.hpp"

namespace carillon::synth::motion {

/// What drives the modes of bodies in lasting contact.
enum class ContactExcitation {
  height_profile,   ///< the map's heights along the way, and fractal noise below them
  texel_impulses,   ///< the papers' for normal maps: a step of momentum at each new texel (eq. 5.4)
  solver_impulses,  ///< the papers' for reliefs: the motion's own forces, step by step
};

struct LastingForceOptions {
  ContactExcitation excitation = ContactExcitation::height_profile;
  double sample_rate = 44100;  ///< [Hz]
  double smoothing = 0.05;     ///< window over normal forces [s], against the solver's chatter
  bool map = true;             ///< of height_profile: the textured faces
  double roughness = 0.05;  ///< of height_profile: rms of the fractal force over the normal force
  double exponent = 1.7;    ///< of the fractal roughness: power over wave number
  double longest = 1e-3;    ///< fractal wave where no map is [m]; a map's texel where there is one
  double edge_radius = 1e-3;                ///< of what touches where a body has no curvature [m]
  std::uint64_t seed = 0;                   ///< of the fractal roughness
  std::shared_ptr<TracedMaps> traced = {};  ///< kept from motion to motion; null: made anew
};

/// Force of a lasting contact at audio rate, without its slow mean (that of the geometry, which by
/// itself makes no sound).
struct LastingForce {
  std::size_t first_sample = 0;  ///< of a clip that begins with the motion
  Eigen::Matrix3Xd force;        ///< on the first body, world axes [N]
};

/// Forces of the lasting contacts of a motion.
///
/// With z(t) the height, along the contact's way, of the textured face as the other body's rounded
/// part traces it, averaged over the patch of contact (Hertz: a^3 = 3 F R / (4 E*)) and over the
/// way between two samples, and m the bodies' reduced mass (shared by the contacts of a pair as
/// they share the force): normal force F + m z'' as long as the bodies touch, 0 while that is
/// negative; along the face -slope times the normal force, and Coulomb's friction of what it adds
/// to F. z'' = v . H v + slope . v', so it goes with the square of the speed. Places of bodies with
/// corners hop; the way between is gone at no more than 1.25 times the speed of sliding and
/// turning. Below the texel both faces add roughness times F times their fractal noise at the place
/// of contact, along the normal and, times friction, across. What creeps slower than 0.1 mm/s rests
/// and makes nothing. Contacts fade in and out over 5 ms: their strikes are the impacts.
class LastingForces {
 public:
  /// @param bodies  of the motion
  /// @throws InputError  sizes that do not match, options that cannot be
  LastingForces(const Motion& motion, std::span<const MovingBody> bodies,
                const LastingForceOptions& options);

  /// @param contact  its number in the motion
  LastingForce force(std::size_t contact);

  /// Smooth normal force of a contact's steps [N].
  const std::vector<double>& normal_force(std::size_t contact) const { return normal_[contact]; }

 private:
  struct Side;
  /// What a contact feels of one of its surfaces.
  struct Felt {
    double rise = 0;           ///< z'' [m/s^2]
    Vec3 lean = Vec3::Zero();  ///< force along the face on the first body, per normal force
    double noise = 0, cross_noise = 0;
  };

  LastingForce silence(const LastingContact& contact) const;
  Side side_of(const LastingContact& contact, std::size_t side);
  Felt feel(const LastingContact& contact, std::size_t side, const Side& own, double force,
            double time) const;
  const TracedFace& face_of(std::size_t body, double radius);
  double radius_of(std::size_t body) const;
  double reduced_mass(const LastingContact& contact) const;
  void add_profile(std::size_t contact, LastingForce& result);
  void add_texel_impulses(std::size_t contact, LastingForce& result);
  void add_solver_impulses(std::size_t contact, LastingForce& result) const;
  void add_impulse(const Vec3& impulse, double time, LastingForce& result) const;

  const Motion& motion_;
  std::span<const MovingBody> bodies_;
  LastingForceOptions options_;
  std::vector<std::vector<double>> normal_;  ///< of each contact, each step
  std::vector<std::vector<double>> share_;   ///< of its pair's normal force
  std::map<std::pair<std::size_t, double>, TracedFace> faces_;
};

}  // namespace carillon::synth::motion
