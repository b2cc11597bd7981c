// `TARGET --seeds FOLDER` writes the target's seeds to files of that folder; anything else is libFuzzer's command line.
#include "fuzz/seeds.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string_view>

// libFuzzer calls this first.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc != 3 || std::string_view((*argv)[1]) != "--seeds") return 0;
  const std::string folder = (*argv)[2];
  int number = 0;
  for (const std::string& seed : noiseloom::fuzz::seeds()) {
    std::ofstream out(folder + "/seed" + std::to_string(number++), std::ios::binary);
    out.write(seed.data(), static_cast<std::streamsize>(seed.size()));
    if (!out.flush()) {
      std::perror(folder.c_str());
      std::exit(1);
    }
  }
  std::exit(0);
}
