#include "files/hdf5_handle.h"

#include <atomic>
#include <cstdlib>
#include <utility>

#include "noiseloom/core/error.h"

namespace noiseloom::hdf5 {
namespace {

herr_t append(unsigned depth, const H5E_error2_t* entry, void* text) {
  std::string& out = *static_cast<std::string*>(text);
  if (depth > 0) out += "; ";
  out += entry->func_name ? entry->func_name : "?";
  if (entry->desc && *entry->desc) out += std::string(": ") + entry->desc;
  return 0;
}

std::atomic<bool> has_failed = false;

// Once. HDF5 would end itself at exit; where it failed inside a damaged file it may not find to an end, and says so on
// stderr. All files are closed by then, so that it has nothing to do but to give its memory back.
void end_hdf5_at_exit() {
  [[maybe_unused]] static const bool done = [] {
    H5dont_atexit();
    return std::atexit([] {
             if (!has_failed) H5close();
           }) == 0;
  }();
}

}  // namespace

Quiet::Quiet() {
  end_hdf5_at_exit();
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Quiet::~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

void fail(const std::string& what) {
  has_failed = true;
  std::string stack;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, append, &stack);  // the cause first
  H5Eclear2(H5E_DEFAULT);
  throw EnvironmentError(what + ": HDF5: " + (stack.empty() ? "no reason given" : stack));
}

Handle::~Handle() {
  if (id_ >= 0) close_(id_);
}

Handle::Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}

Handle& Handle::operator=(Handle&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(close_, other.close_);
  return *this;
}

void Handle::close(const std::string& what) {
  if (id_ >= 0) checked(close_(std::exchange(id_, -1)), what);
}

}  // namespace noiseloom::hdf5
