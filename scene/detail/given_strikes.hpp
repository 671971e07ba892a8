#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace carillon::scene {

/// Strikes and forces of a CSV file with a header line. Columns: x_m, y_m, z_m (required), one of
/// impulse_ns or peak_force_n (required), contact_time_s (required), shape, dx, dy, dz. A peak
/// force F of a raised cosine of duration T is an impulse F T / 2.
/// @throws InputError  file:line: what is wrong
std::vector<GivenStrike> read_given_strikes(const std::string& path);

}  // namespace carillon::scene
