// The table of all settings: what a config may say, where each value lives in a RunConfig, and how to explain it.
//
// A row names its field once, for reading and for writing. Defaults are those of the specs themselves. Keys are
// patterns: "filter.groups[].sigma" stands for the key of any group.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "noiseloom/config/config.h"

namespace noiseloom::settings {

// size, samples, groups and axes have a reader and a writer of their own; the rest is generic.
enum class Type { boolean, integer, number, duration, word, file, table, size, samples, groups, axes };

struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;  // greater than `least`, not equal to it

  bool contains(double value) const { return (above ? value > least : value >= least) && value <= most; }
  std::string to_string() const;  // "at least 1", "greater than 0 and at most 1"; empty if unbounded
};

// A value that a key of type word accepts. `aliases`, separated by spaces, are what people call it elsewhere: they are
// not accepted, but lead to the right suggestion.
struct Word {
  std::string_view word;
  std::string_view meaning;
  std::string_view aliases = {};
};

// What a setting belongs to: the config, and one of its groups for the keys below filter.groups[].
struct Target {
  RunConfig* config = nullptr;
  GroupSpec* group = nullptr;
};

// The words of an enumeration are listed in the order of its values.
using Field = std::variant<bool*, int*, std::int64_t*, std::uint64_t*, double*, std::string*, DistanceKind*, Combine*,
                           KernelKind*, ValueKernelKind*, Method*, Precision*, Equalize*, std::vector<int>*>;

// The setting applies only where another setting has this word, or the other one.
struct Condition {
  std::string_view key = {};
  std::string_view word = {};
  std::string_view or_word = {};

  // `"anneal" or "fast"`
  std::string to_string() const;
};

struct Setting {
  std::string_view key;
  Type type = Type::number;
  std::string_view sentence;
  Field (*field)(const Target&) = nullptr;  // null for table, size, samples and groups
  Range range = {};
  std::string_view unit = {};
  std::span<const Word> words = {};
  Condition when = {};
  bool required = false;
  bool zero_is_unset = false;  // no value of its own: zero means that the config does not say

  std::string_view leaf() const { return key.substr(key.rfind('.') + 1); }
  // "integer, at least 1": what the value must be.
  std::string accepted() const;
};

// In the order of the effective config; a setting comes after the one that its condition names, except that the method
// may be asked for anywhere.
std::span<const Setting> all();
// Rows directly below the table `parent` ("" for the top level). A key may have several rows with different conditions.
std::vector<const Setting*> below(std::string_view parent);
const Setting& row(std::string_view key);

std::span<const Word> sample_words();
// Kind and channels of a word of sample_words(), and back. Not for samples from a file.
SampleSpec samples_from_word(std::string_view word);
std::string word_from_samples(const SampleSpec& samples);

// The defaults of one kernel (gauss-energy has a wider sigma than gauss).
KernelSpec default_kernel(KernelKind kind);

// The word that a field of type word holds.
std::string_view current_word(const Setting& setting, const Target& target);
bool applies(const Setting& setting, const Target& target);

// The accepted word that `found` is a misspelling or another name of, or "".
std::string suggestion(std::string_view found, std::span<const Word> words);
// `unknown kernel; did you mean "ema"? accepted: box, gauss, ...`
std::string unknown_word(std::string_view found, const Setting& setting);
// "box, gauss, binomial"
std::string list_of(std::span<const Word> words);

}  // namespace noiseloom::settings
