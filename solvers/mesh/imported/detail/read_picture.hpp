#pragma once

#include <string>
#include <string_view>

#include "core/image.hpp"

namespace carillon::solvers::mesh::imported {

/// A PNG or JPEG file as three channels of 8 bits, sRGB.
/// @param name  for messages
/// @throws InputError  another format, damaged, or above 64 megapixels
core::Image read_picture(const std::string& name, std::string_view bytes);

}  // namespace carillon::solvers::mesh::imported
