// What the tests of the config layer share.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/error.h"

namespace noiseloom {

// A config that is sound, with one line for each part so that a test can replace one and know its number.
struct ConfigText {
  std::string size = "size = { x = 7, y = 5, t = 3 }";                                    // line 2
  std::string samples = "samples = \"uniform\"";                                          // line 3
  std::string seed = "seed = 1";                                                          // line 4
  std::string combine = "combine = \"product\"";                                          // line 6
  std::string first = "{ axes = \"xy\", kernel = \"box\", size = 3 }";                    // line 8
  std::string second = "{ axes = \"t\", kernel = \"ema\", alpha = 0.1, rejection = 0 }";  // line 9
  std::string energy = "value_kernel = \"distance\"";                                     // line 12
  std::string optimizer = "stop = { iterations = 11 }";                                   // line 14

  std::string text() const {
    return "[texture]\n" + size + '\n' + samples + '\n' + seed + "\n[filter]\n" + combine + "\ngroups = [\n" + first +
           ",\n" + second + ",\n]\n[energy]\n" + energy + "\n[optimizer]\n" + optimizer + '\n';
  }
};

inline RunConfig parsed(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_config(text, "run.toml", "", overrides);
}

// "where: text" of every fault; empty if there is none.
inline std::vector<std::string> faults_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> lines;
  try {
    parsed(text, overrides);
  } catch (const UserError& error) {
    for (const Fault& fault : error.faults()) lines.push_back(fault.where + ": " + fault.text);
  }
  return lines;
}

}  // namespace noiseloom
