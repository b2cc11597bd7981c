// `fuzz --target=NAME --seeds=FOLDER` writes the target's seeds to files of that folder. `fuzz --target=NAME` and
// anything else is libFuzzer's command line, which leaves words with two dashes to us: `fuzz --target=npy FILE` tries
// one file.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

// Each target: what is made of an input, and small sound inputs to begin with.
#define NOISELOOM_FUZZ_TARGET(name)                           \
  namespace noiseloom::fuzz::name {                           \
  void try_input(const std::uint8_t* data, std::size_t size); \
  std::vector<std::string> seeds();                           \
  }
NOISELOOM_FUZZ_TARGET(config)
NOISELOOM_FUZZ_TARGET(hdf5_array)
NOISELOOM_FUZZ_TARGET(image)
NOISELOOM_FUZZ_TARGET(npy)
NOISELOOM_FUZZ_TARGET(raw)
NOISELOOM_FUZZ_TARGET(run_file)
NOISELOOM_FUZZ_TARGET(texture)
#undef NOISELOOM_FUZZ_TARGET

namespace noiseloom::fuzz {
namespace {

struct Target {
  std::string_view name;
  void (*try_input)(const std::uint8_t*, std::size_t);
  std::vector<std::string> (*seeds)();
};
constexpr Target targets[] = {
    {"config", config::try_input, config::seeds},
    {"hdf5_array", hdf5_array::try_input, hdf5_array::seeds},
    {"image", image::try_input, image::seeds},
    {"npy", npy::try_input, npy::seeds},
    {"raw", raw::try_input, raw::seeds},
    {"run_file", run_file::try_input, run_file::seeds},
    {"texture", texture::try_input, texture::seeds},
};
const Target* chosen = nullptr;

[[noreturn]] void write_seeds(const std::string& folder) {
  int number = 0;
  for (const std::string& seed : chosen->seeds()) {
    std::ofstream out(folder + "/seed" + std::to_string(number++), std::ios::binary);
    out.write(seed.data(), static_cast<std::streamsize>(seed.size()));
    if (!out.flush()) {
      std::perror(folder.c_str());
      std::exit(1);
    }
  }
  std::exit(0);
}

}  // namespace
}  // namespace noiseloom::fuzz

// libFuzzer calls this first.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  using namespace noiseloom::fuzz;
  constexpr std::string_view target_option = "--target=";
  constexpr std::string_view seeds_option = "--seeds=";
  std::string folder;
  for (int k = 1; k < *argc; ++k) {
    const std::string_view word = (*argv)[k];
    if (word.starts_with(seeds_option)) folder = word.substr(seeds_option.size());
    if (!word.starts_with(target_option)) continue;
    for (const Target& target : targets) {
      if (target.name == word.substr(target_option.size())) chosen = &target;
    }
  }
  if (chosen == nullptr) {
    std::fputs("--target=NAME is missing; accepted:", stderr);
    for (const Target& target : targets) std::fprintf(stderr, " %s", target.name.data());
    std::fputs("\n", stderr);
    std::exit(2);
  }
  if (!folder.empty()) write_seeds(folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  noiseloom::fuzz::chosen->try_input(data, size);
  return 0;
}

// HDF5 1.10 loses some hundred bytes of its own where it gives a damaged file up.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }
