#pragma once

namespace carillon::core {

/// Compiled with AddressSanitizer, which reserves terabytes of address space: limits of a process's
/// memory would end it at once, and what it takes says nothing about the program.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool address_sanitizer = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool address_sanitizer = true;
#else
constexpr bool address_sanitizer = false;
#endif
#else
constexpr bool address_sanitizer = false;
#endif

}  // namespace carillon::core
