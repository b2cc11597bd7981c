// Whether every access is checked, which makes tests ten times as slow.
#pragma once

namespace noiseloom::testing_support {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool under_sanitizers = true;
#else
inline constexpr bool under_sanitizers = false;
#endif

}  // namespace noiseloom::testing_support
