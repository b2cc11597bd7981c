// Keys of a sampler, made by annealing so that errors of neighbouring pixels differ [Heitz19b].
//
// All pixels read one sequence, and each has two keys: one is XORed to the values of its points, the other to their
// order. First the keys of values are exchanged among pixels, so that the errors that so many points leave have
// little of low frequencies; then, for half as many points, a quarter and so on, every pixel takes one half or the
// other, which its other points do not notice. What the error of a pixel is does not depend on one integrand: it is
// taken of 64 steps, whose edges lie everywhere and, for two numbers, in all directions.
#pragma once

#include <cstdint>
#include <string>

#include "render/noises/sampler_tables.h"

namespace noiseloom::render {

// Raised whenever the same settings give other keys than before: kept keys are known by it.
constexpr int sampler_keys_algorithm = 1;

struct KeysSpec {
  int points = 16;  // of a pixel, that the keys are made for, and every power of two below: a power of two up to 256
  int numbers = 2;  // that an estimate takes of a point, one or two: these have keys that go together
  std::uint64_t seed = 1;
  int sweeps = 96;  // trials of every pixel at each step
};

// Further numbers have the same keys at other places of the tile. From the ninth on, what an order leaves out is
// another part of their sequence than what the keys were made for.
SamplerTables make_sampler_tables(const KeysSpec& spec);

// As load_sampler_tables reads it, and any compiler of C.
std::string source_text(const SamplerTables& tables, const KeysSpec& spec);
// Whether the file is such a text as it was written: its last line has the digest of the others.
bool is_whole_source_text(const std::string& path);

}  // namespace noiseloom::render
