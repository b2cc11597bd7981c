// HDF5 identifiers that close themselves, and HDF5 failures as exceptions.
#pragma once

#include <hdf5.h>

#include <string>

namespace noiseloom::hdf5 {

// While one lives, HDF5 prints nothing on its own in this thread.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

// Throws EnvironmentError "<what>: <the error stack of HDF5>".
[[noreturn]] void fail(const std::string& what);

// The result of an HDF5 call, thrown as above where it is negative. `what` names the file and what was being done.
template <class Result>
Result checked(Result result, const std::string& what) {
  if (result < 0) fail(what);
  return result;
}

class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close closer, const std::string& what) : id_(checked(id, what)), close_(closer) {}
  ~Handle();
  Handle(Handle&& other) noexcept;
  Handle& operator=(Handle&& other) noexcept;
  hid_t id() const { return id_; }
  // The checked way to close; does nothing without an identifier.
  void close(const std::string& what);

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

}  // namespace noiseloom::hdf5
