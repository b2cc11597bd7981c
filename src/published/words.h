// The words of a command line, one after the other, with their places for messages.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/published/line.h"

namespace noiseloom {

// Bounds of a number; both belong to it.
struct Bounds {
  double least = 0;
  double most = 0;
};

class WordReader {
 public:
  explicit WordReader(const std::vector<std::string>& words) : words_(words) {}

  bool at_end() const { return next_ == words_.size(); }
  // Requires !at_end().
  const std::string& peek() const { return words_[next_]; }
  void skip() { ++next_; }

  // The next word, of those accepted and as they are spelled there; upper and lower case are one. "" after a fault.
  // `what` is how the grammar calls it.
  std::string word(const std::string& what, const std::vector<std::string>& accepted);
  // Any text. "" after a fault.
  std::string text(const std::string& what);
  std::optional<double> number(const std::string& what, Bounds bounds);
  std::optional<std::int64_t> integer(const std::string& what, std::int64_t least, std::int64_t most);

  // About the word that was read last.
  void fault(const std::string& text);
  // About words that do not go together.
  void fault_of_line(const std::string& text);
  // About the next word: an option that nobody knows; `known` are those that it may have been meant for.
  void unknown_option(const std::vector<std::string>& known);
  // The line ends where something is missing; said once.
  void missing(const std::string& what);
  bool has_faults() const { return !faults_.empty(); }
  void throw_faults() { throw_if_any(std::move(faults_)); }

  // Takes the next word where it is an option that the published programs do not have (--print-config, --threads N...).
  bool take_extra(PublishedExtras& extras);
  static const std::vector<std::string>& extra_options();

 private:
  std::string place(std::size_t index) const;

  const std::vector<std::string>& words_;
  std::size_t next_ = 0;
  std::vector<Fault> faults_;
  bool is_short_ = false;
};

// Upper and lower case are one; the published programs' words are ASCII.
bool same_word(const std::string& a, const std::string& b);

// What all three programs take beside their own options, for help.
std::string extras_help();

}  // namespace noiseloom
