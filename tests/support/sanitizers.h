// Whether every access is checked, which makes tests ten times as slow and more.
#pragma once

namespace noiseloom::testing_support {

#if defined(NOISELOOM_SANITIZE_ADDRESS) || defined(NOISELOOM_SANITIZE_THREAD)
inline constexpr bool under_sanitizers = true;
#else
inline constexpr bool under_sanitizers = false;
#endif

}  // namespace noiseloom::testing_support
