// Any bytes as a config with overrides: they are read or refused with a message, and what was read is stored as text
// that reads back as the same. The character 0x1e, which no TOML holds, stands before each override.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "fuzz/reader_fuzz.h"
#include "noiseloom/config/config.h"

namespace noiseloom::fuzz::config {

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

RunConfig parsed(const std::string& text, const std::vector<std::string>& overrides) {
  return parse_config(text, "fuzz.toml", "folder", overrides, MissingFiles::accepted);
}

[[noreturn]] void fail(const char* what, const std::string& first, const std::string& second) {
  std::fprintf(stderr, "%s\n---- first\n%s\n---- second\n%s\n", what, first.c_str(), second.c_str());
  std::abort();
}

}  // namespace

void try_input(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> overrides = split(text_of(data, size), '\x1e');
  const std::string text = overrides.front();
  overrides.erase(overrides.begin());
  std::string stored;
  try {
    stored = to_toml(parsed(text, overrides));
  } catch (const UserError& error) {
    for (const Fault& fault : error.faults()) {
      if (fault.text.empty() || fault.text.size() > 2500) fail("a message of no use", fault.where, fault.text);
    }
    return;
  }
  std::string again;
  try {
    again = to_toml(parsed(stored, {}));
  } catch (const UserError& error) {
    fail("the stored text is refused", stored, error.what());
  }
  if (again != stored) fail("the stored text reads back as another", stored, again);
  if (!config_differences(stored, again).empty()) fail("equal configs differ", stored, again);
}

// Together they have every type of setting, every way to write a table, and overrides.
std::vector<std::string> seeds() {
  return {
      R"([texture]
size = { x = 7, y = 5, t = 3 }
samples = "uniform"
seed = 1
[filter]
combine = "sum"
groups = [ { axes = "xy", kernel = "gauss", sigma = 1.5, weight = 0.5 },
           { axes = ["t"], kernel = "ema", alpha = 0.1, rejection = 1e-3, weight = 0.5 } ]
[energy]
value_kernel = "stbn"
sigma_s = 2
[optimizer]
stop = { time = "1m10s" }
temperature = { start = 1, end = 1e-3 }
)",
      R"([texture]
size = { x = 4, y = 4, view = 2 }
[[filter.groups]]
axes = "xy"
kernel = "gauss-energy"
[optimizer]
method = "void-and-cluster"
bounded = ["view", "y"]
bits = 8
equalize = "slice"
density = 0.25
)",
      std::string(R"(texture = { size.x = 2, size.y = 2, samples = { file = "a.npy", distance = "angle" } }
filter.groups = [ { axes = "xy", kernel = "table", file = '/taps.npy' } ]
optimizer = { method = "fast", grow_fraction = false, fraction = 0.5 }
)") + "\x1etexture.seed=2\x1e" +
          "filter.groups[0]={ axes='xy', kernel='binomial', n=2 }\x1eoptimizer.stop.score=0.1",
      "\xef\xbb\xbf# all of TOML\r\n" + std::string(R"(a = """x
\u00e9"""
b = '''y'''
c = [1, [2.5e3, { d.e = 1979-05-27T07:32:00Z }]]
f = 0xff
g = -inf
"h\n" = true
[i.j]
[[k]]
)")};
}

}  // namespace noiseloom::fuzz::config
