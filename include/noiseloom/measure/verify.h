// What a texture is, and what is wrong with it: made for files of others, of which nothing is known but the numbers.
//
// Every fault is one that chance or rounding makes with odds below one in a million a test, which each function states;
// what may be meant is a remark.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/quality.h"
#include "noiseloom/measure/score_file.h"

namespace noiseloom {

struct Finding {
  std::string kind;  // a word for programs: "support", "distribution", "alpha", "repeated-slices", ...
  bool is_fault = true;
  std::string text;  // a sentence for people
};

// How often each code of an integer file occurs.
struct LevelCounts {
  int bits = 0;  // 0: floats
  std::int64_t least_in_a_slice = 0;
  std::int64_t most_in_a_slice = 0;
  std::int64_t least_in_all = 0;
  std::int64_t most_in_all = 0;
  std::int64_t levels_used = 0;
};

struct Verification {
  // What it was taken for.
  SampleSpec samples;
  Extents extents;
  std::string channels;  // that hold the samples: "R, G"
  std::string why;
  std::vector<Finding> findings;
  std::vector<LevelCounts> levels;  // of each channel of the samples
  std::vector<FilterScore> scores;  // R under the filters that textures are published for
  SpectralQuality quality;
  std::optional<int> net;  // quality t of the worst slice as a net, where its codes are fine enough to tell

  bool is_sound() const;
};

// `path` is looked at for what its name says (such as "2Dx1D"); `is_given`: the config says what the values are.
Verification verify_texture(const StoredTexture& stored, const std::string& path, bool is_given, ThreadPool& pool);

std::string verification_text(const Verification& verification, const StoredTexture& stored, const std::string& path);
std::string verification_json(const Verification& verification, const StoredTexture& stored, const std::string& path);

}  // namespace noiseloom
