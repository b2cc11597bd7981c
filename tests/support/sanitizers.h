// Whether every access is checked, which makes tests ten times as slow and more.
#pragma once

namespace noiseloom::testing_support {

#if defined(__has_feature)  // clang's
#define NOISELOOM_HAS_FEATURE(name) __has_feature(name)
#else
#define NOISELOOM_HAS_FEATURE(name) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || NOISELOOM_HAS_FEATURE(address_sanitizer) || \
    NOISELOOM_HAS_FEATURE(thread_sanitizer)
inline constexpr bool under_sanitizers = true;
#else
inline constexpr bool under_sanitizers = false;
#endif

}  // namespace noiseloom::testing_support
