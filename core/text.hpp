#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace carillon::core {

/// Without blanks and line breaks at either end.
std::string_view trimmed(std::string_view text);

/// The number that a text is, in every locale alike: nothing where it is anything else or more, or
/// beyond the type's range. Infinities and NaN are numbers. Defined for double and std::int64_t.
template <class Number>
std::optional<Number> number_in(std::string_view text);

/// `a=1,b=2` as pairs in order.
/// @throws InputError  a part without '='
std::vector<std::pair<std::string, std::string>> parse_assignments(const std::string& text);

/// A limit of memory as whole bytes.
/// @param bytes  as core::parse_quantity reads it
/// @throws InputError  below 1 B or above 1 EiB
std::int64_t whole_bytes(double bytes);
/// The same from an option's text, "4 GiB"; errors name the option.
std::int64_t memory_limit(const std::string& text, const std::string& option);

/// A name as part of a file's name: letters, digits, '.', '-' and '_' stay, the rest becomes '_'
/// and a short hash keeps different names apart. Never empty, never more than 80 characters.
std::string file_safe(const std::string& name);

/// The command as it was typed, arguments quoted where a shell would need it; control characters
/// become blanks.
std::string typed_command(int argc, const char* const* argv);

}  // namespace carillon::core
