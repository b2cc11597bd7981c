// Whether every access is checked, which makes tests ten times as slow and more.
#pragma once

namespace noiseloom::testing_support {

#if defined(NOISELOOM_SANITIZE_ADDRESS) || defined(NOISELOOM_SANITIZE_THREAD)
inline constexpr bool under_sanitizers = true;
#else
inline constexpr bool under_sanitizers = false;
#endif

// How many of `count` draws are made: a tenth under sanitizers, which look for other faults than those that take many.
constexpr unsigned tried(unsigned count) { return under_sanitizers ? count / 10 : count; }

// Loops over cases that each take a process or a search go by this step: under sanitizers they try every fourth case,
// and the release build tries all.
inline constexpr int stride = under_sanitizers ? 4 : 1;

}  // namespace noiseloom::testing_support
