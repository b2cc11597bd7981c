// Any bytes as a config with overrides: they are read or refused with a message, and what was read is stored as text
// that reads back as the same. The character 0x1e, which no TOML holds, stands before each override.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/error.h"

namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

noiseloom::RunConfig parsed(const std::string& text, const std::vector<std::string>& overrides) {
  return noiseloom::parse_config(text, "fuzz.toml", "folder", overrides, noiseloom::MissingFiles::accepted);
}

[[noreturn]] void fail(const char* what, const std::string& first, const std::string& second) {
  std::fprintf(stderr, "%s\n---- first\n%s\n---- second\n%s\n", what, first.c_str(), second.c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> overrides = split(std::string(reinterpret_cast<const char*>(data), size), '\x1e');
  const std::string text = overrides.front();
  overrides.erase(overrides.begin());
  std::string stored;
  try {
    stored = noiseloom::to_toml(parsed(text, overrides));
  } catch (const noiseloom::UserError& error) {
    for (const noiseloom::Fault& fault : error.faults()) {
      if (fault.text.empty() || fault.text.size() > 2500) fail("a message of no use", fault.where, fault.text);
    }
    return 0;
  }
  std::string again;
  try {
    again = noiseloom::to_toml(parsed(stored, {}));
  } catch (const noiseloom::UserError& error) {
    fail("the stored text is refused", stored, error.what());
  }
  if (again != stored) fail("the stored text reads back as another", stored, again);
  if (!noiseloom::config_differences(stored, again).empty()) fail("equal configs differ", stored, again);
  return 0;
}

#ifndef NOISELOOM_LIBFUZZER
int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    std::ifstream in(argv[i], std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  std::printf("%d files tried\n", argc - 1);
  return argc > 1 ? 0 : 1;
}
#endif
