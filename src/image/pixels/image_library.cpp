#include "image/pixels/image_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// Without a folder: it is looked for where the program says that its libraries are (its run path), then where the
// system has its own.
constexpr const char* module_name = "noiseloom-images.so";

// The libraries start threads while they are loaded, and where there is too little address space for these (ulimit -v),
// one of them aborts without a word of what is missing.
void require_address_space() {
  constexpr rlim_t wanted = 450'000'000;
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t used = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
  if (limit.rlim_cur >= used + wanted) return;
  constexpr rlim_t megabyte = 1'000'000;
  throw EnvironmentError(
      fmt::format("out of memory: this shell allows a process {} MB of address space (ulimit -v), {} MB are used, and "
                  "the libraries that read and write images take about {} more; accepted: {} MB and more",
                  limit.rlim_cur / megabyte, used / megabyte, wanted / megabyte, (used + wanted) / megabyte + 1));
}

const ImageLibrary* load() {
  require_address_space();
  const auto fail = [] {
    const char* const words = ::dlerror();
    throw EnvironmentError(std::string("the library that reads and writes images cannot be loaded: ") +
                           (words == nullptr ? "no reason was given" : words));
  };
  // Never unloaded: some of the libraries it brings have threads and objects of their own until the end.
  void* const module = ::dlopen(module_name, RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) fail();
  void* const function = ::dlsym(module, image_library_function);
  if (function == nullptr) fail();
  return reinterpret_cast<ImageLibraryFunction>(function)();
}

}  // namespace

const ImageLibrary& image_library() {
  static const ImageLibrary* const library = load();
  return *library;
}

}  // namespace noiseloom
