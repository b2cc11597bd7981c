// What is tidied up while a failure is on its way must not hide it by another.
#pragma once

#include <exception>

namespace noiseloom {

template <class Action>
void attempt(Action action) noexcept {
  try {
    action();
  } catch (const std::exception&) {
  }
}

}  // namespace noiseloom
