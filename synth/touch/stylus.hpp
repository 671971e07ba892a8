#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "render/maps/surface_map.hpp"
#include "synth/motion/motion.hpp"
#include "synth/motion/traced_face.hpp"

namespace carillon::synth::touch {

/// A pen whose tip a hand draws over a face. The tip is a mass; a spring and a damper hold it to
/// where the hand is.
struct Stylus {
  double mass = 0.02;       ///< of the tip and what moves with it [kg]
  double radius = 0;        ///< of the tip [m]; reliefs are traced by it, normal maps are not
  double hold = 1000;       ///< spring between hand and tip [N/m]
  double hold_damping = 9;  ///< [N s/m]
  /// Force of the hand towards the face [N]. Where it is positive the hand holds the tip along the
  /// face only, and presses, as long as the tip is over the face; else, and at 0, it holds it in
  /// all directions.
  double press = 1;
  double stiffness = 5000;     ///< penalty spring of the face [N/m]
  double damping = 5;          ///< of it [N s/m]
  double friction = 0;         ///< Coulomb's, of tip and face
  double largest_force = 7.9;  ///< of the face on the tip [N] (a PHANToM Desktop's)
};

struct TouchOptions {
  double rate = 1000;                               ///< of the force vectors [Hz]
  std::shared_ptr<motion::TracedMaps> traced = {};  ///< kept from motion to motion; null: made anew
};

/// What a drawn stylus felt, at every tick.
struct Touch {
  double rate = 0;            ///< [Hz]
  std::vector<Vec3> hand;     ///< where the hand is [m], the face's body's coordinates
  std::vector<Vec3> tip;      ///< where the tip is [m]
  std::vector<Vec3> forces;   ///< of the face on the tip, mean over the tick, as shown [N]
  std::size_t held_back = 0;  ///< ticks in which the spring pushed by less than 0.9 k D
  std::size_t limited = 0;    ///< ticks whose force was shortened to the largest
};

/// A path of straight lines at a constant speed, to its end: positions of the hand at every tick.
/// @param corners  [m], the body's coordinates
/// @param speed    [m/s]
/// @throws InputError  no corners, one that is not finite, a speed that is not positive, a path of
///                     more than ten million ticks
std::vector<Vec3> drawn_path(std::span<const Vec3> corners, double speed, double rate);

/// Draws a stylus over a textured face (dissertation 5.2.4 and 5.3.2).
///
/// The tip is projected onto the face along the face's normal; there the map's normal n_s gives the
/// haptic plane n_s . x = n_s . p (eq. 5.3), p on the flat face for a normal map and on the relief
/// for a relief, where there is contact only below its depth. Beneath the plane a penalty spring
/// and damper push along n_s, and never pull. With D the depth of the tip under p along the face's
/// normal, the force is k D / n_s.z: its part along the face's normal is k D however steep the map
/// is, and on a relief it is the slope of the potential k D^2 / 2. (Of the depth under the plane, D
/// n_s.z, it would not be, and the tip would gain energy between the sides of a valley.) Forces are
/// shortened to the largest where they are shown alone: the tip does not sink into the face for it.
///
/// The mass moves by implicit Euler steps in which the plane stands still, at least 8,000 a second
/// (512 a tick at most) and as many as keep the way of a step to a quarter of a texel (512 a tick
/// at most), so that no spring can make it unstable. What is left of planes that change within a
/// step, and of normal maps, which have no potential, is bounded: an account is kept of what the
/// face took and may give back (Hannaford and Ryu 2002), never more than the potential at this
/// moment, so that nothing taken long ago is a licence (Ryu, Preusche, Hannaford and Hirzinger
/// 2005). Friction, which takes all the time, is not counted. The spring is compressed by no more
/// than the account pays for.
///
/// On a relief the account is of the spring alone, without its damper, and the potential is
/// k D^2 / 2. On a normal map it is of spring and damper: together they hold the press (or, where
/// that is 0, what the hand's spring presses with), and so the potential is k D^2 / 2 and the press
/// times the integrated height above its lowest, which the tip brings along when it comes to the
/// face. (The spring alone gives downhill what the damper takes uphill, at any speed.) Where the
/// account is empty the tip goes down and up with these heights, as on a relief.
///
/// Beside the face's rectangle the hand holds the tip in all directions and does not press; what
/// comes back below the surface meets a spring that is compressed by nothing.
///
/// @param hand  of every tick [m], the body's coordinates; the tip begins there, or on the
///              surface above
/// @throws InputError  no path, one that is not finite, values that cannot be
Touch draw_stylus(const render::maps::TexturedFace& face, std::span<const Vec3> hand,
                  const Stylus& stylus, const TouchOptions& options);

/// The motion of a drawn stylus, to be heard: body 0 is the stylus, body 1 the face's, at rest in
/// the world's coordinates. Its lasting contacts are where the face pushes.
motion::Motion motion_of(const Touch& touch, const render::maps::TexturedFace& face);

/// The stylus as a body of that motion.
motion::MovingBody moving_stylus(const Stylus& stylus);

}  // namespace carillon::synth::touch
